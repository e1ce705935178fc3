// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/bench/bench_tool.h"

#include <filesystem>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/bench/make_accuracy_table.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/bench/bench_report.h"

namespace drape {
namespace {

std::vector<Option> AxisOptions(BenchToolOptions& options) {
  BenchAxes& axes = options.job.axes;
  return {
      FabricOption(&axes.material),
      {.key = "law", .value = &axes.law, .doc = "axis: constitutive laws, smooth or reference"},
      {.key = "model",
       .value = &axes.model,
       .doc = "axis: homogeneous (one table), heterogeneous_modes (smooth fields), "
              "heterogeneous_elements (one table per face and hinge); for fits also bdp and bayes"},
      {.key = "draws",
       .value = &axes.draws,
       .doc = "axis: number of posterior samples of a fit of the model bdp or bayes, even",
       .least = 2,
       .most = 10000},
      MeshOption("mesh", &axes.mesh, "axis: meshes, OBJ files or disc:N"),
      {.key = "solve",
       .value = &axes.integrator,
       .doc = "axis: dynamic (time steps), hybrid (time steps, then Newton's method), static (a "
              "drape relaxed on coarse_mesh, 20 time steps, then Newton's method)"},
      {.key = "time_step",
       .value = &axes.h,
       .doc = "axis: time step",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      {.key = "relax_time",
       .value = &axes.relax_time,
       .doc = "axis: simulated time; the number of steps is relax_time / time_step",
       .unit = "s",
       .least = 0,
       .most = 1000,
       .above_least = true},
      {.key = "tolerance",
       .value = &axes.tolerance,
       .doc = "axis: force residual, relative to the weight, at which Newton's method ends",
       .least = 0,
       .above_least = true},
      {.key = "mode",
       .value = &axes.mode,
       .doc = "axis: mode of differentiation, adjoint or tangent"},
  };
}

std::vector<Option> MachineAxisOptions(BenchAxes& axes) {
  return {
      {.key = "backend", .value = &axes.backend, .doc = "axis: backends cpu, cuda or auto"},
      {.key = "threads",
       .value = &axes.threads,
       .doc = "axis: number of threads of a run",
       .least = 1,
       .most = static_cast<double>(MostThreads())},
      {.key = "batch",
       .value = &axes.batch,
       .doc = "axis: number of equal drapes computed together; the times are for one of them",
       .least = 1,
       .most = 65536},
  };
}

std::vector<Option> ProblemOptions(BenchToolOptions& options) {
  BenchJob& job = options.job;
  return {
      {.key = "work",
       .value = &options.work,
       .doc = "work to measure: a drape, the gradient of a loss, the Jacobian of the outline, or a "
              "fit",
       .choices = {"forward", "gradient", "jacobian", "fit"}},
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
      {.key = "order",
       .value = &job.reference.order,
       .doc = "order of convergence in the element size, used for the extrapolation",
       .least = 0.5,
       .most = 8},
      {.key = "branch_mm",
       .value = &job.measuring.branch_mm,
       .doc = "largest rms distance of the aligned outlines for a drape on the branch of the "
              "reference; the number of folds must be equal too",
       .unit = "mm",
       .least = 0,
       .above_least = true},
      {.key = "repeats",
       .value = &job.measuring.repeats,
       .doc = "number of repeats of each run",
       .least = 1,
       .most = 1000},
      {.key = "run_seconds",
       .value = &job.measuring.seconds,
       .doc = "time after which a run is not repeated again",
       .unit = "s",
       .least = 0},
      {.key = "clock",
       .value = &options.clock,
       .doc = "time in the charts: wall clock, or processor time for a machine that others use as "
              "well",
       .choices = {"wall", "cpu"}},
  };
}

std::vector<Option> FitOptionList(BenchToolOptions& options) {
  FitSpec& spec = options.job.fit.spec;
  return {
      {.key = "images",
       .value = &options.images,
       .doc = "fits: silhouettes, fitted jointly; none: the silhouette of ground_truth",
       .is_path = true},
      {.key = "held_out",
       .value = &options.held_out,
       .doc = "fits: silhouettes on which the fitted drapes are scored",
       .is_path = true},
      {.key = "ground_truth",
       .value = &options.ground_truth,
       .doc = "fits without images: material of a synthetic silhouette",
       .is_path = true},
      MeshOption("ground_truth_mesh", &options.ground_truth_mesh,
                 "mesh of the synthetic silhouette"),
      {.key = "candidates_per_round",
       .value = &spec.stages.candidates_per_round,
       .doc = "fits: as in drape_fit",
       .least = 1},
      {.key = "iterations",
       .value = &spec.stages.iterations,
       .doc = "fits: as in drape_fit",
       .least = 1},
      {.key = "posterior_iterations",
       .value = &spec.posterior.iterations,
       .doc = "fits: as in drape_fit",
       .least = 0,
       .most = 10000},
      {.key = "min_relative_stiffness",
       .value = &spec.min_relative_stiffness,
       .doc = "fits: as in drape_fit",
       .least = 0,
       .most = 1},
  };
}

std::vector<Option> FileOptions(BenchToolOptions& options) {
  return {
      {.key = "published",
       .value = &options.published,
       .doc = "drapes: file of published times of a step, such as "
              "configs/studies/speed_published.json, drawn beside the runs in codes.png; needs the "
              "laws smooth and reference",
       .is_path = true},
      {.key = "table",
       .value = &options.table,
       .doc = "drapes: file to write the table of --accuracy to",
       .is_path = true,
       .repeated = false},
      {.key = "error_margin",
       .value = &options.safety,
       .doc = "factor on the errors in that table",
       .least = 1,
       .most = 10},
      OutOption(options.out),
      {.key = "resume",
       .value = &options.job.resume,
       .doc = "keep the finished runs of runs.csv in --out",
       .repeated = false},
  };
}

std::string Joined(const std::vector<std::string>& paths) {
  std::string text;
  for (const std::string& path : paths) {
    if (!text.empty()) text += '+';
    text += std::filesystem::path(path).filename().string();
  }
  return text;
}

// What a resumed run must have in common with the run that it continues.
std::string CommonText(const BenchToolOptions& options, const BenchJob& job) {
  std::string text = options.work;
  const auto add = [&](const std::string& name, const std::string& value) {
    text += ' ' + name + '=' + value;
  };
  const auto number = [](double value) {
    std::string digits;
    AppendNumber(digits, value);
    return digits;
  };
  add("start", Joined({options.start}));
  add("coarse_mesh", job.problem.coarse_mesh);
  if (options.work == "fit") {
    add("images",
        options.images.empty() ? Joined({options.ground_truth}) : Joined(job.fit.data.images));
    add("held_out", Joined(job.fit.held_out));
    return text;
  }
  add("reference", Joined(options.references));
  add("reference_relax_mesh", job.reference.relax_mesh);
  add("order", number(job.reference.order));
  add("branch_mm", number(job.measuring.branch_mm));
  return text;
}

std::vector<std::string> Expanded(const std::vector<std::string>& texts) {
  std::vector<std::string> all;
  for (const std::string& text : texts)
    for (const std::string& file : ExpandImages(text)) all.push_back(file);
  return all;
}

void AddSyntheticImage(const BenchToolOptions& options, BenchJob* job) {
  if (options.ground_truth.empty())
    throw InputError("option 'ground_truth'",
                     "is missing, expected a material where there are no images");
  job->fit.ground_truth =
      BenchSetting{.material = options.ground_truth, .mesh = options.ground_truth_mesh};
  job->fit.data.images = {options.out + "/silhouette.png"};
  job->fit.spec.observation.camera = {};  // the one that renders it
}

BenchJob MakeJob(const BenchToolOptions& options) {
  BenchJob job = options.job;
  job.work = ParseBenchWork(options.work);
  job.problem.seed = ReadStartShape(options.start);
  if (options.references.size() != 2)
    throw InputError("option 'reference'", "found " + std::to_string(options.references.size()) +
                                               " meshes, expected two: coarse, fine");
  job.reference.coarse = options.references[0];
  job.reference.fine = options.references[1];
  job.fit.data.images = Expanded(options.images);
  job.fit.spec.coarse_mesh = job.problem.coarse_mesh;
  job.fit.held_out = Expanded(options.held_out);
  job.out = options.out;
  if (!options.published.empty()) job.published = ReadPublishedSpeeds(options.published);
  if (job.work == BenchWork::kFit && job.fit.data.images.empty()) AddSyntheticImage(options, &job);
  job.common = CommonText(options, job);
  job.share = options.cells.ParseShare();
  return job;
}

void CheckOptions(const BenchToolOptions& options) {
  if (!options.table.empty() && options.work != "forward")
    throw InputError("option 'table'", "found work " + options.work + ", expected forward");
  if (!options.published.empty() && options.work != "forward")
    throw InputError("option 'published'", "found work " + options.work + ", expected forward");
  for (const int threads : options.job.axes.threads) RequireThreads(threads);
  const StagedFitOptions& stages = options.job.fit.spec.stages;
  if (stages.candidates_per_round.size() != stages.iterations.size())
    throw InputError("option 'iterations'",
                     "found " + std::to_string(stages.iterations.size()) +
                         " values, expected as many as 'candidates_per_round' has");
}

// Writes the table of --accuracy; why there is none, where the runs do not give one.
std::string TryTable(const BenchToolOptions& options, const BenchJob& job,
                     const BenchResult& result, BenchMeasure time) {
  try {
    WriteFileAtomically(options.table,
                        AccuracyTableText(MakeAccuracyTable(job, result, time, options.safety)));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

BenchToolResult SumUpShare(const BenchToolOptions& options, const BenchJob& job,
                           const BenchResult& result) {
  std::size_t cells = 0;
  for (std::size_t k = 0; k < ListBenchCells(job).size(); ++k) cells += job.share->Has(k);
  return {.cancelled = result.cancelled,
          .is_list = true,
          .table =
              NoReferencesText(result) + ShareText(options.cells.share, result.runs.size(), cells)};
}

}  // namespace

OptionTable BenchTable(BenchToolOptions& options) {
  return {
      .tool = "drape_bench",
      .summary =
          "measures the cost and the error of drapes, derivatives and fits over the product of "
          "several settings (axes, given as lists)",
      .example = "drape_bench --config=configs/studies/bench/quick.json --out=out/bench",
      .notes =
          "files: runs.csv (one line per run, written as it ends), bench.json (fronts, "
          "exponents of growth, all runs), front_<error>.png and .svg, growth.png and .svg, "
          "with --published codes.png and .svg\n"
          "The fronts are made of drapes at rest: at most 1e-6 of the weight is left as a force, "
          "and "
          "released, no vertex moves further than 1 mm. Other runs are shown in grey.\n"
          "Errors are relative to the drape at rest on an infinitely fine mesh, which is "
          "extrapolated from two meshes with an estimate of its own error. Newton's method "
          "leaves no error of the time step. Each run is a process of its own, so that its "
          "peak memory is its own.\n"
          "A fabric whose drape on a mesh of --reference does not come to rest is named, and the "
          "others are measured.\n"
          "exit code 3: no run has a result, or they give no --table\n"
          "Ctrl-C keeps the finished runs for --resume.\n",
      .options = Concatenate(
          Grouped("axes", Concatenate(AxisOptions(options), MachineAxisOptions(options.job.axes))),
          Grouped("problem, reference and measurement", ProblemOptions(options)),
          Grouped("fits", FitOptionList(options)),
          Grouped("camera of the images", CameraOptions(options.job.fit.spec.observation.camera)),
          Grouped("files", Concatenate(FileOptions(options), CellOptions(options.cells)))),
      .common = {"work", "fabric", "start", "mesh", "solve", "time_step", "relax_time", "reference",
                 "images", "table", "out", "resume"}};
}

BenchToolResult RunBenchTool(const BenchToolOptions& options, const RunControl& control) {
  CheckOptions(options);
  if (!options.table.empty()) CheckReplaceable(options.table);
  const BenchJob job = MakeJob(options);
  if (options.cells.list)
    return {.is_list = true, .table = ListText(ListBenchCells(job), job.share)};
  const OutputFolder out(options.out, {"bench.json", "runs.csv"},
                         job.share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  const BenchResult result = RunBench(job, control);
  if (job.share) return SumUpShare(options, job, result);
  const BenchMeasure time = TimeMeasure(options.clock);
  WriteBenchJson(out.Staged("bench.json"), job, result, time);
  const std::string missing =
      TryPictures([&] { RenderBenchCharts(out.Staged(""), job, result, time); });
  out.Publish();
  BenchToolResult summary{.cancelled = result.cancelled,
                          .measured = 0,
                          .table = BenchTableText(job, result, time) + missing};
  for (const BenchRun& run : result.runs) summary.measured += run.record.has_result();
  if (!options.table.empty() && !result.cancelled)
    summary.no_table = TryTable(options, job, result, time);
  return summary;
}

namespace {

ToolOutcome Run(const BenchToolOptions& options, const RunControl& control) {
  BenchToolResult result = RunBenchTool(options, control);
  if (result.is_list) return {.text = std::move(result.table), .cancelled = result.cancelled};
  return {.text = std::move(result.table),
          .cancelled = result.cancelled,
          .failure = result.measured > 0 ? result.no_table : "no run has a result, see bench.json"};
}

}  // namespace

int BenchMain(int argc, char** argv) { return ToolMain(argc, argv, BenchTable, Run); }

}  // namespace drape
