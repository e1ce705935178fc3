// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/lab_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "solver/fit/parametrisation.h"

namespace drape {
namespace {

// The fit of motions begins at the best of so many scales about the start tables, and at those; two
// scales on stretch, or on bend, are this factor apart.
constexpr int kBestScales = 2;
constexpr double kScaleFactor = 4.0;

bool IsCancelled(const FitOptions& options) {
  return options.trust_region.cancel != nullptr && options.trust_region.cancel->load();
}

void AddStartVelocity(const Eigen::Vector3d& change, FitProblem& problem) {
  for (SettledExperiment& each : problem.further)
    if (each.experiment->motion) each.start.v += change.replicate(each.start.v.size() / 3, 1);
}

// Points from which scales are fitted, the first numbers of θ: the present one, and where cloth
// moves the best of a grid about it, since the misfit of a motion has minima beside the fabric.
std::vector<Eigen::VectorXd> ListScales(RolloutResiduals& residuals, int scales, bool moves,
                                        const FitOptions& options) {
  Eigen::Map<Eigen::VectorXd> theta(residuals.theta(), residuals.num_parameters());
  std::vector<Eigen::VectorXd> points = {theta};
  if (!moves) return points;
  std::multimap<double, Eigen::VectorXd> by_cost;
  for (const double stretch : {-1.0, 0.0, 1.0})
    for (const double bend : {-1.0, 0.0, 1.0}) {
      const Eigen::Vector2d step = std::log(kScaleFactor) * Eigen::Vector2d(stretch, bend);
      if (step.isZero() || (scales == 1 && stretch != 0.0) || IsCancelled(options)) continue;
      theta = points.front();
      theta.head(scales) += step.tail(scales);
      residuals.PrepareForEvaluation(false, true);
      if (!residuals.all_valid()) continue;
      double cost = 0.5 * theta.squaredNorm() / (options.prior_sigma * options.prior_sigma);
      for (int i = 0; i < residuals.num_blocks(); ++i) cost += residuals.cost(i);
      by_cost.emplace(cost, theta);
    }
  for (const auto& [cost, point] : by_cost)
    if (static_cast<int>(points.size()) <= kBestScales) points.push_back(point);
  return points;
}

// The best fit of scales from each of their starts.
FitSummary FitScales(const RolloutResiduals& residuals, int scales, bool moves,
                     const FitOptions& options) {
  RolloutResiduals trial = residuals;
  const std::vector<Eigen::VectorXd> points = ListScales(trial, scales, moves, options);
  RolloutCounts counts = trial.counts();
  double seconds = 0.0;
  FitSummary best;
  for (const Eigen::VectorXd& point : points) {
    RolloutResiduals own = residuals;
    Eigen::Map<Eigen::VectorXd>(own.theta(), point.size()) = point;
    FitSummary fit = Fit(own, options);
    seconds += fit.seconds;
    counts += fit.counts;
    if (best.theta.size() == 0 || (fit.theta.size() > 0 && fit.final_cost < best.final_cost))
      best = std::move(fit);
    if (IsCancelled(options)) break;
  }
  if (IsCancelled(options) && best.theta.size() > 0) best.termination = FitTermination::kCancelled;
  best.seconds = seconds;
  best.counts = counts;
  return best;
}

// Scales the rows of contours as WithIndependentContours does.
void WidenContours(const RolloutResiduals& residuals, Eigen::MatrixXd& jacobian) {
  for (int i = 0, row = 0; i < residuals.num_blocks() && jacobian.size() > 0; ++i)
    for (const Sight& sight : residuals.block(i).sights) {
      const auto rows = static_cast<int>(sight.data.size());
      if (sight.is_contour)
        jacobian.middleRows(row, rows) *=
            std::sqrt(double(CountIndependent(sight)) / sight.num_telling);
      row += rows;
    }
}

bool HasMotion(const FitProblem& problem) {
  return std::ranges::any_of(problem.further, [](const SettledExperiment& each) {
    return each.experiment->motion.has_value();
  });
}

// The models that are fitted one after the other, up to the last.
std::vector<ParameterTying> ListStages(ParameterTying last) {
  if (!FreesStretch(last)) return {ParameterTying::kBendScale, ParameterTying::kBendRows};
  return {ParameterTying::kScales, ParameterTying::kColumns, ParameterTying::kEntries};
}

}  // namespace

FitSummary FitLabInStages(ParameterTying last, const FitOptions& options, FitProblem& problem,
                          std::string* note) {
  FitSummary best;
  MaterialField base = problem.material;
  Eigen::VectorXd log_factors = Eigen::VectorXd::Zero(kMaterialEntries);
  Eigen::VectorXd of_others = Eigen::VectorXd::Zero(CountNumbers(problem.fitted));
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  double seconds = 0.0;
  RolloutCounts counts;
  const bool moves = HasMotion(problem);
  const std::vector<ParameterTying> stages = ListStages(last);
  for (const ParameterTying tying : stages) {
    const TableParametrisation table(base, tying);
    const DynamicsParametrisation parametrisation(table, problem.fitted);
    const Eigen::MatrixXd& tie = table.tie();
    RolloutResiduals residuals(&parametrisation,
                               FurtherBlocks(problem, options.trust_region.cancel), {});
    Eigen::Map<Eigen::VectorXd>(residuals.theta(), parametrisation.size())
        << MeanLogFactors(tie, log_factors),
        of_others;
    FitSummary summary = tying == stages[0]
                             ? FitScales(residuals, int(table.size()), moves, options)
                             : Fit(residuals, options);
    seconds += summary.seconds;
    counts += summary.counts;
    if (summary.termination == FitTermination::kFailed) {
      *note = "the laboratory measurements and motions cannot be computed with " +
              std::to_string(parametrisation.size()) + " free parameters: " + summary.message;
      break;
    }
    best = std::move(summary);
    WidenContours(residuals, best.jacobian);
    problem.material = parametrisation.Material(best.theta);
    velocity = parametrisation.StartVelocity(best.theta);
    if (best.termination == FitTermination::kCancelled || tying == last) break;
    if (tying == stages[0]) {
      base = problem.material;
      AddStartVelocity(std::exchange(velocity, Eigen::Vector3d::Zero()), problem);
    } else {
      log_factors = tie * best.theta.head(table.size());
      of_others = best.theta.tail(of_others.size());
    }
  }
  AddStartVelocity(velocity, problem);
  best.seconds = seconds;
  best.counts = counts;
  return best;
}

}  // namespace drape
