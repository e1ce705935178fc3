// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/bench/bench_tool.h"

#include <filesystem>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "solver/studies/bench/make_accuracy_table.h"
#include "tools/cli/output_folder.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/bench/bench_report.h"

namespace drape {
namespace {

std::vector<Option> AxisOptions(BenchAxes& axes) {
  return {
      {.key = "material",
       .value = &axes.material,
       .doc = "axis: material files; of a fit, its start tables",
       .is_path = true,
       .required = true},
      {.key = "law", .value = &axes.law, .doc = "axis: smooth, reference"},
      {.key = "model",
       .value = &axes.model,
       .doc = "axis: homo (one table), heter_modes (smooth fields), heter_elements (a table for "
              "each face and hinge); of fits also bdp and bayes"},
      {.key = "draws",
       .value = &axes.draws,
       .doc = "axis: draws behind the distribution of a fit of model bdp or bayes, even",
       .least = 2,
       .most = 10000},
      MeshOption("mesh", &axes.mesh, "axis: OBJ files or disc:N"),
      {.key = "solve",
       .value = &axes.integrator,
       .doc = "axis: dynamic (falls), hybrid (falls, then Newton), static (a drape that "
              "fell on coarse_mesh, 20 steps, then Newton)"},
      {.key = "time_step",
       .value = &axes.h,
       .doc = "axis: time step of the fall",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      {.key = "relax_time",
       .value = &axes.fall,
       .doc = "axis: how long it falls; steps = fall / h",
       .unit = "s",
       .least = 0,
       .most = 1000,
       .above_least = true},
      {.key = "tolerance",
       .value = &axes.tolerance,
       .doc = "axis: force residual by weight at which Newton ends",
       .least = 0,
       .above_least = true},
      {.key = "mode", .value = &axes.mode, .doc = "axis: adjoint, tangent (of a derivative)"},
      {.key = "backend", .value = &axes.backend, .doc = "axis: cpu, cuda, auto"},
      {.key = "threads",
       .value = &axes.threads,
       .doc = "axis: threads of a cell",
       .least = 1,
       .most = 1024},
      {.key = "batch",
       .value = &axes.batch,
       .doc = "axis: equal drapes at once; seconds are those of one",
       .least = 1,
       .most = 65536},
  };
}

std::vector<Option> ProblemOptions(BenchToolOptions& options) {
  BenchJob& job = options.job;
  return {
      {.key = "work",
       .value = &options.work,
       .doc = "a drape, with the gradient of a loss, with the Jacobian of its outline, or a fit",
       .choices = {"forward", "gradient", "jacobian", "fit"}},
      {.key = "seed",
       .value = &options.seed,
       .doc = "start shape, which holds the branch",
       .is_path = true,
       .required = true},
      MeshOption("coarse_mesh", &job.problem.coarse_mesh,
                 "on which a static cell falls; of a fit, the mesh of the seed grid"),
      MeshOption("reference", &options.references,
                 "the two meshes, coarse then fine, whose drapes are extrapolated to the "
                 "reference"),
      MeshOption("reference_relax_mesh", &job.reference.fall,
                 "mesh on which the reference falls before Newton on these two"),
      {.key = "order",
       .value = &job.reference.order,
       .doc = "of the error in the size of the elements, for the extrapolation",
       .least = 0.5,
       .most = 8},
      {.key = "branch_mm",
       .value = &job.cell.branch_mm,
       .doc = "a drape whose outline, turned to match, is further from the reference (rms), or "
              "that has "
              "other folds, is on another branch",
       .unit = "mm",
       .least = 0,
       .above_least = true},
      {.key = "repeats",
       .value = &job.cell.repeats,
       .doc = "runs of each cell",
       .least = 1,
       .most = 1000},
      {.key = "cell_seconds",
       .value = &job.cell.seconds,
       .doc = "no further run of a cell once it has taken that long",
       .unit = "s",
       .least = 0},
      {.key = "clock",
       .value = &options.clock,
       .doc = "of the charts; cpu: processor time, for a machine that others use too",
       .choices = {"wall", "cpu"}},
  };
}

std::vector<Option> FitAndFileOptions(BenchToolOptions& options) {
  FitJob& job = options.job.fit.job;
  return {
      {.key = "images",
       .value = &options.images,
       .doc = "work fit: silhouettes, fitted jointly; none: that of `truth`",
       .is_path = true},
      {.key = "held_out",
       .value = &options.held_out,
       .doc = "work fit: silhouettes on which the fitted drapes are scored",
       .is_path = true},
      {.key = "ground_truth",
       .value = &options.truth,
       .doc = "work fit without images: the fabric whose silhouette is made and fitted",
       .is_path = true},
      MeshOption("truth_mesh", &options.truth_mesh, "and on which mesh"),
      {.key = "candidates_per_round",
       .value = &job.fit.keep,
       .doc = "work fit: as in drape_fit",
       .least = 1},
      {.key = "iterations",
       .value = &job.fit.iterations,
       .doc = "work fit: as in drape_fit",
       .least = 1},
      {.key = "posterior_iterations",
       .value = &job.posterior.iterations,
       .doc = "work fit: as in drape_fit",
       .least = 0,
       .most = 10000},
      {.key = "min_relative_stiffness",
       .value = &job.floor,
       .doc = "work fit: as in drape_fit",
       .least = 0,
       .most = 1},
      {.key = "table",
       .value = &options.table,
       .doc = "work forward: write the table of --accuracy to this file",
       .is_path = true},
      {.key = "error_margin",
       .value = &options.safety,
       .doc = "factor on the errors that the table promises",
       .least = 1,
       .most = 10},
      OutOption(options.out),
      {.key = "resume", .value = &options.job.resume, .doc = "go on with out/cells.csv"},
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

// What a resumed run must have in common with the run that it goes on with.
std::string CommonText(const BenchToolOptions& options) {
  const BenchJob& job = options.job;
  std::string text = options.work;
  const auto add = [&](const std::string& name, const std::string& value) {
    text += ' ' + name + '=' + value;
  };
  const auto number = [](double value) {
    std::string digits;
    AppendNumber(digits, value);
    return digits;
  };
  add("seed", Joined({options.seed}));
  add("coarse_mesh", job.problem.coarse_mesh);
  if (options.work == "fit") {
    add("images", options.images.empty() ? Joined({options.truth}) : Joined(job.fit.job.images));
    add("held_out", Joined(job.fit.held_out));
    return text;
  }
  add("reference", Joined(options.references));
  add("reference_relax_mesh", job.reference.fall);
  add("order", number(job.reference.order));
  add("branch_mm", number(job.cell.branch_mm));
  return text;
}

std::vector<std::string> Expanded(const std::vector<std::string>& texts) {
  std::vector<std::string> all;
  for (const std::string& text : texts)
    for (const std::string& file : ExpandImages(text)) all.push_back(file);
  return all;
}

void MakeTruth(BenchToolOptions* options, const std::atomic<bool>* cancel) {
  if (options->truth.empty())
    throw InputError("option 'ground_truth'",
                     "found none, expected a fabric where there are no images");
  const std::string path = options->out + "/silhouette.png";
  const BenchSetting truth{.material = options->truth, .mesh = options->truth_mesh};
  RunInChild(
      [&] {
        DrawTruth(truth, options->job.problem, path);
        return std::string();
      },
      cancel);
  options->job.fit.job.images = {path};
}

BenchJob MakeJob(BenchToolOptions* options, const std::atomic<bool>* cancel) {
  BenchJob& job = options->job;
  job.work = ParseBenchWork(options->work);
  job.problem.seed = ReadStartShape(options->seed);
  if (options->references.size() != 2)
    throw InputError("option 'reference'", "found " + std::to_string(options->references.size()) +
                                               " meshes, expected two: coarse, fine");
  job.reference.coarse = options->references[0];
  job.reference.fine = options->references[1];
  job.fit.job.images = Expanded(options->images);
  job.fit.job.coarse_mesh = job.problem.coarse_mesh;
  job.fit.held_out = Expanded(options->held_out);
  job.out = options->out;
  if (job.work == BenchWork::kFit && job.fit.job.images.empty()) MakeTruth(options, cancel);
  job.common = CommonText(*options);
  return job;
}

void CheckOptions(const BenchToolOptions& options) {
  if (!options.table.empty() && options.work != "forward")
    throw InputError("option 'table'", "found work " + options.work + ", expected forward");
  const auto& fit = options.job.fit.job.fit;
  if (fit.keep.size() != fit.iterations.size())
    throw InputError("option 'iterations'", "found " + std::to_string(fit.iterations.size()) +
                                                " values, expected as many as 'keep' has");
}

}  // namespace

OptionTable BenchTable(BenchToolOptions& options) {
  std::vector<Option> all = AxisOptions(options.job.axes);
  for (const Option& option : ProblemOptions(options)) all.push_back(option);
  for (const Option& option : FitAndFileOptions(options)) all.push_back(option);
  return {.tool = "drape_bench",
          .summary =
              "work against precision: what drapes, derivatives and fits cost, and how far off "
              "they are, over the product of some settings (axes, given as lists)",
          .example = "drape_bench --config=configs/studies/bench/quick.json --out=out/bench",
          .notes =
              "files: cells.csv (a line a cell, as they end), bench.json (fronts, exponents of "
              "growth, all cells),\n  front_<error>.png and .svg, growth.png and .svg\n"
              "Errors are against the drape at rest on an infinitely fine mesh: those of two "
              "meshes extrapolated, with an estimate\n  of their own error. Newton leaves no "
              "error of the time step. Each cell runs in a process of its own: peak memory is "
              "its own.\n"
              "exit code 3: no cell has a result\nCtrl-C keeps the cells that ended for "
              "--resume\n",
          .options = std::move(all)};
}

BenchToolResult RunBenchTool(BenchToolOptions options, const RunControl& control) {
  CheckOptions(options);
  const OutputFolder out(options.out);
  const BenchJob job = MakeJob(&options, control.cancel);
  const BenchResult result = RunBench(job, control);
  const BenchMeasure time = TimeMeasure(options.clock);
  WriteBenchJson(out.Staged("bench.json"), job, result, time);
  RenderBenchCharts(out.Staged(""), job, result, time);
  out.Publish();
  if (!options.table.empty() && !result.cancelled)
    WriteFileAtomically(options.table,
                        AccuracyTableText(MakeAccuracyTable(job, result, time, options.safety)));
  BenchToolResult summary{
      .cancelled = result.cancelled, .measured = 0, .table = BenchTableText(job, result, time)};
  for (const BenchCell& cell : result.cells) summary.measured += cell.record.status == "ok";
  return summary;
}

}  // namespace drape
