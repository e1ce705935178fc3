// SPDX-License-Identifier: Apache-2.0
#include "solver/fit_job.h"

#include <glob.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "cuda/cuda_backend.h"
#include "losses/centre.h"
#include "losses/outline.h"
#include "physics/errors.h"
#include "physics/material_io.h"
#include "physics/mesh_spec.h"
#include "solver/fit_checkpoint.h"
#include "solver/fit_report.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Of the fit of tests alone: it takes seconds, so it is run to the end.
constexpr int kTestIterations = 100;
constexpr double kTestTolerance = 1e-5;
constexpr double kTableShare = 0.7;      // of the time of heter and bayes that one table takes
constexpr double kTestLeastScale = 1e4;  // of a number that its tests determine to 1 %

// The inputs of a job, read and checked, with the backends that the problem points to.
struct LoadedJob {
  std::shared_ptr<const ClothModel> fine_model;
  std::unique_ptr<Backend> fine, coarse;
  std::string backend_choice;  // empty: tests alone, without a backend
  FitProblem problem;
  StagedFitOptions fit;
  std::unique_ptr<StripReadings> tests;
  std::optional<FitSummary> tests_alone;
  std::unique_ptr<MaterialField> truth;
  std::vector<std::string> notes;
};

NegativeEntries PolicyOf(const FitJob& job) {
  return job.law == "reference" || job.floor > 0.0 ? NegativeEntries::kWarn
                                                   : NegativeEntries::kReject;
}

// Raises the entries of a column (stride between them) to share · the largest; returns how many.
int RaiseToFloor(double* entries, int count, int stride, double share) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i) largest = std::max(largest, entries[i * stride]);
  int raised = 0;
  for (int i = 0; i < count; ++i) {
    double& entry = entries[i * stride];
    if (entry >= share * largest) continue;
    entry = share * largest;
    ++raised;
  }
  return raised;
}

int RaiseToFloor(MaterialField& field, double share) {
  int raised = 0;
  for (int c = 0; c < kStretchCols; ++c)
    raised += RaiseToFloor(&field.stretch[0].c[0][c], kStretchRows, kStretchCols, share);
  for (auto& row : field.bend[0].b) raised += RaiseToFloor(row, kBendCols, 1, share);
  return raised;
}

Target LoadTarget(const FitJob& job, const std::string& file) {
  Target target;
  target.file = file;
  target.name = fs::path(file).stem().string();
  target.image = ReadSilhouette(file);
  target.camera.kind = ParseCameraKind(job.camera);
  // The published images are 256 px wide; others are taken to show as much.
  const Camera nominal;
  const double zoom = double(target.image.width) / nominal.width;
  target.camera.width = target.image.width;
  target.camera.height = target.image.height;
  target.camera.cx = 0.5 * (target.image.width - 1);
  target.camera.cy = 0.5 * (target.image.height - 1);
  target.camera.scale *= zoom;
  Outline outline;
  const bool measured = (ParseCentreMode(job.centre) == CentreMode::kNominal ||
                         CentreOnOutline(target.image, &target.camera)) &&
                        OutlineFromImage(target.image, target.camera, job.fit.angles, &outline);
  if (!measured)
    throw InputError(file, "no closed outline around the support's centre, expected the silhouette "
                           "of a drape");
  target.radius = outline.radius;
  return target;
}

void RequireDistinctNames(const std::vector<Target>& targets) {
  std::set<std::string> names;
  for (const Target& target : targets)
    if (!names.insert(target.name).second)
      throw InputError(target.file, "a second image of the name '" + target.name +
                                        "', expected distinct names: they name the output files");
}

void CheckModel(const FitJob& job) {
  if (job.model == "homo") return;
  if (job.model != "heter" && job.model != "bayes")
    throw InputError("model", "'" + job.model + "', expected homo, heter or bayes");
  if (job.images.empty())
    throw InputError("model", job.model + " without images, expected some");
  if (job.fit.integrator != Integrator::kStatic)
    throw InputError("integrator", "dynamic with model " + job.model + ", expected static");
  const std::vector<int>& specimen = job.posterior.specimen;
  if (specimen.empty()) return;
  if (specimen.size() != job.images.size())
    throw InputError("specimens", "found " + std::to_string(specimen.size()) +
                                      " numbers, expected one for each of the " +
                                      std::to_string(job.images.size()) + " images");
  const std::set<int> names(specimen.begin(), specimen.end());
  if (*names.begin() != 1 || *names.rbegin() != static_cast<int>(names.size()))
    throw InputError("specimens", "expected all numbers from 1 to that of the last specimen");
}

LoadedJob Load(const FitJob& job) {
  if (job.images.empty() && job.tests.empty())
    throw InputError("images", "none, and no tests, expected at least one silhouette or test");
  CheckModel(job);
  LoadedJob loaded;
  loaded.fit = job.fit;
  std::vector<MechanicalTest> tests;
  std::set<std::string> names;
  for (const std::string& file : job.tests) {
    tests.push_back(ReadMechanicalTest(file));
    if (!names.insert(tests.back().name).second)
      throw InputError(file, "a second test of the name '" + tests.back().name +
                                 "', expected distinct names");
  }
  for (const std::string& image : job.images)
    loaded.problem.targets.push_back(LoadTarget(job, image));
  RequireDistinctNames(loaded.problem.targets);
  const Material start = ReadMaterial(job.material, {PolicyOf(job)});
  loaded.problem.material = start.field;
  if (job.density > 0.0) loaded.problem.material.density = job.density;
  const int raised = RaiseToFloor(loaded.problem.material, job.floor);
  if (raised > 0) {
    std::ostringstream note;
    note << raised << " start entries of " << job.material << " were raised to " << job.floor
         << " of their column's largest";
    loaded.notes.push_back(note.str());
  }
  if (!job.truth.empty())
    loaded.truth = std::make_unique<MaterialField>(
        ReadMaterial(job.truth, {NegativeEntries::kWarn}).field);
  if (!tests.empty())
    loaded.tests = std::make_unique<StripReadings>(std::move(tests), MakeLaw(job.law));
  if (job.images.empty()) return loaded;
  const auto model = [&](const std::string& mesh) {
    return std::make_shared<const ClothModel>(ParseMeshSpec(mesh), CusickScene(), MakeLaw(job.law));
  };
  loaded.fine_model = model(job.mesh);
  if (loaded.fine_model->held.size() == static_cast<size_t>(loaded.fine_model->mesh.num_vertices()))
    throw InputError(job.mesh,
                     "found all vertices on the support of radius 0.09 m, expected a cloth "
                     "that hangs over it");
  loaded.fine = MakeBackend(job.backend, loaded.fine_model, job.threads, &loaded.backend_choice);
  loaded.coarse = MakeBackend(job.backend, model(job.coarse_mesh), job.threads);
  loaded.problem.fine = loaded.fine.get();
  loaded.problem.coarse = loaded.coarse.get();
  return loaded;
}

// What must be the same for a checkpoint to be continued.
std::string Identity(const FitJob& job, const LoadedJob& loaded) {
  const FitProblem& problem = loaded.problem;
  nlohmann::json id = {{"model", job.model},     {"mesh", job.mesh},
                       {"coarse_mesh", job.coarse_mesh}, {"material", job.material},
                       {"law", job.law},         {"camera", job.camera},
                       {"centre", job.centre},   {"floor", job.floor},
                       {"stretch", job.fit.grid.stretch}, {"bend", job.fit.grid.bend},
                       {"lifts", job.fit.grid.lifts},     {"grid_h", job.fit.grid.h},
                       {"grid_steps", job.fit.grid.steps}, {"keep", job.fit.keep},
                       {"iterations", job.fit.iterations},
                       {"parameters", static_cast<int>(job.fit.parameters)},
                       {"prior_sigma", job.fit.prior_sigma}, {"sigma_px", job.fit.sigma_px},
                       {"angles", job.fit.angles},           {"settle_h", job.fit.settle_h},
                       {"settle_steps", job.fit.settle_steps},
                       {"initial_damping", job.fit.initial_damping},
                       {"newton_iterations", job.fit.newton_iterations},
                       {"max_outline_change", job.fit.max_outline_change},
                       {"max_jump", job.fit.max_jump},
                       {"warm_restart", job.fit.warm_restart},
                       {"integrator", static_cast<int>(job.fit.integrator)},
                       {"density", problem.material.density},
                       {"stretch_table", problem.material.stretch[0].c},
                       {"bend_table", problem.material.bend[0].b}};
  for (const Target& target : problem.targets)
    id["images"].push_back(
        {target.name, std::vector<double>(target.radius.begin(), target.radius.end())});
  if (!loaded.tests) return id.dump();
  for (const MechanicalTest& test : loaded.tests->tests()) {
    nlohmann::json points;
    for (const TestPoint& point : test.points) points.push_back({point.set, point.reading});
    id["tests"].push_back({test.name, ToString(test.kind), test.direction, test.length, test.width,
                           test.sigma, points});
  }
  return id.dump();
}

// Fits the tests alone: few numbers first, because single entries are bent into tables that no
// strip bears while the whole is far off. First two scales about the start tables; what follows has
// its prior about the tables so scaled, as after the seed grid of a silhouette. The last stage that
// succeeds stands; `note` says why a later one did not.
FitSummary FitTestsInStages(const MaterialField& start, Tying last, const FitOptions& options,
                            StripReadings& tests, MaterialField* fitted, std::string* note) {
  FitSummary best;
  MaterialField base = start;
  Eigen::VectorXd log_entries = Eigen::VectorXd::Zero(kMaterialEntries);
  double seconds = 0.0;
  for (const Tying tying : {Tying::kScales, Tying::kColumns, Tying::kEntries}) {
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
    if (tying == Tying::kScales) {
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
  for (const MechanicalTest& test : loaded.tests->tests())
    (test.kind == TestKind::kTensile ? loaded.fit.grid.stretch : loaded.fit.grid.bend) = {1.0};
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

void LogBackend(const std::string& choice, const FitJobCallbacks& callbacks, std::ostream& log) {
  if (choice.empty()) return;
  const std::string line = "backend: " + choice;
  log << line << std::endl;
  if (callbacks.log) callbacks.log(line);
}

// Fills the report that has the fields or the posterior.
void FillReport(const FitJob& job, const LoadedJob& loaded, const StagedFitState& state,
                FitReport& report) {
  const auto start = std::chrono::steady_clock::now();
  report.notes = loaded.notes;
  report.tests_alone = loaded.tests_alone;
  const FitProblem& problem = loaded.problem;
  const BranchFit* best = Best(state);
  if (best == nullptr) {
    if (!problem.targets.empty()) report.notes.push_back("no branch could be fitted");
    if (problem.tests == nullptr) return;
    report.material = problem.material;
    report.spectrum = SpectrumOf(loaded.tests_alone->jacobian, job.fit.prior_sigma);
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
  if (jacobian.size() > 0) report.spectrum = SpectrumOf(jacobian, job.fit.prior_sigma);
  StepSolver solver(loaded.fine_model);
  DrapeReportOptions options;
  options.settle.h = job.fit.settle_h;
  options.settle.steps = job.evaluation_steps;
  options.replay = SettleOptionsOf(job.fit);
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
std::optional<FieldFit> FitFieldsOf(const FitJob& job, const LoadedJob& loaded,
                                    const StagedFitState& state,
                                    const StagedFitCallbacks& callbacks) {
  const BranchFit* best = Best(state);
  const bool cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  if (job.model != "heter" || best == nullptr || cancelled) return std::nullopt;
  FieldFit fit = FitFields(loaded.problem, job.fit, job.fields, *best, callbacks);
  std::ostringstream line;
  line << "fields: " << fit.summary.theta.size() << " numbers, cost " << fit.summary.initial_cost
       << " -> " << fit.summary.final_cost << ", " << ToString(fit.summary.termination) << ", "
       << fit.summary.counts.jumps << " branch jumps, " << fit.summary.counts.failed << " failed";
  callbacks.log(line.str());
  if (!fit.valid()) return std::nullopt;
  return fit;
}

// The posterior of model bayes; none as above.
std::optional<PosteriorFit> FitPosteriorOf(const FitJob& job, const LoadedJob& loaded,
                                           const StagedFitState& state,
                                           const StagedFitCallbacks& callbacks) {
  const BranchFit* best = Best(state);
  const bool cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  if (job.model != "bayes" || best == nullptr || cancelled) return std::nullopt;
  PosteriorFit fit = FitDrapePosterior(loaded.problem, job.fit, job.posterior, *best, callbacks);
  std::ostringstream line;
  line << "posterior: mode " << ToString(fit.mode.termination) << " after " << fit.mode.iterations
       << " iterations, sigma " << fit.sigma_px << " px; distribution "
       << ToString(fit.posterior.termination) << " after " << fit.posterior.iterations
       << ", bound " << fit.elbo << ", k " << fit.pareto_k << ", " << fit.counts.failed
       << " failed drapes";
  callbacks.log(line.str());
  if (!fit.valid()) return std::nullopt;
  return fit;
}

std::vector<std::string> Expand(const std::string& text, const std::string& what,
                                const std::set<std::string>& extensions,
                                const std::string& expected) {
  std::vector<std::string> files;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    std::vector<std::string> found;
    if (fs::is_regular_file(item)) {  // its name may look like a pattern
      found.push_back(item);
    } else if (fs::is_directory(item)) {
      for (const fs::directory_entry& entry : fs::directory_iterator(item))
        if (extensions.contains(entry.path().extension())) found.push_back(entry.path());
      std::sort(found.begin(), found.end());
    } else {
      glob_t matches = {};
      if (glob(item.c_str(), 0, nullptr, &matches) == 0)
        found.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
      globfree(&matches);
    }
    if (found.empty())
      throw InputError(what, "'" + item + "' matches nothing, expected " + expected);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

}  // namespace

CentreMode ParseCentreMode(const std::string& text) {
  if (text == "nominal") return CentreMode::kNominal;
  if (text == "outline") return CentreMode::kOutline;
  throw InputError("centre", "unknown name '" + text + "', expected nominal or outline");
}

FitJobResult RunFitJob(const FitJob& job, const FitJobCallbacks& callbacks) {
  LoadedJob loaded = Load(job);
  const std::string identity = Identity(job, loaded);
  StagedFitState state;
  if (job.resume) state = ReadCheckpoint(job.checkpoint, identity).value_or(StagedFitState());
  std::ofstream log(job.log, job.resume ? std::ios::app : std::ios::trunc);
  LogBackend(loaded.backend_choice, callbacks, log);
  for (const std::string& note : loaded.notes) log << note << std::endl;
  StagedFitCallbacks staged;
  staged.cancel = callbacks.cancel;
  staged.save = [&](const StagedFitState& s) { WriteCheckpoint(job.checkpoint, identity, s); };
  staged.log = [&](const std::string& line) { log << line << std::endl; };
  staged.progress = [&](const std::string& stage, double fraction, double rms) {
    if (!callbacks.progress) return;
    if (job.model != "homo")
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
  report.fields = FitFieldsOf(job, loaded, state, staged);
  report.posterior = FitPosteriorOf(job, loaded, state, staged);
  FillReport(job, loaded, state, report);
  if (job.model != "homo" && !report.fields && !report.posterior && report.fitted())
    report.notes.push_back("model " + job.model + " could not be fitted: this is its one table");
  report.cancelled = callbacks.cancel != nullptr && callbacks.cancel->load();
  WriteFitReport(job, loaded.problem, state, report);
  FitJobResult result;
  result.cancelled = report.cancelled;
  result.fitted = report.fitted();
  if (result.fitted) result.table = FitTable(loaded.problem, report, loaded.truth.get());
  if (!result.cancelled) fs::remove(job.checkpoint);
  return result;
}

std::vector<std::string> ExpandImages(const std::string& text) {
  return Expand(text, "images", {".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG"},
                "an image, a folder with .jpg or .png files, or a pattern");
}

std::vector<std::string> ExpandTests(const std::string& text) {
  return Expand(text, "tests", {".json", ".JSON"},
                "a test file, a folder with .json files, or a pattern");
}

}  // namespace drape
