// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/gradient_io.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// ∂L/∂(number of a mechanical material file) of ∂L/∂(table entry), shape [39]: such a number is
// kMembranePerEntry × a stretch entry, or a bend entry / kBendPerRigidity.
Json Tables(const Eigen::VectorXd& entries) {
  Json stretch = Json::array(), bend = Json::array();
  for (int r = 0; r < kStretchRows; ++r)
    for (int c = 0; c < kStretchCols; ++c)
      stretch[r][c] = entries[r * kStretchCols + c] / kMembranePerEntry;
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c)
      bend[r][c] = entries[kStretchEntries + r * kBendCols + c] * kBendPerRigidity;
  return {{"stretch", stretch}, {"bend", bend}};
}

std::vector<double> List(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

}  // namespace

Eigen::VectorXd ReadLossWeights(const std::string& path, int num_dofs) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  const JsonInput w = input.ExpectKeys({"w"}).At("w").ExpectArray();
  if (w.Size() != num_dofs) {
    w.Fail("an array of " + std::to_string(num_dofs) + ", three numbers for each vertex");
  }
  Eigen::VectorXd weights(num_dofs);
  constexpr double kMost = 1e30;  // no sum of them overflows
  for (int i = 0; i < num_dofs; ++i) weights[i] = w.At(i).NumberWithin(-kMost, kMost);
  return weights;
}

void WriteLossGradient(const std::string& path, const RolloutGradient& gradient) {
  const Json json = {{"format", "drapefit-gradient"},
                     {"version", 1},
                     {"convention", "mechanical"},
                     {"L", gradient.loss},
                     {"adjoint", Tables(gradient.adjoint)},
                     {"tangent", Tables(gradient.tangent)},
                     {"v0", List(gradient.v0)},
                     {"x0", List(gradient.x0)}};
  WriteFileAtomically(path, json.dump(1) + "\n");
}

}  // namespace drape
