// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_job.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <span>
#include <sstream>
#include <utility>

#include "physics/cloth/assembly/step_solver.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/lab_fit.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/job/first_answer.h"
#include "solver/job/fit_checkpoint.h"
#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/exchange/exchange_record.h"

namespace drape {
namespace {

// Settings of the fit of laboratory measurements alone. It takes seconds and runs to its end.
constexpr int kLabIterations = 100;
constexpr double kLabTolerance = 1e-5;
constexpr double kLabDamping = 1e-2;    // at first: strips do not leave a branch
constexpr double kLabLeastScale = 1e4;  // of a parameter that is determined to 1 %
// Shares of the time, for the progress line: of all before the drapes of the result, and of the one
// table in that of other models.
constexpr double kFitShare = 0.9, kTableShare = 0.4;

// The fit of the laboratory measurements and motions alone, where there are some. Its tables become
// the problem's, and the initial guesses do not scale what has been measured.
std::optional<FitSummary> FitLab(StagedFitOptions& stages, FitInput& input,
                                 const RunControl& control) {
  FitProblem& problem = input.problem;
  problem.strips = input.strips.get();
  if (!input.strips && problem.further.empty()) return std::nullopt;
  FitOptions options;
  options.prior_sigma = stages.prior_sigma;
  options.trust_region.max_iterations = kLabIterations;
  options.trust_region.cost_tolerance = kLabTolerance;
  options.trust_region.initial_damping = kLabDamping;
  options.trust_region.least_scale = kLabLeastScale;
  options.trust_region.cancel = control.cancel;
  options.trust_region.progress = [&](const FitIteration& iteration) {
    control.Report(double(iteration.iteration) / kLabIterations, "laboratory measurements");
  };
  std::string note;
  FitSummary fit = FitLabInStages(stages.parameters, options, problem, &note);
  if (!note.empty()) input.notes.push_back(note);
  if (fit.termination == FitTermination::kFailed) {
    problem.strips = nullptr;
    return fit;
  }
  if (!input.strips) return fit;
  for (const LabMeasurement& measurement : input.strips->measurements())
    (measurement.kind == LabMeasurementKind::kTensile ? stages.grid.stretch
                                                      : stages.grid.bend) = {1.0};
  return fit;
}

// Notes the readings that the tables do not explain.
void NoteMisfits(const std::vector<StripReport>& reports, std::vector<std::string>* notes) {
  constexpr double kFar = 3.0;  // sigma
  for (const StripReport& report : reports) {
    const LabMeasurement& measurement = report.measurement;
    for (std::size_t i = 0; i < report.computed.size(); ++i) {
      const double misfit =
          (report.computed[i] - measurement.points[i].reading) / measurement.sigma;
      if (std::abs(misfit) <= kFar) continue;
      notes->push_back("laboratory measurement " + measurement.name +
                       Format(": the computed reading at %g is off by %g sigma",
                              measurement.points[i].set, misfit));
    }
  }
}

void ReportDrapes(const FitSpec& spec, const FitProblem& problem, const FitInput::Cloth& cloth,
                  const FitCandidate& best, const std::atomic<bool>* cancel, FitReport& report) {
  StepSolver solver(cloth.model);
  EquilibriumOptions rest = MakeSettleOptions(spec.stages).equilibrium;
  rest.cancel = cancel;
  report.drapes.resize(problem.observations.size());
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const MaterialField& material =
        report.posterior ? report.posterior->materials[i] : report.material;
    if (!ReportDrape(*problem.fine, solver, material, problem.observations[i],
                     FittedShapes(report, best)[i], rest, &report.drapes[i]))
      report.notes.push_back(problem.observations[i].name +
                             ": the fitted or the settled drape has no outline");
  }
}

// States what is known of the fitted cloth: as laboratories report it, and as exports do.
void MakeSheets(const FitSpec& spec, const Strips* strips, const Judgement& judge,
                FitReport& report) {
  FabricSheetInput input{.tables = MeanTables(report.material),
                         .law = MakeLaw(spec.law),
                         .weights = report.stiffness_weights,
                         .density_is_given = report.density_is_given,
                         .directions = report.directions};
  if (strips != nullptr) input.tests = strips->measurements();
  report.fabric_sheet = MakeFabricSheet(input, judge);
  report.linear_sheet = MakeLinearSheet(input, judge);
  if (report.ground_truth == nullptr) return;
  input.tables = MeanTables(*report.ground_truth);
  input.tests = {};
  report.reference_sheet =
      MakeFabricSheet(input, [](const LogQuantity&, Resistance) { return std::nullopt; });
}

// The rows of experiments: errors are as much larger as the worst measurement says. A fit that is
// off by more than its errors, so perhaps on another branch, has none: it leaves the prior.
WeightedRows ExperimentRows(const FitReport& report, Eigen::MatrixXd jacobian) {
  double enlarged = 1.0;
  for (const MeasurementReport& each : report.measurements) {
    if (each.misfit > kTrustedMisfit) return {};
    enlarged = std::max(enlarged, EnlargeSigma(each.misfit, each.independent));
  }
  const Eigen::Index rows = jacobian.rows();
  return {.jacobian = std::move(jacobian),
          .outline_rows = rows,
          .outline_weight = 1.0 / (enlarged * enlarged),
          .tell_stretching = true};
}

// The tables that explain images which are fitted from a pool, or contours: of the first fits and
// the result, and, from a pool, with as much weight together, of the drapes that are like the
// images.
std::vector<BranchTables> ListBranches(const FitProblem& problem, const StagedFitState& state,
                                       const MaterialField& result) {
  if (state.first_fits.empty()) return {};
  std::vector<BranchTables> branches = {{result}};
  for (const MaterialField& tables : state.first_fits) branches.push_back({tables});
  if (!problem.is_pooled) return branches;
  const std::vector<MaterialField> pooled = ListStartTables(problem);
  const double weight = double(branches.size()) / double(pooled.size());
  for (const MaterialField& tables : pooled) branches.push_back({tables, weight});
  return branches;
}

// How well the fitted cloth is known: by the Laplace approximation at its one table, with the
// outlines' residuals weighted as those of a posterior, by their own σ and as many as are
// independent; of model bayes by the posterior where its samples are reliable; of images over their
// branches.
void EstimateFittedCloth(const FitSpec& spec, const FitProblem& problem,
                         const StagedFitState& state, const Eigen::MatrixXd& by_entries,
                         FitReport& report) {
  const FitCandidate& best = *Best(state);
  const ResidualOptions& residuals = spec.stages.residuals;
  const double sigma_ratio = residuals.sigma_px / std::max(residuals.sigma_px, best.profile_rms);
  const double independent = std::min(1.0, double(spec.posterior.angles) / spec.observation.angles);
  const MaterialField table = FittedMaterial(spec.stages, best);
  const bool of_experiment = FindExperiment(problem) != nullptr;
  Eigen::MatrixXd tie = TyingMatrix(spec.stages.parameters);
  if (of_experiment) tie = TieWithForm(tie, spec.stages.prior_sigma);
  Eigen::MatrixXd jacobian = by_entries.size() > 0 ? JacobianByTie(by_entries, tie) : by_entries;
  WeightedRows rows = {.jacobian = jacobian,
                       .outline_rows = std::min<Eigen::Index>(
                           jacobian.rows(), problem.observations.size() * spec.observation.angles),
                       .outline_weight = sigma_ratio * sigma_ratio * independent};
  if (of_experiment) rows = ExperimentRows(report, jacobian);
  const bool is_trusted = !of_experiment || rows.jacobian.size() > 0;
  const MaterialField mean = MeanTables(report.material);
  const std::vector<BranchTables> branches = ListBranches(problem, state, mean);
  const double model_deviation = problem.is_pooled ? kBranchDeviation : kModelDeviation;
  Judgement judge = JudgeByLaplace(table, tie, rows, spec.stages.prior_sigma, model_deviation);
  const LogQuantity stretch = [&](const MaterialField& tables) {
    return std::log(EffectiveStretch(tables, report.stiffness_weights));
  };
  const LogQuantity bend = [&](const MaterialField& tables) {
    return std::log(EffectiveBend(tables, report.stiffness_weights));
  };
  const std::optional<KnownTo> of_stretch = judge(stretch, Resistance::kStretching),
                               of_bend = judge(bend, Resistance::kBending);
  if (is_trusted && report.posterior && report.posterior->kind == PosteriorKind::kHierarchy &&
      report.posterior->pareto_k < kReliableK)
    judge = JudgeByPosterior(MakeStoredPosterior(*report.posterior),
                             of_stretch && of_stretch->determined,
                             of_bend && of_bend->by_outlines ? model_deviation : 0.0);
  judge = JudgeOverBranches(judge, mean, branches);
  const Bound bound =
      FindBendBound(problem, report, spec.stages.grid, best.guess, of_bend ? of_bend->left : 1.0);
  MakeSheets(spec, problem.strips,
             JudgeByBound(judge, bound, mean, LeastRigidityOfFlat(problem, report)), report);
}

// What the fit of strips and motions let vary, which ends with the last of its stages that
// succeeds, and its Jacobian by this; for intervals. The numbers beside the table vary no entry.
struct LabTie {
  LabTie(const FitSpec& spec, const FitProblem& problem, const FitSummary& fit)
      : jacobian(fit.jacobian) {
    const int others = CountNumbers(problem.fitted);
    tie = TyingMatrix(
        ParseName<ParameterTying>(std::to_string(fit.theta.size() - others), "num_parameters"));
    if (!problem.further.empty()) {
      tie = TieWithForm(tie, spec.stages.prior_sigma);
      jacobian = JacobianByTie(fit.by_entries, tie);
    }
    tie.conservativeResizeLike(Eigen::MatrixXd::Zero(tie.rows(), tie.cols() + others));
  }
  Eigen::MatrixXd tie, jacobian;
};

void EstimateLabCloth(const FitSpec& spec, const FitProblem& problem, FitReport& report) {
  const LabTie lab(spec, problem, *report.lab_fit);
  const WeightedRows rows = problem.further.empty() ? WeightedRows{.jacobian = lab.jacobian}
                                                    : ExperimentRows(report, lab.jacobian);
  MakeSheets(spec, problem.strips,
             JudgeByLaplace(report.material, lab.tie, rows, spec.stages.prior_sigma), report);
}

// Deviations of numbers by the Laplace approximation, with a prior of `prior_sigma` on each.
Eigen::VectorXd LaplaceDeviations(const Eigen::MatrixXd& jacobian, double prior_sigma) {
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  information.diagonal().array() += 1.0 / (prior_sigma * prior_sigma);
  return information.inverse().diagonal().cwiseSqrt();
}

// Reports the numbers beside the tables, with their deviation.
void ReportDynamics(const FitSpec& spec, const FitProblem& problem, FitReport& report) {
  if (problem.fitted.empty() || !report.lab_fit) return;
  const LabTie lab(spec, problem, *report.lab_fit);
  const WeightedRows rows = ExperimentRows(report, lab.jacobian);
  const Eigen::Index count = lab.tie.cols();
  Eigen::MatrixXd weighted = std::sqrt(rows.outline_weight) * rows.jacobian;
  weighted.conservativeResize(weighted.rows(), count);
  const Eigen::VectorXd deviation = LaplaceDeviations(weighted, spec.stages.prior_sigma);
  MaterialField fitted = problem.material;
  Eigen::Index next = count - CountNumbers(problem.fitted);
  for (const FreeNumber number : problem.fitted) {
    const std::span<double> found = FindNumbers(number, fitted);
    std::vector<double> values(found.begin(), found.end());
    for (const SettledExperiment& each : problem.further)
      if (number == FreeNumber::kVelocity && each.experiment->motion)
        values = {each.start.v[0], each.start.v[1], each.start.v[2]};
    const Eigen::VectorXd own = deviation.segment(next, static_cast<Eigen::Index>(values.size()));
    next += own.size();
    report.dynamics.push_back(
        {.number = number, .values = std::move(values), .sd = {own.begin(), own.end()}});
  }
}

// The weights of the entries in what further experiments show [METHODS, P59], the mean over them;
// equal ones where there are none. problem: with the fitted tables.
Eigen::VectorXd WeightsInFurther(const FitProblem& problem, const std::atomic<bool>* cancel) {
  if (problem.further.empty()) return EqualStiffnessWeights();
  const TableParametrisation fitted(problem.material, ParameterTying::kScales);
  const RolloutResiduals residuals = EvaluateFurther(problem, fitted, cancel);
  if (!residuals.all_valid()) return EqualStiffnessWeights();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(kMaterialEntries);
  for (int i = 0; i < residuals.num_blocks(); ++i)
    sum += StiffnessWeights(*problem.further[i].model, residuals.seen_shapes(i));
  return sum / residuals.num_blocks();
}

// Without a candidate: the fit of the laboratory measurements.
void ReportLab(const FitSpec& spec, const FitProblem& problem, const std::atomic<bool>* cancel,
               FitReport& report) {
  if (!problem.observations.empty()) report.notes.push_back("no candidate could be fitted");
  if (!report.lab_fit || report.lab_fit->termination == FitTermination::kFailed) return;
  report.material = problem.material;
  report.spectrum = ComputeSpectrum(report.lab_fit->jacobian, spec.stages.prior_sigma);
  report.measurements = ReportMeasurements(problem, {}, report.material);
  report.stiffness_weights = WeightsInFurther(problem, cancel);
  EstimateLabCloth(spec, problem, report);
  ReportDynamics(spec, problem, report);
  if (problem.strips != nullptr) report.strips = ReportStrips(*problem.strips, report.material);
  NoteMisfits(report.strips, &report.notes);
}

// Says which numbers of a table an experiment can determine, from the spectrum at the start tables,
// before a search begins.
void LogDetermined(const FitProblem& problem, StagedFitOptions stages, const RunControl& control) {
  stages.parameters = ParameterTying::kColumns;
  FitCandidate start;
  start.guess.lifts.assign(problem.observations.size(), stages.grid.lifts.front());
  CandidateTask task{0, start, 0, {}, {}};
  CandidateFitter(problem, stages, *problem.fine, control.cancel, 0).SettleGuess(task);
  if (!task.candidate.valid())
    return control.Log(
        "the start tables give no drape, so what can be determined is not known yet");
  const Eigen::MatrixXd jacobian = FitJacobian(problem, stages, task.candidate);
  if (jacobian.size() == 0)
    return control.Log(
        "what can be determined is not known: the drape of the start tables is not "
        "stable");
  constexpr double kDetermined = 0.5;  // of the prior's standard deviation
  const double prior = stages.prior_sigma;
  const Eigen::VectorXd deviation = LaplaceDeviations(jacobian, prior);
  std::string known, unknown;
  for (int i = 0; i < deviation.size(); ++i) {
    const std::string name = NameFor(ParameterTying::kColumns, i);
    if (deviation[i] < kDetermined * prior)
      known += (known.empty() ? "" : ", ") + name +
               Format(" to %.2g %%", 100.0 * std::expm1(deviation[i]));
    else
      unknown += (unknown.empty() ? "" : ", ") + name;
  }
  control.Log("at the start tables, this experiment determines " +
              (known.empty() ? "no column of the tables" : known) +
              (unknown.empty() ? "" : "; from the prior: " + unknown));
}

// ∂residual/∂(log entries) of a fitted candidate, for intervals, shape [K, 39].
Eigen::MatrixXd JacobianByEntries(const FitProblem& problem, StagedFitOptions stages,
                                  FitCandidate fitted) {
  fitted.base = FittedMaterial(stages, fitted);
  fitted.theta = Eigen::VectorXd::Zero(kMaterialEntries);
  stages.parameters = ParameterTying::kEntries;
  return FitJacobian(ForIntervals(problem), stages, fitted);
}

// Fills the rest of a report that has the fits. Of a cancelled fit, what is at hand.
// problem: of the last part.
void FillReport(const FitSpec& spec, const FitInput& input, const FitProblem& problem,
                const StagedFitState& state, const RunControl& control, FitReport& report) {
  const auto start = std::chrono::steady_clock::now();
  report.notes = input.notes;
  report.density_is_given = input.density_is_given;
  report.start_name = input.start_name;
  report.ground_truth = input.ground_truth.get();
  const FitCandidate* best = Best(state);
  if (best == nullptr) return ReportLab(spec, problem, control.cancel, report);
  report.material = report.fields      ? report.fields->material
                    : report.posterior ? report.posterior->Fabric()
                                       : FittedMaterial(spec.stages, *best);
  if (problem.strips != nullptr) report.strips = ReportStrips(*problem.strips, report.material);
  NoteMisfits(report.strips, &report.notes);
  report.measurements = ReportMeasurements(problem, FittedShapes(report, *best), report.material);
  ReportDynamics(spec, problem, report);
  const Eigen::MatrixXd by_entries =
      control.cancelled() ? Eigen::MatrixXd() : JacobianByEntries(problem, spec.stages, *best);
  if (by_entries.size() > 0)
    report.spectrum =
        ComputeSpectrum(by_entries * TyingMatrix(spec.stages.parameters), spec.stages.prior_sigma);
  report.stiffness_weights = StiffnessWeights(problem.fine->model(), FittedShapes(report, *best));
  const LinearFabric linear =
      LineariseInDrape(MeanTables(report.material), MakeLaw(spec.law), report.stiffness_weights);
  report.directions = NameDirections(problem.observations.front().warp.has_value(),
                                     linear.bend_warp, linear.bend_weft);
  report.mesh_error = EstimateMeshError(input.problem, spec.stages, state);
  if (problem.fine != input.problem.fine && !control.cancelled())
    report.notes.push_back(Format("the fit ended on %d vertices: its drapes are not stable on %s",
                                  problem.fine->model().mesh.num_vertices(), spec.mesh.c_str()));
  ReportDrapes(spec, problem, FindFittedCloth(input, state), *best, control.cancel, report);
  EstimateFittedCloth(spec, problem, state, by_entries, report);
  report.report_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The fields of kHeterogeneous, if they could be fitted.
std::optional<FieldFit> FitJobFields(const FitSpec& spec, const FitProblem& problem,
                                     const StagedFitState& state, const RunControl& control) {
  const FitCandidate* best = Best(state);
  if (spec.model != FitModel::kHeterogeneous || best == nullptr || control.cancelled())
    return std::nullopt;
  FieldFit fit = FitFields(problem, spec.stages, spec.fields, *best, control);
  control.Log(Format("fields: %d parameters, cost %g -> %g, %s, %d branch jumps, %d failed",
                     static_cast<int>(fit.summary.theta.size()), fit.summary.initial_cost,
                     fit.summary.final_cost, ToString(fit.summary.termination),
                     fit.summary.counts.jumps, fit.summary.counts.failed));
  if (!fit.valid()) return std::nullopt;
  return fit;
}

// The posterior of kBayes and kBdp, if it could be fitted.
std::optional<PosteriorFit> FitJobPosterior(const FitSpec& spec, const FitProblem& problem,
                                            const StagedFitState& state,
                                            const std::shared_ptr<const FabricPrior>& prior,
                                            const RunControl& control) {
  const FitCandidate* best = Best(state);
  if (!HasPosterior(spec.model) || best == nullptr || control.cancelled()) return std::nullopt;
  PosteriorOptions options = spec.posterior;
  options.prior = prior;
  options.kind =
      spec.model == FitModel::kBdp ? PosteriorKind::kElements : PosteriorKind::kHierarchy;
  StagedFitOptions stages = spec.stages;
  FitCandidate candidate = *best;
  if (FindExperiment(problem) != nullptr && spec.model == FitModel::kBayes && !prior &&
      stages.parameters != ParameterTying::kEntries)
    CountForm(stages, candidate, options);
  PosteriorFit fit = FitDrapePosterior(problem, stages, options, candidate, control);
  control.Log(Format(
      "posterior: mode %s after %d iterations, sigma %g%s; distribution %s after %d, bound %g, k "
      "%g, %d failed drapes",
      ToString(fit.mode.termination), fit.mode.iterations, fit.sigma,
      fit.of_experiment ? " times the given" : " px", ToString(fit.distribution.termination),
      fit.distribution.iterations, fit.elbo, fit.pareto_k, fit.counts.failed));
  if (!fit.valid()) return std::nullopt;
  return fit;
}

// Reports to another control as the part [from, to] of its work, and logs to the store alone.
RunControl SummaryPart(const RunControl& whole, double from, double to, const FitStore& store) {
  RunControl part;
  part.cancel = whole.cancel;
  part.progress = [&whole, from, to](double fraction, const std::string& note) {
    whole.Report(from + (to - from) * fraction, note);
  };
  part.log = store.log;
  return part;
}

namespace fs = std::filesystem;

// What is continued from a checkpoint, and what is not.
std::string ResumeNote(FitModel model, const FitProblem& problem,
                       const std::optional<StagedFitState>& state) {
  if (!state) return "resume: no checkpoint, from the beginning";
  std::ostringstream note;
  note << "resume: ";
  if (CountParts(problem) > 1)
    note << "part " << state->parts_done + 1 << " of " << CountParts(problem) << ", ";
  if (state->grid_done) {
    note << "round " << state->round + 1 << ", " << DoneCandidates(*state) << " of "
         << state->candidates.size() << " candidates done";
  } else {
    note << state->tried.size() << " scales of the initial guesses done";
  }
  if (model == FitModel::kHeterogeneous) note << "; the fields start again";
  if (HasPosterior(model)) note << "; the posterior starts again";
  return note.str();
}

// Appends a line. A fit is valid even if its log cannot be written, for example on a full disk.
void LogLine(AppendFile& log, const std::string& line) { (void)log.TryAppend(line + "\n"); }

// What a log begins with; the data and the device also go to `control`.
void LogInput(const FitData& data, const FitInput& input, const std::string& resumed,
              const RunControl& control, AppendFile& log) {
  const auto log_both = [&](const std::string& line) {
    LogLine(log, line);
    control.Log(line);
  };
  for (const Observation& observation : input.problem.observations)
    if (observation.experiment == nullptr)
      log_both(observation.name + ": " + CameraText(observation.camera, observation.quality));
  if (!resumed.empty()) log_both(resumed);
  if (!input.device.empty()) log_both("running on " + input.device);
  for (const std::string& line : data.log_lines) LogLine(log, line);
  for (const std::string& note : input.notes) LogLine(log, note);
}

}  // namespace

const std::vector<Eigen::VectorXd>& FittedShapes(const FitReport& report,
                                                 const FitCandidate& best) {
  if (report.fields) return report.fields->shapes;
  return report.posterior ? report.posterior->shapes : best.shapes;
}

StoredFit FitFromInput(const FitSpec& spec, FitInput& input, const FitStore& store,
                       const RunControl& control) {
  StoredFit fit;
  FitReport& report = fit.report;
  StagedFitOptions stages = spec.stages;
  const std::vector<MaterialField> starts = ListStartTables(input.problem);
  report.lab_fit = FitLab(stages, input, control);
  if (const Experiment* experiment = FindExperiment(input.problem)) {
    stages.grid.lifts = ListStarts(*experiment);
    if (store.begin) LogDetermined(input.problem, stages, control);
  }
  const bool ready = !report.lab_fit || (report.lab_fit->termination != FitTermination::kFailed &&
                                         report.lab_fit->termination != FitTermination::kCancelled);
  if (store.begin) {
    fit.state = store.begin(input, stages, ready);
    report.at_once = AnswerAtOnce(input, control);
  }
  const double table_share = spec.model == FitModel::kHomogeneous ? kFitShare : kTableShare;
  if (ready && !input.problem.observations.empty()) {
    StagedFitControl of_table{SummaryPart(control, 0.0, table_share, store)};
    of_table.save = store.save;
    fit.state = RunNestedFit(input.problem, stages, std::move(fit.state), of_table);
  }
  report.start = starts.front();
  if (const FitCandidate* best = Best(fit.state)) {
    report.start = starts[best->guess.table];
    input.problem.observations = LaidObservations(input.problem, *best);
    for (FitCandidate& candidate : fit.state.candidates) candidate.mirrored.clear();
  }
  const RunControl of_rest = SummaryPart(control, table_share, kFitShare, store);
  const FitProblem problem = PartProblem(input.problem, fit.state.parts_done);
  report.fields = FitJobFields(spec, problem, fit.state, of_rest);
  report.posterior = FitJobPosterior(spec, problem, fit.state, input.prior, of_rest);
  control.Report(kFitShare, "drapes of the result");
  FillReport(spec, input, problem, fit.state, control, report);
  if (spec.model != FitModel::kHomogeneous && !report.fields && !report.posterior &&
      report.fitted())
    report.notes.push_back(std::string("model ") + ToString(spec.model) +
                           " could not be fitted: this is its one table");
  report.cancelled = control.cancelled();
  report.verdict = JudgeFit(problem, report);
  return fit;
}

void CheckTargets(const FitSpec& spec, const FitProblem& problem, const FitFiles& files) {
  const std::string folder = files.target.empty() ? files.out : files.target;
  for (const std::string& name : ListResultFiles(spec, problem))
    CheckReplaceable(folder + "/" + name);
  if (!files.checkpoint.empty()) CheckReplaceable(files.checkpoint);
}

const FitInput::Cloth& FindFittedCloth(const FitInput& input, const StagedFitState& state) {
  const FitProblem part = PartProblem(input.problem, state.parts_done);
  const auto found = std::find_if(input.search.begin(), input.search.end(), [&](const auto& cloth) {
    return cloth.backend.get() == part.fine;
  });
  return found == input.search.end() ? input.fine : *found;
}

FitJobResult RunFitJob(const FitSpec& spec, const FitData& data, const FitFiles& files,
                       const RunControl& control) {
  AppendFile::Check(files.log);
  FitInput input = ReadFitInput(spec, data);
  CheckTargets(spec, input.problem, files);
  const std::string key = CheckpointKey(spec, data, input);
  std::optional<AppendFile> log;
  FitStore store;
  store.begin = [&](const FitInput& in, const StagedFitOptions&, bool ready) {
    std::optional<StagedFitState> saved;
    if (files.resume && ready) saved = ReadCheckpoint(files.checkpoint, key);
    using Content = AppendFile::Content;
    log.emplace(files.log, files.resume ? Content::kKeep : Content::kDrop);
    LogInput(data, in,
             files.resume && ready ? ResumeNote(spec.model, in.problem, saved) : std::string(),
             control, *log);
    return std::move(saved).value_or(StagedFitState());
  };
  double shown_cost = 0.0;
  store.save = [&](const StagedFitState& state) {
    WriteCheckpoint(files.checkpoint, key, state);
    const FitCandidate* best = Best(state);
    if (best == nullptr || files.outlines.empty() || FindExperiment(input.problem) != nullptr ||
        std::exchange(shown_cost, best->cost) == best->cost)
      return;
    WriteOutlines(files.outlines, PartProblem(input.problem, state.parts_done), *best);
  };
  store.log = [&](const std::string& line) { LogLine(*log, line); };
  StoredFit fit = FitFromInput(spec, input, store, control);
  FitReport& report = fit.report;
  WriteFitReport(spec, data, files, input.problem, fit.state, report);
  const FitProblem problem = PartProblem(input.problem, fit.state.parts_done);
  FitJobResult result;
  result.cancelled = report.cancelled;
  result.fitted = report.fitted();
  result.has_posterior = report.posterior.has_value();
  if (result.fitted) {
    result.table = FitText(problem, report);
    result.results = MainFiles(problem, report);
  }
  if (!result.cancelled && !files.keep_checkpoint) fs::remove(files.checkpoint);
  if (!files.outlines.empty()) fs::remove(files.outlines);
  return result;
}

FitJobResult ContinueFitJob(const FitSpec& spec, const FitData& data, FitFiles files,
                            const RunControl& control) {
  files.resume = fs::exists(files.checkpoint);
  if (files.resume) try {
      return RunFitJob(spec, data, files, control);
    } catch (const InputError&) {
      files.resume = false;  // a checkpoint of another fit, or a damaged one
    }
  return RunFitJob(spec, data, files, control);
}

FolderFit FitIntoFolder(const FitSpec& spec, const FitData& data, const std::string& folder,
                        const std::function<nlohmann::ordered_json()>& provenance,
                        const RunControl& control) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw IoError(folder, "cannot make the folder: " + error.message());
  RemoveTemporaries(folder, 1);
  const FitFiles files{.out = folder,
                       .checkpoint = folder + "/checkpoint.json",
                       .log = folder + "/fit.log",
                       .provenance = provenance};
  FolderFit fit;
  try {
    static_cast<FitJobResult&>(fit) = ContinueFitJob(spec, data, files, control);
    if (!fit.fitted && !fit.cancelled) fit.failure = "nothing could be fitted";
  } catch (const InputError& error) {
    fit.failure = error.what();
  }
  return fit;
}

}  // namespace drape
