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
// Factors on sigma for the errors of mesh and time step: what intervals notice, and where a finer
// motion cannot be computed.
constexpr double kNoticed = 1.1, kUnknown = 100.0;
constexpr int kMostCorrections = 2;
constexpr double kUnlikely = 3.0;  // of a cost above that of the fit without corrections

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

// The residuals of one motion with the problem's material, without losses; nothing where it cannot
// be computed.
std::optional<Eigen::VectorXd> ReadMotion(FitProblem problem, const SettledExperiment& motion,
                                          const std::atomic<bool>* cancel) {
  problem.further = {motion};
  const TableParametrisation fitted(problem.material, ParameterTying::kScales);
  const RolloutResiduals residuals = EvaluateFurther(problem, fitted, cancel);
  if (!residuals.all_valid()) return std::nullopt;
  return residuals.residual(0);
}

// The motion by `parts` time steps for each, which show the same times.
SettledExperiment ByFinerSteps(const SettledExperiment& each, int parts) {
  Experiment finer = *each.experiment;
  finer.motion = WithFinerSteps(*finer.motion, parts);
  for (Measurement& measurement : finer.measurements) measurement.step *= parts;
  SettledExperiment by_finer = each;
  by_finer.experiment = std::make_shared<const Experiment>(std::move(finer));
  return by_finer;
}

// What ever finer meshes and ever shorter time steps change in the residuals of a motion, from what
// half of each and a quarter of the time step change: all errors fall with the square of both.
struct GridErrors {
  Eigen::VectorXd mesh, step;            // [sigma]
  Eigen::VectorXd mesh_rest, step_rest;  // what beyond the finest was extrapolated
};

std::optional<GridErrors> FindGridErrors(const FitProblem& problem, const SettledExperiment& each,
                                         const std::atomic<bool>* cancel) {
  const auto own = ReadMotion(problem, each, cancel),
             on_finer = ReadMotion(problem, OnFinerMesh(each), cancel),
             by_half = ReadMotion(problem, ByFinerSteps(each, 2), cancel),
             by_quarter = ReadMotion(problem, ByFinerSteps(each, 4), cancel);
  if (!own || !on_finer || !by_half || !by_quarter || own->size() != on_finer->size())
    return std::nullopt;
  GridErrors errors;
  errors.mesh_rest = (*on_finer - *own) / 3.0;
  errors.step_rest = (*by_quarter - *by_half) / 3.0;
  errors.mesh = 4.0 * errors.mesh_rest;
  errors.step = *by_quarter + errors.step_rest - *own;
  return errors;
}

// The factor on sigma where all numbers of a motion have this error [sigma] in common.
double FindFactor(const std::vector<Sight>& sights, const Eigen::VectorXd& error) {
  int telling = 0, independent = 0;
  for (const Sight& sight : sights) {
    telling += sight.num_telling;
    independent += CountIndependent(sight);
  }
  return EnlargeByCommon(error.squaredNorm() / telling, independent);
}

// Calls a function (measurement, its first row, its rows) for each measurement of a motion.
template <class Function>
void ForEachMeasurement(Experiment& experiment, const std::vector<Sight>& sights,
                        Function&& function) {
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    function(experiment.measurements[i], row, sights[i].data.size());
    row += sights[i].data.size();
  }
}

// Finds the errors of mesh and time step of a motion with the problem's material, and for intervals
// what is not corrected of them. Corrects the motion by errors that intervals notice, unless they
// are only counted; returns whether it did.
bool FindMotionErrors(const FitProblem& problem, bool only_count, const std::atomic<bool>* cancel,
                      SettledExperiment& motion, std::string* note) {
  Experiment found = *motion.experiment;
  const std::vector<Sight> sights = MakeSights(found, *motion.model);
  const std::optional<GridErrors> errors = FindGridErrors(problem, motion, cancel);
  bool corrects = false;
  if (errors) {
    const Eigen::VectorXd all = errors->mesh + errors->step;
    Eigen::VectorXd change = all;
    bool was_corrected = false;
    ForEachMeasurement(found, sights, [&](Measurement& each, Eigen::Index row, Eigen::Index rows) {
      was_corrected = each.grid_error.size() > 0;
      if (was_corrected) change.segment(row, rows) -= each.grid_error / each.sigma;
    });
    found.mesh_factor = FindFactor(sights, was_corrected ? errors->mesh_rest : errors->mesh);
    found.step_factor =
        FindFactor(sights, was_corrected ? errors->step_rest + change : errors->step);
    corrects = !only_count && FindFactor(sights, change) > kNoticed &&
               FindFactor(sights, all) < kMostGridFactor;
    if (corrects)
      ForEachMeasurement(found, sights, [&](Measurement& each, Eigen::Index row, Eigen::Index n) {
        each.grid_error = each.sigma * all.segment(row, n);
      });
  } else {
    found.mesh_factor = found.step_factor = kUnknown;
    *note += (note->empty() ? "" : "; ") + found.name +
             Format(
                 ": what a finer mesh and shorter time steps would change is unknown, so "
                 "intervals count %g times the sigma",
                 kUnknown);
  }
  motion.experiment = std::make_shared<const Experiment>(std::move(found));
  return corrects;
}

// FitSummary::by_entries at what was fitted; no rows where it cannot be computed.
Eigen::MatrixXd JacobianByEntries(const FitProblem& problem, const std::atomic<bool>* cancel) {
  const DynamicsParametrisation all({problem.material, ParameterTying::kEntries}, problem.fitted);
  RolloutResiduals residuals(&all, FurtherBlocks(ForIntervals(problem), cancel), {});
  residuals.PrepareForEvaluation(true, true);
  return residuals.has_accepted() ? residuals.accepted().jacobian : Eigen::MatrixXd(0, all.size());
}

// The models that are fitted one after the other, up to the last.
std::vector<ParameterTying> ListStages(ParameterTying last) {
  if (!FreesStretch(last)) return {ParameterTying::kBendScale, ParameterTying::kBendRows};
  return {ParameterTying::kScales, ParameterTying::kColumns, ParameterTying::kEntries};
}

// A fit in stages.
class LabFitter {
 public:
  LabFitter(ParameterTying last, const FitOptions& options, FitProblem problem)
      : last_(last), options_(&options), problem_(std::move(problem)), base_(problem_.material) {}

  // Fits all stages from a point of scales, the first numbers of θ, until one fails.
  void FitStages(const Eigen::VectorXd& scales) {
    for (const ParameterTying tying : ListStages(last_))
      if (!FitStage(tying, &scales) || tying == last_ ||
          summary_.termination == FitTermination::kCancelled)
        return;
  }

  // Finds the errors of mesh and time step of motions. Corrects the motions by them, and repeats
  // the last stage, where intervals notice errors and the data do not speak against it.
  void Correct() {
    LabFitter plain = *this;
    for (int i = 0; !IsCancelled(*options_) && FindErrors(i == kMostCorrections); ++i)
      if (!FitStage(last_, nullptr) || cost() > plain.cost() + kUnlikely) {
        plain.seconds_ = seconds_;
        plain.counts_ = counts_;
        *this = plain;
        FindErrors(true);
        return;
      }
  }

  // Becomes another fit of the same where its cost is less; counts what both took.
  void TakeBetter(LabFitter other) {
    if (!other.failed() && (failed() || other.cost() < cost())) std::swap(*this, other);
    seconds_ += other.seconds_;
    counts_ += other.counts_;
  }

  bool failed() const { return summary_.theta.size() == 0; }
  const std::string& note() const { return note_; }
  ParameterTying tying() const { return tying_; }  // of summary()
  // The last stage that succeeded, with the seconds and the counts of all.
  FitSummary summary() const {
    FitSummary all = summary_;
    all.seconds = seconds_;
    all.counts = counts_;
    return all;
  }
  // The problem with what was fitted.
  FitProblem fitted() const {
    FitProblem problem = problem_;
    AddStartVelocity(velocity_, problem);
    return problem;
  }

 private:
  double cost() const { return summary_.final_cost; }

  // Finds the errors of all motions (FindMotionErrors); returns whether one was corrected.
  bool FindErrors(bool only_count) {
    const FitProblem found = fitted();
    bool corrects = false;
    for (std::size_t i = 0; i < found.further.size(); ++i) {
      SettledExperiment motion = found.further[i];
      if (!motion.experiment->motion) continue;
      corrects |=
          FindMotionErrors(found, only_count, options_->trust_region.cancel, motion, &note_);
      problem_.further[i].experiment = motion.experiment;
    }
    return corrects;
  }

  // Fits one stage, from `scales` if it is the first, else from what the stage before left.
  bool FitStage(ParameterTying tying, const Eigen::VectorXd* scales) {
    const TableParametrisation table(base_, tying);
    const DynamicsParametrisation parametrisation(table, problem_.fitted);
    RolloutResiduals residuals(&parametrisation,
                               FurtherBlocks(problem_, options_->trust_region.cancel), {});
    Eigen::Map<Eigen::VectorXd> theta(residuals.theta(), parametrisation.size());
    const bool is_first = failed();
    if (is_first)
      theta = *scales;
    else
      theta << MeanLogFactors(table.tie(), log_factors_), of_others_;
    FitSummary summary = Fit(residuals, *options_);
    seconds_ += summary.seconds;
    counts_ += summary.counts;
    if (summary.termination == FitTermination::kFailed) {
      note_ = "the laboratory measurements and motions cannot be computed with " +
              std::to_string(parametrisation.size()) + " free parameters: " + summary.message;
      return false;
    }
    summary_ = std::move(summary);
    tying_ = tying;
    problem_.material = parametrisation.Material(summary_.theta);
    velocity_ = parametrisation.StartVelocity(summary_.theta);
    if (is_first && tying != last_) {
      base_ = problem_.material;
      AddStartVelocity(std::exchange(velocity_, Eigen::Vector3d::Zero()), problem_);
    } else {
      log_factors_ = table.tie() * summary_.theta.head(table.size());
      of_others_ = summary_.theta.tail(of_others_.size());
    }
    return true;
  }

  ParameterTying last_;
  const FitOptions* options_;
  FitProblem problem_;
  MaterialField base_;  // about which the prior of the next stage is
  FitSummary summary_;
  ParameterTying tying_{};
  std::string note_;
  double seconds_ = 0.0;
  RolloutCounts counts_;
  // What the next stage begins with.
  Eigen::VectorXd log_factors_ = Eigen::VectorXd::Zero(kMaterialEntries);
  Eigen::VectorXd of_others_ = Eigen::VectorXd::Zero(CountNumbers(problem_.fitted));
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
};

}  // namespace

FitSummary FitLabInStages(ParameterTying last, const FitOptions& options, FitProblem& problem,
                          std::string* note) {
  const TableParametrisation table(problem.material, ListStages(last)[0]);
  const DynamicsParametrisation parametrisation(table, problem.fitted);
  RolloutResiduals residuals(&parametrisation, FurtherBlocks(problem, options.trust_region.cancel),
                             {});
  const std::vector<Eigen::VectorXd> points =
      ListScales(residuals, static_cast<int>(table.size()), HasMotion(problem), options);
  LabFitter best(last, options, problem);
  best.FitStages(points[0]);
  for (std::size_t i = 1; i < points.size() && !IsCancelled(options); ++i) {
    LabFitter other(last, options, problem);
    other.FitStages(points[i]);
    best.TakeBetter(std::move(other));
  }
  if (!best.failed()) best.Correct();
  problem = best.fitted();
  *note = best.note();
  FitSummary summary = best.summary();
  if (IsCancelled(options) && summary.theta.size() > 0)
    summary.termination = FitTermination::kCancelled;
  summary.counts += residuals.counts();
  if (problem.further.empty() || best.failed()) return summary;
  summary.by_entries = JacobianByEntries(problem, options.trust_region.cancel);
  if (summary.by_entries.rows() > 0)
    summary.jacobian = JacobianByTie(summary.by_entries, TyingMatrix(best.tying()));
  return summary;
}

}  // namespace drape
