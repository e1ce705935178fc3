// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/material_gradient.h"

#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// A material whose every entry is 1: ∂/∂entry itself.
MaterialField Ones() {
  MaterialField ones;
  ones.stretch.resize(1);
  ones.bend.resize(1);
  for (auto& row : ones.stretch[0].c) std::fill(std::begin(row), std::end(row), 1.0);
  for (auto& row : ones.bend[0].b) std::fill(std::begin(row), std::end(row), 1.0);
  return ones;
}

Json Tables(const Eigen::VectorXd& entries) {
  Json stretch = Json::array(), bend = Json::array();
  for (int c = 0; c < kStretchCols; ++c)
    for (int r = 0; r < kStretchRows; ++r) stretch[c][r] = entries[r * kStretchCols + c];
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) bend[r][c] = entries[kStretchEntries + r * kBendCols + c];
  return {{"stretch", stretch}, {"bend", bend}};
}

std::vector<double> List(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

}  // namespace

RolloutGradient DifferentiateRollout(Backend& backend, const MaterialField& material,
                                     const State& start, const RolloutOptions& options,
                                     const Eigen::VectorXd& w) {
  RolloutGradient gradient;
  const RolloutInput input{&material, &start};
  std::vector<Recording> recordings;
  const RolloutResult rollout = backend.Rollouts({&input, 1}, options, &recordings)[0];
  gradient.status = rollout.status;
  if (gradient.status != RolloutStatus::kOk) return gradient;
  gradient.loss = w.dot(rollout.end.x);
  const RowMatrix seed = w;
  const AdjointResult adjoint = backend.Adjoints({&input, 1}, recordings, {&seed, 1}, options)[0];
  gradient.status = adjoint.status;
  if (gradient.status != RolloutStatus::kOk) return gradient;
  const MaterialField ones = Ones();
  const MaterialField* const weight = &ones;
  gradient.adjoint = adjoint.material.Contract(ones);
  gradient.x0 = adjoint.x0;
  gradient.v0 = adjoint.v0;
  const TangentResult tangent = backend.Tangents({&input, 1}, {&weight, 1}, options)[0];
  gradient.status = tangent.rollout.status;
  gradient.tangent = tangent.dx.transpose() * w;
  return gradient;
}

Eigen::VectorXd ReadLossWeights(const std::string& path, int num_dofs) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  const JsonInput w = input.ExpectKeys({"w"}).At("w").ExpectArray();
  if (w.Size() != num_dofs) {
    w.Fail("an array of " + std::to_string(num_dofs) + ", three numbers for each vertex");
  }
  Eigen::VectorXd weights(num_dofs);
  for (int i = 0; i < num_dofs; ++i) weights[i] = w.At(i).Number();
  return weights;
}

void WriteLossGradient(const std::string& path, const RolloutGradient& gradient) {
  const Json json = {{"L", gradient.loss},
                     {"convention", "arcsim"},
                     {"adjoint", Tables(gradient.adjoint)},
                     {"tangent", Tables(gradient.tangent)},
                     {"v0", List(gradient.v0)},
                     {"x0", List(gradient.x0)}};
  WriteFileAtomically(path, json.dump(1) + "\n");
}

}  // namespace drape
