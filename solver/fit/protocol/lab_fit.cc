// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/lab_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "physics/mesh/halve_edges.h"
#include "physics/util/text_format.h"
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

bool HasMotion(const FitProblem& problem) {
  return std::ranges::any_of(problem.further, [](const SettledExperiment& each) {
    return each.experiment->motion.has_value();
  });
}

// The motion on a mesh of half the edges, which keeps the numbers of its vertices.
SettledExperiment OnFinerMesh(const SettledExperiment& each) {
  Experiment finer = *each.experiment;
  finer.mesh = HalveEdges(each.model->mesh);
  const auto weights =
      InterpolationWeights(each.model->mesh, finer.mesh.uv, Extrapolation::kLinear);
  State start{ReadPositions(weights, each.start.x), ReadPositions(weights, each.start.v)};
  auto model = std::make_shared<const ClothModel>(finer.mesh, finer.scene, each.model->law);
  return {.experiment = std::make_shared<const Experiment>(std::move(finer)),
          .model = std::move(model),
          .start = std::move(start),
          .backend = each.backend};
}

// The residuals of one motion with the problem's material; nothing where it cannot be computed.
std::optional<Eigen::VectorXd> ReadMotion(FitProblem problem, const SettledExperiment& motion,
                                          const std::atomic<bool>* cancel) {
  problem.further = {motion};
  const TableParametrisation fitted(problem.material, ParameterTying::kScales);
  const RolloutResiduals residuals = EvaluateFurther(problem, fitted, cancel);
  if (!residuals.all_valid()) return std::nullopt;
  Eigen::VectorXd weighed = residuals.residual(0);
  residuals.Weigh(0, weighed, nullptr);
  return weighed;
}

// The motion by time steps of half the length, which show the same times.
SettledExperiment ByHalfSteps(const SettledExperiment& each) {
  Experiment halved = *each.experiment;
  halved.motion = WithFinerSteps(*halved.motion, 2);
  for (Measurement& measurement : halved.measurements) measurement.step *= 2;
  SettledExperiment by_half = each;
  by_half.experiment = std::make_shared<const Experiment>(std::move(halved));
  return by_half;
}

// Counts the errors of mesh and time step of each motion, for intervals, with the problem's
// material. An error is what ever finer ones change, root mean square [sigma], from what half the
// edges or half the time step change: it falls with the square of both.
void CountGridErrors(const std::atomic<bool>* cancel, FitProblem& problem, std::string* note) {
  constexpr double kUnknown = 100.0;  // the factor where a finer one cannot be computed
  constexpr double kOfAllFiner = 4.0 / 3.0;
  for (SettledExperiment& each : problem.further) {
    if (!each.experiment->motion) continue;
    Experiment counted = *each.experiment;
    int telling = 0, independent = 0;
    for (const Sight& sight : MakeSights(counted, *each.model)) {
      telling += sight.num_telling;
      independent += CountIndependent(sight);
    }
    const std::optional<Eigen::VectorXd> own = ReadMotion(problem, each, cancel);
    const auto find_factor = [&](const SettledExperiment& finer, const char* name) {
      const std::optional<Eigen::VectorXd> other = ReadMotion(problem, finer, cancel);
      if (own && other && own->size() == other->size())
        return EnlargeByCommon(kOfAllFiner * kOfAllFiner * (*own - *other).squaredNorm() / telling,
                               independent);
      *note += (note->empty() ? "" : "; ") + counted.name +
               Format(": what a %s would change is unknown, so intervals count %g times the sigma",
                      name, kUnknown);
      return kUnknown;
    };
    counted.mesh_factor = find_factor(OnFinerMesh(each), "finer mesh");
    counted.step_factor = find_factor(ByHalfSteps(each), "shorter time step");
    each.experiment = std::make_shared<const Experiment>(std::move(counted));
  }
}

// Scales the rows of FurtherBlocks as ForIntervals does.
void ScaleForIntervals(const FitProblem& problem, Eigen::MatrixXd& jacobian) {
  const std::vector<RolloutBlock> own = FurtherBlocks(problem, nullptr),
                                  scaled = FurtherBlocks(ForIntervals(problem), nullptr);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < own.size() && jacobian.size() > 0; ++i)
    for (std::size_t k = 0; k < own[i].sights.size(); ++k) {
      const Eigen::Index rows = own[i].sights[k].data.size();
      jacobian.middleRows(row, rows) *= own[i].sights[k].sigma / scaled[i].sights[k].sigma;
      row += rows;
    }
}

// The models that are fitted one after the other, up to the last.
std::vector<ParameterTying> ListStages(ParameterTying last) {
  if (!FreesStretch(last)) return {ParameterTying::kBendScale, ParameterTying::kBendRows};
  return {ParameterTying::kScales, ParameterTying::kColumns, ParameterTying::kEntries};
}

// The fit in stages from a point of scales, the first numbers of θ.
FitSummary FitStagesFrom(const Eigen::VectorXd& scales, ParameterTying last,
                         const FitOptions& options, FitProblem& problem, std::string* note) {
  FitSummary best;
  MaterialField base = problem.material;
  Eigen::VectorXd log_factors = Eigen::VectorXd::Zero(kMaterialEntries);
  Eigen::VectorXd of_others = Eigen::VectorXd::Zero(CountNumbers(problem.fitted));
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  double seconds = 0.0;
  RolloutCounts counts;
  const std::vector<ParameterTying> stages = ListStages(last);
  for (const ParameterTying tying : stages) {
    const TableParametrisation table(base, tying);
    const DynamicsParametrisation parametrisation(table, problem.fitted);
    const Eigen::MatrixXd& tie = table.tie();
    RolloutResiduals residuals(&parametrisation,
                               FurtherBlocks(problem, options.trust_region.cancel), {});
    Eigen::Map<Eigen::VectorXd> theta(residuals.theta(), parametrisation.size());
    if (tying == stages[0])
      theta = scales;
    else
      theta << MeanLogFactors(tie, log_factors), of_others;
    FitSummary summary = Fit(residuals, options);
    seconds += summary.seconds;
    counts += summary.counts;
    if (summary.termination == FitTermination::kFailed) {
      *note = "the laboratory measurements and motions cannot be computed with " +
              std::to_string(parametrisation.size()) + " free parameters: " + summary.message;
      break;
    }
    best = std::move(summary);
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

}  // namespace

FitSummary FitLabInStages(ParameterTying last, const FitOptions& options, FitProblem& problem,
                          std::string* note) {
  const TableParametrisation table(problem.material, ListStages(last)[0]);
  const DynamicsParametrisation parametrisation(table, problem.fitted);
  RolloutResiduals residuals(&parametrisation, FurtherBlocks(problem, options.trust_region.cancel),
                             {});
  const std::vector<Eigen::VectorXd> points =
      ListScales(residuals, static_cast<int>(table.size()), HasMotion(problem), options);
  RolloutCounts counts = residuals.counts();
  double seconds = 0.0;
  FitSummary best;
  const FitProblem start = problem;
  for (const Eigen::VectorXd& point : points) {
    FitProblem own = start;
    std::string own_note;
    FitSummary fit = FitStagesFrom(point, last, options, own, &own_note);
    seconds += fit.seconds;
    counts += fit.counts;
    const bool failed = fit.theta.size() == 0;
    if (&point != &points[0] && (failed || !(fit.final_cost < best.final_cost))) continue;
    best = std::move(fit);
    problem = std::move(own);
    *note = own_note;
    if (IsCancelled(options)) break;
  }
  if (IsCancelled(options) && best.theta.size() > 0) best.termination = FitTermination::kCancelled;
  best.seconds = seconds;
  best.counts = counts;
  if (best.theta.size() > 0 && !IsCancelled(options))
    CountGridErrors(options.trust_region.cancel, problem, note);
  ScaleForIntervals(problem, best.jacobian);
  return best;
}

}  // namespace drape
