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

}  // namespace drape
