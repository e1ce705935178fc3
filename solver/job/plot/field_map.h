// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/mesh/mesh.h"

namespace drape {

struct FieldMapOptions {
  std::string title;
  std::string unit;  // of the colour bar, with the quantity
};

// Writes a PNG of a number of each element in the plane of the cloth, as colours with a colour bar
// (as [Gong 2024, fig. 1, 2]): of faces, shape [F], or of hinges, shape [E], each drawn as the
// kite of its edge and the centroids beside it. Throws InputError when gnuplot is not installed or
// the file cannot be written.
void RenderFaceMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_face,
                   const FieldMapOptions& options);
void RenderHingeMap(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& of_hinge,
                    const FieldMapOptions& options);

}  // namespace drape
