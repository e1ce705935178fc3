// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_job.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include "solver/fit/protocol/fit_checkpoint.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_report.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Of the fit of tests alone: it takes seconds, so it is run to the end.
constexpr int kTestIterations = 100;
constexpr double kTestTolerance = 1e-5;
constexpr double kTableShare = 0.7;      // of the time of heter and bayes that one table takes
constexpr double kTestLeastScale = 1e4;  // of a number that its tests determine to 1 %

// Fits the tests alone: few numbers first, because single entries are bent into tables that no
// strip bears while the whole is far off. First scales about the start tables; what follows has
// its prior about the tables so scaled, as after the seed grid of a silhouette. The last stage that
// succeeds stands; `note` says why a later one did not.
FitSummary FitTestsInStages(const MaterialField& start, ParameterTying last,
                            const FitOptions& options, StripResiduals& tests, MaterialField* fitted,
                            std::string* note) {
  FitSummary best;
  MaterialField base = start;
  Eigen::VectorXd log_entries = Eigen::VectorXd::Zero(kMaterialEntries);
  double seconds = 0.0;
  const std::vector<ParameterTying> stages =
      FreesStretch(last)
          ? std::vector{ParameterTying::kScales, ParameterTying::kColumns, ParameterTying::kEntries}
          : std::vector{ParameterTying::kBendScale, ParameterTying::kBendRows};
  for (const ParameterTying tying : stages) {
    const TableParametrisation parametrisation(base, tying);
    const Eigen::MatrixXd& tie = *parametrisation.log_entries_by_theta();
    // A group's mean; the columns of T are ones and zeros.
    const Eigen::VectorXd theta =
        (tie.transpose() * log_entries).cwiseQuotient(tie.colwise().sum().transpose());
    FitSummary summary = FitStrips(tests, parametrisation, theta, options);
    seconds += summary.seconds;
    if (summary.termination == FitTermination::kFailed) {
      *note = "the strips of the tests cannot be computed with " +
              std::to_string(parametrisation.size()) + " free numbers: " + summary.message;
      break;
    }
    best = std::move(summary);
    *fitted = parametrisation.Material(best.theta);
    if (best.termination == FitTermination::kCancelled || tying == last) break;
    if (tying == stages[0]) {
      base = *fitted;
    } else {
      log_entries = tie * best.theta;
    }
  }
  best.seconds = seconds;
  return best;
}

// The tables of the tests alone become the problem's.
void StartFromTests(const FitJob& job, const FitJobCallbacks& callbacks, LoadedJob& loaded) {
  FitOptions options;
  options.prior_sigma = job.fit.prior_sigma;
  options.max_iterations = kTestIterations;
  options.cost_tolerance = kTestTolerance;
  options.least_scale = kTestLeastScale;
  options.cancel = callbacks.cancel;
  options.progress = [&](const FitIteration& iteration) {
    if (callbacks.progress)
      callbacks.progress({"tests", double(iteration.iteration) / kTestIterations, 0.0});
  };
  const MaterialField start = loaded.problem.material;
  std::string note;
  loaded.tests_alone = FitTestsInStages(start, job.fit.parameters, options, *loaded.tests,
                                        &loaded.problem.material, &note);
  if (!note.empty()) loaded.notes.push_back(note);
  if (loaded.tests_alone->termination == FitTermination::kFailed) return;
  loaded.problem.tests = loaded.tests.get();
  for (const LabMeasurement& test : loaded.tests->tests())
    (test.kind == LabMeasurementKind::kTensile ? loaded.fit.grid.stretch
                                               : loaded.fit.grid.bend) = {1.0};
}

// Readings that the tables do not explain.
void NoteMisfits(const std::vector<StripReport>& reports, std::vector<std::string>* notes) {
  constexpr double kFar = 3.0;  // sigma
  for (const StripReport& report : reports)
    for (std::size_t i = 0; i < report.computed.size(); ++i) {
      const double misfit =
          (report.computed[i] - report.test.points[i].reading) / report.test.sigma;
      if (std::abs(misfit) <= kFar) continue;
      std::ostringstream note;
      note << "test " << report.test.name << ": the reading at " << report.test.points[i].set
           << " is not met, by " << misfit << " sigma";
      notes->push_back(note.str());
    }
}

void Log(const std::string& line, const FitJobCallbacks& callbacks, std::ostream& log) {
  log << line << std::endl;
  if (callbacks.log) callbacks.log(line);
}

// What a checkpoint holds, and what it does not.
std::string ResumeNote(const FitJob& job, const std::optional<StagedFitState>& state) {
  if (!state) return "resume: no checkpoint, from the beginning";
  std::ostringstream note;
  note << "resume: ";
  if (state->grid_done) {
    note << "round " << state->round + 1 << ", " << DoneCandidates(*state) << " of "
         << state->branches.size() << " branches done";
  } else {
    note << "the seed grid begins anew";
  }
  if (job.model == "heterogeneous") note << "; the fields begin anew";
  if (job.model == "bayes" || job.model == "bdp") note << "; the posterior begins anew";
  return note.str();
}

// Fills the report that has the fields or the posterior.
void FillReport(const FitJob& job, const LoadedJob& loaded, const StagedFitState& state,
                FitReport& report) {
  const auto start = std::chrono::steady_clock::now();
  report.notes = loaded.notes;
  report.tests_alone = loaded.tests_alone;
  const FitProblem& problem = loaded.problem;
  const FitCandidate* best = Best(state);
  if (best == nullptr) {
    if (!problem.targets.empty()) report.notes.push_back("no branch could be fitted");
    if (problem.tests == nullptr) return;
    report.material = problem.material;
    report.spectrum = ComputeSpectrum(loaded.tests_alone->jacobian, job.fit.prior_sigma);
    report.tests = ReportStrips(*problem.tests, report.material);
    NoteMisfits(report.tests, &report.notes);
    return;
  }
  report.material = report.fields      ? report.fields->material
                    : report.posterior ? report.posterior->Fabric()
                                       : FittedMaterial(problem, job.fit, *best);
  if (problem.tests != nullptr) report.tests = ReportStrips(*problem.tests, report.material);
  NoteMisfits(report.tests, &report.notes);
  const Eigen::MatrixXd jacobian = FitJacobian(problem, job.fit, *best);
  if (jacobian.size() > 0) report.spectrum = ComputeSpectrum(jacobian, job.fit.prior_sigma);
  StepSolver solver(loaded.fine_model);
  DrapeReportOptions options;
  options.settle.h = job.fit.settle_h;
  options.settle.steps = job.evaluation_steps;
  options.replay = MakeSettleOptions(job.fit);
  report.drapes.resize(problem.targets.size());
  for (std::size_t i = 0; i < problem.targets.size(); ++i) {
    options.seed_lift = best->seed.lifts[i];
    const auto& shapes = report.fields      ? report.fields->shapes
                         : report.posterior ? report.posterior->shapes
                                            : best->shapes;
    const MaterialField& material =
        report.posterior ? report.posterior->materials[i] : report.material;
    if (!ReportDrape(*problem.fine, solver, material, problem.targets[i], shapes[i], options,
                     &report.drapes[i]))
      report.notes.push_back(problem.targets[i].name +
                             ": the fitted or the settled drape has no outline");
  }
  report.report_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The fields of model heter; none where the fit before them or their own failed.
std::optional<FieldFit> FitJobFields(const FitJob& job, const LoadedJob& loaded,
                                     const StagedFitState& state,
                                     const StagedFitCallbacks& callbacks) {
  const FitCandidate* best = Best(state);
  const bool cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  if (job.model != "heterogeneous" || best == nullptr || cancelled) return std::nullopt;
  FieldFit fit = FitFields(loaded.problem, job.fit, job.fields, *best, callbacks);
  std::ostringstream line;
  line << "fields: " << fit.summary.theta.size() << " numbers, cost " << fit.summary.initial_cost
       << " -> " << fit.summary.final_cost << ", " << ToString(fit.summary.termination) << ", "
       << fit.summary.counts.jumps << " branch jumps, " << fit.summary.counts.failed << " failed";
  callbacks.log(line.str());
  if (!fit.valid()) return std::nullopt;
  return fit;
}

// The posterior of models bayes and bdp; none as above.
std::optional<PosteriorFit> FitJobPosterior(const FitJob& job, const LoadedJob& loaded,
                                            const StagedFitState& state,
                                            const StagedFitCallbacks& callbacks) {
  const FitCandidate* best = Best(state);
  const bool cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  if ((job.model != "bayes" && job.model != "bdp") || best == nullptr || cancelled)
    return std::nullopt;
  PosteriorOptions options = job.posterior;
  options.kind = job.model == "bdp" ? PosteriorKind::kElements : PosteriorKind::kHierarchy;
  PosteriorFit fit = FitDrapePosterior(loaded.problem, job.fit, options, *best, callbacks);
  std::ostringstream line;
  line << "posterior: mode " << ToString(fit.mode.termination) << " after " << fit.mode.iterations
       << " iterations, sigma " << fit.sigma_px << " px; distribution "
       << ToString(fit.posterior.termination) << " after " << fit.posterior.iterations << ", bound "
       << fit.elbo << ", k " << fit.pareto_k << ", " << fit.counts.failed << " failed drapes";
  callbacks.log(line.str());
  if (!fit.valid()) return std::nullopt;
  return fit;
}

}  // namespace

FitJobResult RunFitJob(const FitJob& job, const FitJobCallbacks& callbacks) {
  LoadedJob loaded = LoadJob(job);
  const std::string identity = CheckpointKey(job, loaded);
  StagedFitState state;
  std::optional<StagedFitState> saved;
  if (job.resume) saved = ReadCheckpoint(job.checkpoint, identity);
  std::ofstream log(job.log, job.resume ? std::ios::app : std::ios::trunc);
  if (job.resume) Log(ResumeNote(job, saved), callbacks, log);
  if (saved) state = *std::move(saved);
  if (!loaded.backend_choice.empty()) Log("backend: " + loaded.backend_choice, callbacks, log);
  for (const std::string& line : job.log_lines) log << line << std::endl;
  for (const std::string& note : loaded.notes) log << note << std::endl;
  StagedFitCallbacks staged;
  staged.cancel = callbacks.cancel;
  staged.save = [&](const StagedFitState& s) { WriteCheckpoint(job.checkpoint, identity, s); };
  staged.log = [&](const std::string& line) { log << line << std::endl; };
  staged.progress = [&](const std::string& stage, double fraction, double rms) {
    if (!callbacks.progress) return;
    if (job.model != "homogeneous")
      fraction = stage == "fields" || stage == "posterior"
                     ? kTableShare + (1 - kTableShare) * fraction
                     : kTableShare * fraction;
    callbacks.progress({stage, fraction, rms});
  };
  if (loaded.tests) StartFromTests(job, callbacks, loaded);
  const bool ready = !loaded.tests || loaded.problem.tests != nullptr;
  if (ready && !loaded.problem.targets.empty())
    state = RunStagedFit(loaded.problem, loaded.fit, std::move(state), staged);
  FitReport report;
  report.fields = FitJobFields(job, loaded, state, staged);
  report.posterior = FitJobPosterior(job, loaded, state, staged);
  FillReport(job, loaded, state, report);
  if (job.model != "homogeneous" && !report.fields && !report.posterior && report.fitted())
    report.notes.push_back("model " + job.model + " could not be fitted: this is its one table");
  report.cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  WriteFitReport(job, loaded.problem, state, report);
  FitJobResult result;
  result.cancelled = report.cancelled;
  result.fitted = report.fitted();
  if (result.fitted) result.table = FitTable(loaded.problem, report, loaded.truth.get());
  if (!result.cancelled && !job.keep_checkpoint) fs::remove(job.checkpoint);
  return result;
}

}  // namespace drape
