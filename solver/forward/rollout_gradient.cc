// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/rollout_gradient.h"

#include <algorithm>
#include <vector>

namespace drape {
namespace {

// A material whose every entry is 1: ∂/∂entry itself.
MaterialField Ones() {
  MaterialField ones;
  ones.stretch.resize(1);
  ones.bend.resize(1);
  for (auto& row : ones.stretch[0].c) std::fill(std::begin(row), std::end(row), 1.0);
  for (auto& row : ones.bend[0].b) std::fill(std::begin(row), std::end(row), 1.0);
  return ones;
}

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

}  // namespace drape
