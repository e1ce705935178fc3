// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "physics/material/material.h"

namespace drape {

// A quantity of a drape in each face.
struct FaceField {
  std::string name;
  std::vector<std::string> components;
  std::string unit;
  std::vector<double> values;  // shape [F, components]
};

// strain: Green strain uu, vv, uv; tension: stress uu, vv, uv of [MODEL, M10] [N/m]; stiffness:
// c11, c12, c22, c33 at that strain [N/m]; rigidity: mean D of the face's hinges at zero angle
// [N·m], 0 where it has none. x: [m], shape [3V].
std::vector<FaceField> ComputeFaceFields(const ClothModel& model, const MaterialField& material,
                                         const Eigen::VectorXd& x);

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
