// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/job/fit_input.h"
#include "solver/studies/bench/bench_study.h"
#include "solver/studies/bench/speed_study.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/fit_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

// The options of drape_bench.
struct BenchOptions {
  BenchJob job;
  std::string start;                                                 // ReadStartShape
  std::vector<std::string> references = {"disc:2400", "disc:4800"};  // coarse, fine
  std::string clock = "wall";                 // by which charts and the table count
  std::vector<std::string> images, held_out;  // of fits (ExpandImages)
  std::string ground_truth;                   // without images: whose silhouette is fitted
  std::string ground_truth_mesh = "disc:1200";
  std::string published;       // of other programs (ReadPublishedSpeeds); empty: none
  double error_margin = 1.25;  // factor on the errors that the table of --accuracy promises
  StudyOptions study = {.processes = true};
};

std::vector<Option> AxisOptions(BenchOptions& options) {
  BenchAxes& axes = options.job.axes;
  return {
      FabricOption(&axes.material),
      ChoiceOption("law", &axes.law, {"reference", "smooth"}, "axis: constitutive laws"),
      ChoiceOption(
          "model", &axes.model,
          {"homogeneous", "heterogeneous_modes", "heterogeneous_elements", "bdp", "bayes"},
          "axis: one table, smooth fields, one table per face and hinge; for fits also bdp and "
          "bayes"),
      NumberOption("draws", &axes.draws, 2, 10000,
                   "axis: number of posterior samples of a fit of the model bdp or bayes, even"),
      MeshOption("mesh", &axes.mesh, "axis: meshes, OBJ files or disc:N"),
      ChoiceOption(
          "solve", &axes.integrator, {"dynamic", "hybrid", "static"},
          "axis: dynamic (time steps), hybrid (time steps, then Newton's method), static (a "
          "drape relaxed on coarse_mesh, 20 time steps, then Newton's method)"),
      TimeStepOption(&axes.h, "axis: time step"),
      PositiveOption("relax_time", &axes.relax_time, 1000,
                     "axis: simulated time; the number of steps is relax_time / time_step", "s"),
      PositiveOption("tolerance", &axes.tolerance, kUnlimited,
                     "axis: force residual, relative to the weight, at which Newton's method ends"),
      ChoiceOption("mode", &axes.mode, {"adjoint", "tangent"}, "axis: mode of differentiation"),
  };
}

std::vector<Option> MachineAxisOptions(BenchAxes& axes) {
  return {
      ChoiceOption("backend", &axes.backend, {"auto", "cpu", "cuda"}, "axis: backends"),
      NumberOption("threads", &axes.threads, 1, static_cast<double>(MostThreads()),
                   "axis: number of threads of a run"),
      NumberOption("batch", &axes.batch, 1, 65536,
                   "axis: number of equal drapes computed together; the times are for one of them"),
  };
}

std::vector<Option> ProblemOptions(BenchOptions& options) {
  BenchJob& job = options.job;
  return {
      EnumOption(
          "work", job.work,
          "work to measure: a drape, the gradient of a loss, the Jacobian of the outline, or "
          "a fit"),
      {.key = "start",
       .value = &options.start,
       .doc = "start shape of all drapes, which selects the branch",
       .is_path = true,
       .required = true},
      MeshOption("coarse_mesh", &job.problem.coarse_mesh,
                 "mesh on which static drapes are relaxed first; for fits, the mesh of the "
                 "initial-guess grid"),
      MeshOption("reference", &options.references,
                 "coarse and fine mesh whose drapes are extrapolated to the reference"),
      MeshOption("reference_relax_mesh", &job.reference.relax_mesh,
                 "mesh on which the reference is relaxed before Newton's method on these two"),
      NumberOption("order", &job.reference.order, 0.5, 8,
                   "order of convergence in the element size, used for the extrapolation"),
      PositiveOption(
          "branch_mm", &job.measuring.branch_mm, kUnlimited,
          "largest rms distance of the aligned outlines for a drape on the branch of the "
          "reference; the number of folds must be equal too",
          "mm"),
      NumberOption("repeats", &job.measuring.repeats, 1, 1000, "number of repeats of each run"),
      NumberOption("run_seconds", &job.measuring.seconds, 0, kUnlimited,
                   "time after which a run is not repeated again", "s"),
      ChoiceOption(
          "clock", &options.clock, {"wall", "cpu"},
          "time in tables and charts: wall clock, or processor time for a machine that others "
          "use as well"),
  };
}

std::vector<Option> FitOptionList(BenchOptions& options) {
  FitSpec& spec = options.job.fit.spec;
  return {
      PathOption("images", &options.images,
                 "fits: silhouettes, fitted jointly; none: the silhouette of ground_truth"),
      PathOption("held_out", &options.held_out,
                 "fits: silhouettes on which the fitted drapes are scored"),
      PathOption("ground_truth", &options.ground_truth,
                 "fits without images: material of a synthetic silhouette"),
      MeshOption("ground_truth_mesh", &options.ground_truth_mesh,
                 "mesh of the synthetic silhouette"),
      NumberOption("candidates_per_round", &spec.stages.candidates_per_round, 1, kUnlimited,
                   "fits: as in drape_fit"),
      NumberOption("iterations", &spec.stages.iterations, 1, kUnlimited, "fits: as in drape_fit"),
      NumberOption("posterior_iterations", &spec.posterior.iterations, 0, 10000,
                   "fits: as in drape_fit"),
      NumberOption("min_relative_stiffness", &spec.min_relative_stiffness, 0, 1,
                   "fits: as in drape_fit"),
  };
}

std::vector<Option> FileOptions(BenchOptions& options) {
  return {
      PathOption(
          "published", &options.published,
          "drapes: file of published times of a step, such as "
          "configs/studies/speed_published.json, drawn beside the runs in codes.png; needs the "
          "laws smooth and reference"),
      NumberOption("error_margin", &options.error_margin, 1, 10,
                   "drapes: factor on the errors in accuracy.json"),
  };
}

std::vector<std::string> Expanded(const std::vector<std::string>& texts) {
  std::vector<std::string> all;
  for (const std::string& text : texts)
    for (const std::string& file : ExpandImages(text)) all.push_back(file);
  return all;
}

OptionTable BenchTable(BenchOptions& options);

// The options beside axes and files that the runs depend on.
nlohmann::json Settings(BenchOptions options) {
  return OptionSettings(
      BenchTable(options),
      {"fabric", "law", "model", "draws", "mesh", "solve", "time_step", "relax_time", "tolerance",
       "mode", "backend", "threads", "batch", "clock", "published", "error_margin"});
}

// The silhouette that is fitted where no images are given.
void AddSyntheticImage(const BenchOptions& options, BenchJob* job) {
  if (options.ground_truth.empty())
    throw InputError("option 'ground_truth'",
                     "is missing, expected a material where there are no images");
  job->fit.ground_truth =
      BenchSetting{.material = options.ground_truth, .mesh = options.ground_truth_mesh};
  job->fit.data.images = {options.study.out + "/silhouette.png"};
  job->fit.spec.observation.camera = {};  // the one that renders it
}

BenchJob MakeJob(const BenchOptions& options) {
  BenchJob job = options.job;
  job.settings = Settings(options);
  const ReadRecord record;
  job.problem.seed = ReadStartShape(options.start);
  job.files = record.files();
  if (options.references.size() != 2)
    throw InputError("option 'reference'", "found " + std::to_string(options.references.size()) +
                                               " meshes, expected two: coarse, fine");
  job.reference.coarse = options.references[0];
  job.reference.fine = options.references[1];
  job.fit.data.images = Expanded(options.images);
  job.fit.spec.coarse_mesh = job.problem.coarse_mesh;
  job.fit.held_out = Expanded(options.held_out);
  job.out = options.study.out;
  if (job.work == BenchWork::kFit && job.fit.data.images.empty()) AddSyntheticImage(options, &job);
  return job;
}

void CheckOptions(const BenchOptions& options) {
  if (!options.published.empty() && options.job.work != BenchWork::kForward)
    throw InputError("option 'published'", "found work " + std::string(ToString(options.job.work)) +
                                               ", expected forward");
  constexpr double kMostSteps = 1e6;
  for (const double h : options.job.axes.h)
    for (const double time : options.job.axes.relax_time)
      if (!(time / h <= kMostSteps))
        throw InputError("option 'time_step'",
                         Format("found %g s for %g s, expected at most 1e6 time steps", h, time));
  for (const int threads : options.job.axes.threads) RequireThreads(threads);
  CheckRounds(options.job.fit.spec.stages);
}

OptionTable BenchTable(BenchOptions& options) {
  return {
      .tool = "drape_bench",
      .summary =
          "measures the cost and the error of drapes, derivatives and fits over the product of "
          "several settings (axes, given as lists)",
      .example = "drape_bench --config=configs/studies/bench/quick.json --out=out/bench",
      .notes =
          "files: bench.json, runs.csv (one line per run), report.md (fronts, exponents of "
          "growth), "
          "as .svg and .png front_<error> and growth, with --published codes; of drapes "
          "accuracy.json, the table of --accuracy; of fits fits/; cells/ has the finished runs and "
          "references, from which the same command continues\n"
          "The fronts are made of drapes at rest: at most 1e-6 of the weight is left as a force, "
          "and "
          "released, no vertex moves further than 1 mm. Other runs are shown in grey.\n"
          "Errors are relative to the drape at rest on an infinitely fine mesh, which is "
          "extrapolated from two meshes with an estimate of its own error. Newton's method "
          "leaves no error of the time step. Each run is a process of its own, so that its "
          "peak memory is its own.\n"
          "A fabric whose drape on a mesh of --reference does not come to rest is named, and the "
          "others are measured.\n"
          "exit code 3: no run has a result\n",
      .options = Concatenate(
          Grouped("axes", Concatenate(AxisOptions(options), MachineAxisOptions(options.job.axes))),
          Grouped("problem, reference and measurement", ProblemOptions(options)),
          Grouped("fits", FitOptionList(options)),
          Grouped("camera of the images", FieldOptionList(options.job.fit.spec.observation.camera)),
          Grouped("files", Concatenate(FileOptions(options), StudyOptionList(options.study)))),
      .common = {"work", "fabric", "start", "mesh", "solve", "time_step", "relax_time", "reference",
                 "images", "out"}};
}

bool HasResult(const nlohmann::json& run) {
  const std::string status = run.at("status");
  return status == "ok" || status == "other branch" || status == "not at rest";
}

ToolOutcome Run(const BenchOptions& options, const RunControl& control) {
  CheckOptions(options);
  const Study study = MakeBenchStudy(MakeJob(options));
  nlohmann::json published;
  if (!options.published.empty()) published = ReadPublishedSpeeds(options.published);
  bool has_results = options.study.list || !options.study.share.empty();
  const auto summarise = [&](const StudyResult& result) {
    for (const auto& run : result.results) has_results = has_results || (run && HasResult(*run));
    nlohmann::ordered_json json = SummariseCells(study, result);
    json["start"] = NameWithoutFolder(options.start);
    json["clock"] = options.clock;
    json["error_margin"] = options.error_margin;
    json["published"] = published;
    return json;
  };
  ToolOutcome outcome = RunStudyProgram(study, options.study, control, summarise);
  if (!has_results && !outcome.cancelled) outcome.failure = "no run has a result, see bench.json";
  return outcome;
}

}  // namespace

int BenchMain(int argc, char** argv) { return ToolMain(argc, argv, BenchTable, Run); }

}  // namespace drape
