// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_study.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

class Line {
 public:
  Line(Backend& backend, const MaterialParametrisation& line, const State& start,
       SolveMode integrator, const RolloutOptions& rollout)
      : backend_(backend), line_(line), start_(start), integrator_(integrator), rollout_(rollout) {}

  MaterialField At(double s) const { return line_.Material(Eigen::VectorXd::Constant(1, s)); }

  // Empty where it fails.
  Eigen::VectorXd Shape(double s) const {
    const MaterialField material = At(s);
    const RolloutInput input{&material, &start_};
    if (integrator_ == SolveMode::kDynamic) {
      RolloutResult end = backend_.Rollouts({&input, 1}, rollout_, nullptr).front();
      return end.status == RolloutStatus::kOk ? end.end.x : Eigen::VectorXd();
    }
    EquilibriumResult rest = backend_.Equilibria({&input, 1}, {}).front();
    return rest.status == EquilibriumStatus::kStable ? rest.x : Eigen::VectorXd();
  }

  Eigen::VectorXd Tangent() const {
    const MaterialField material = At(0.0);
    const MaterialField* weight = &material;
    State place = start_;
    if (integrator_ == SolveMode::kStatic) place.x = Shape(0.0);
    if (place.x.size() == 0) return {};
    const RolloutInput input{&material, &place};
    const RowMatrix by_entries =
        integrator_ == SolveMode::kStatic
            ? backend_.EquilibriumTangents({&input, 1}, {&weight, 1}).front()
            : backend_.Tangents({&input, 1}, {&weight, 1}, rollout_).front().dx;
    if (by_entries.size() == 0) return {};
    return by_entries * line_.LogEntriesByTheta(Eigen::VectorXd::Zero(1));
  }

 private:
  Backend& backend_;
  const MaterialParametrisation& line_;
  const State& start_;
  SolveMode integrator_;
  const RolloutOptions& rollout_;
};

double RmsOfVertices(const Eigen::VectorXd& x) {
  return x.norm() / std::sqrt(static_cast<double>(x.size()) / 3.0);
}

}  // namespace

std::vector<GradientError> CompareDifferences(Backend& backend, const MaterialParametrisation& line,
                                              const State& start, SolveMode integrator,
                                              const RolloutOptions& rollout,
                                              std::span<const double> steps) {
  CHECK_EQ(line.size(), 1);
  const Line drapes(backend, line, start, integrator, rollout);
  const Eigen::VectorXd tangent = drapes.Tangent();
  std::vector<GradientError> errors;
  if (tangent.size() == 0) return errors;
  for (const double step : steps) {
    const Eigen::VectorXd above = drapes.Shape(step), below = drapes.Shape(-step);
    GradientError error{step, RmsOfVertices(tangent), std::nan("")};
    if (above.size() > 0 && below.size() > 0)
      error.error = ((above - below) / (2.0 * step) - tangent).norm() / tangent.norm();
    errors.push_back(error);
  }
  return errors;
}

std::optional<FoldApproach> FindFoldApproach(const ContinuationResult& path, double range) {
  if (path.status != ContinuationStatus::kFold || !path.fold_estimate) return {};
  FoldApproach approach;
  const double largest = path.points.back().speed;
  for (const ContinuationPoint& point : path.points) {
    const double distance = std::abs(*path.fold_estimate - point.s);
    if (point.speed * range < largest || !(point.stiffness > 0.0) || distance == 0.0) continue;
    approach.distance.push_back(distance);
    approach.stiffness.push_back(point.stiffness);
    approach.speed.push_back(point.speed);
  }
  approach.speed_by_distance = FitPowerLaw(approach.distance, approach.speed);
  approach.speed_by_stiffness = FitPowerLaw(approach.stiffness, approach.speed);
  return approach;
}

}  // namespace drape
