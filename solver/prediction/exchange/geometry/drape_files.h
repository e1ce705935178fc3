// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/mesh/mesh.h"
#include "solver/prediction/exchange/geometry/drape_fields.h"

namespace drape {

// A drape with its fields as files of other programs. All are written atomically and throw
// InputError when that fails. x: [m], shape [3V].

// VTK XML, for ParaView: numbers as text that reads back bit for bit; point data `rest` (u, v, 0),
// cell data the fields.
void WriteVtu(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::vector<FaceField>& fields);

// A series of such files, relative to `path`, each with its time [s].
struct TimedFile {
  double time = 0.0;
  std::string file;
};
void WritePvd(const std::string& path, const std::vector<TimedFile>& files);

// Binary glTF 2.0 in float32, for the web and other viewers: y is up there, by the rotation of the
// node. Vertices have normals, COLOR_0 by `face_values` (shape [F], blue at 0 to red at the 98th
// percentile), _VALUE (the mean of the values of their faces by area) and TEXCOORD_0, the rest
// coordinates (u, v) in metres. name: of the values, for the file's extras.
void WriteGlb(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::string& name, const std::vector<double>& face_values);

}  // namespace drape
