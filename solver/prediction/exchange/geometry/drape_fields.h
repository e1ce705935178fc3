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

}  // namespace drape
