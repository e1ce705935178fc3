// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/continuation.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "physics/cloth/assembly/scene_self_contact.h"
#include "physics/simulation/statics/modes.h"

namespace drape {
namespace {

double LargestMove(const Eigen::VectorXd& dx) {
  return dx.reshaped(3, dx.size() / 3).colwise().norm().maxCoeff();
}

// NaN where it is not found.
double LowestStiffness(StepSolver& solver, const MaterialField& material,
                       const Eigen::VectorXd& x) {
  const Eigen::VectorXd lowest = LowestEigenvalues(solver, material, x, 1);
  return lowest.size() == 0 ? std::nan("") : lowest[0];
}

// Zero of 1/speed² on the line through two points.
std::optional<double> FoldEstimate(const std::vector<ContinuationPoint>& points) {
  if (points.size() < 2) return {};
  const ContinuationPoint &before = points[points.size() - 2], &last = points.back();
  const double first = std::pow(before.speed, -2), second = std::pow(last.speed, -2);
  if (!(first > second)) return {};
  return last.s + (last.s - before.s) * second / (first - second);
}

class BranchFollower {
 public:
  BranchFollower(StepSolver& solver, const MaterialParametrisation& parametrisation,
                 const Eigen::VectorXd& direction, const ContinuationOptions& options)
      : solver_(solver),
        parametrisation_(parametrisation),
        direction_(direction),
        options_(options),
        step_(options.first_step) {}

  ContinuationResult Run(const Eigen::VectorXd& x) {
    if (!Start(x)) return std::move(result_);
    while (result_.points.back().s != options_.end) {
      if (!FindTangent()) return Lost("no derivative at the last point");
      while (!Advance()) {
        if (result_.status == ContinuationStatus::kCancelled) return std::move(result_);
        step_ *= 0.5;
        if (step_ < options_.min_step) return Lost(refusal_);
      }
    }
    FindTangent();
    result_.status = ContinuationStatus::kReachedEnd;
    return std::move(result_);
  }

 private:
  MaterialField MaterialAt(double s) const { return parametrisation_.Material(s * direction_); }

  bool Start(const Eigen::VectorXd& x) {
    result_.lost_at = options_.end;
    const EquilibriumResult rest =
        SolveEquilibrium(solver_, MaterialAt(0.0), x, options_.corrector);
    if (rest.status == EquilibriumStatus::kCancelled)
      result_.status = ContinuationStatus::kCancelled;
    if (rest.status != EquilibriumStatus::kStable) return false;
    Accept(0.0, rest, 0.0);
    return true;
  }

  void Accept(double s, const EquilibriumResult& rest, double error) {
    ContinuationPoint point;
    point.s = s;
    point.x = rest.x;
    point.prediction_error = error;
    point.newton_iterations = rest.iterations;
    point.stiffness = LowestStiffness(solver_, MaterialAt(s), rest.x);
    result_.points.push_back(std::move(point));
  }

  // ∂x/∂s at the last point.
  bool FindTangent() {
    ContinuationPoint& point = result_.points.back();
    const MaterialField material = MaterialAt(point.s);
    const MaterialField change = parametrisation_.Jvp(material, direction_);
    if (!EquilibriumJvpColumn(solver_, material, change, point.x, &tangent_)) return false;
    point.speed = tangent_.norm() / std::sqrt(static_cast<double>(tangent_.size()) / 3.0);
    return true;
  }

  // One step of length step_ or to the end. False when it is rejected.
  bool Advance() {
    const ContinuationPoint& from = result_.points.back();
    const double rest = options_.end - from.s;
    const double s = std::abs(rest) <= step_ ? options_.end : from.s + std::copysign(step_, rest);
    const Eigen::VectorXd predicted = from.x + (s - from.s) * tangent_;
    const EquilibriumResult drape =
        SolveEquilibrium(solver_, MaterialAt(s), ReachSafely(solver_.model(), from.x, predicted),
                         options_.corrector);
    const double error = LargestMove(drape.x - predicted);
    if (drape.status == EquilibriumStatus::kCancelled) {
      result_.status = ContinuationStatus::kCancelled;
    } else if (drape.status != EquilibriumStatus::kStable) {
      refusal_ = ToString(drape.status);
    } else if (error > options_.max_error) {
      refusal_ = "jump to another branch";
    } else {
      Accept(s, drape, error);
      LengthenStep(error);
      return true;
    }
    ++result_.refused;
    result_.lost_at = s;
    return false;
  }

  // The prediction's error is of second order in the step: aims at a quarter of what is allowed.
  void LengthenStep(double error) {
    const double factor = std::sqrt(0.25 * options_.max_error / std::max(error, 1e-12));
    step_ = std::min(options_.max_step, step_ * std::clamp(factor, 0.5, 2.0));
    step_ = std::max(step_, options_.min_step);
  }

  ContinuationResult Lost(const std::string& because) {
    result_.status = ContinuationStatus::kFold;
    result_.lost_because = because;
    result_.fold_estimate = FoldEstimate(result_.points);
    return std::move(result_);
  }

  StepSolver& solver_;
  const MaterialParametrisation& parametrisation_;
  const Eigen::VectorXd direction_;
  const ContinuationOptions& options_;
  double step_;
  Eigen::VectorXd tangent_;
  std::string refusal_;
  ContinuationResult result_;
};

}  // namespace

void ContinuationOptions::Check() const {
  CHECK(std::isfinite(end) && end != 0.0) << end;
  CHECK(min_step > 0.0 && min_step <= first_step && first_step <= max_step);
  CHECK_GT(max_error, 0.0);
}

const char* ToString(ContinuationStatus status) {
  switch (status) {
    case ContinuationStatus::kReachedEnd:
      return "reached the end";
    case ContinuationStatus::kFold:
      return "the branch ends";
    case ContinuationStatus::kNoStart:
      return "no stable drape at the start";
    case ContinuationStatus::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

ContinuationResult FollowBranch(StepSolver& solver, const MaterialParametrisation& parametrisation,
                                const Eigen::VectorXd& direction, const Eigen::VectorXd& x,
                                const ContinuationOptions& options) {
  options.Check();
  CHECK_EQ(direction.size(), parametrisation.size());
  return BranchFollower(solver, parametrisation, direction, options).Run(x);
}

}  // namespace drape
