// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_tool.h"

#include <filesystem>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/studies/optimisers/optimiser_problem.h"
#include "tools/cli/output_folder.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/optimisers/optimisers_report.h"

namespace drape {
namespace {

std::vector<Option> ProblemOptions(OptimiserBenchmarkOptions& options) {
  FitJob& job = options.job;
  return {
      {.key = "twins",
       .value = &options.twins,
       .doc = "fabrics whose silhouettes are made and fitted",
       .is_path = true},
      MeshOption("twin_mesh", &options.twin_mesh, "cloth of the twins"),
      {.key = "twin_seed",
       .value = &options.twin_seed,
       .doc = "of the first twin's random start; the others follow",
       .least = 0,
       .most = 1000000000},
      {.key = "twin_hem_rms",
       .value = &options.twin_hem_rms,
       .doc = "size of these starts at the hem, root mean square",
       .unit = "m",
       .least = 0,
       .most = 0.05,
       .above_least = true},
      {.key = "material",
       .value = &job.material,
       .doc = "start tables of the twins' fits",
       .is_path = true},
      {.key = "images",
       .value = &options.images,
       .doc = "real silhouettes, each a problem: files, folders, patterns",
       .is_path = true},
      {.key = "image_materials",
       .value = &options.image_materials,
       .doc = "start tables of the images' fits: one for all or one of each",
       .is_path = true},
      {.key = "min_relative_stiffness",
       .value = &job.floor,
       .doc = "start entries under this share of their column's largest are raised to it",
       .least = 0,
       .most = 1},
      MeshOption("mesh", &options.mesh, "cloth of the fits"),
      MeshOption("coarse_mesh", &options.coarse_mesh, "cloth of the seed grid"),
      LawOption(job.law),
      {.key = "num_parameters",
       .value = &options.parameters,
       .doc = "free numbers, each count a problem of every image: 1, 2, 3, 7, 39",
       .least = 1,
       .most = 39},
      {.key = "sigma_px",
       .value = &job.fit.sigma_px,
       .doc = "standard deviation of the outline",
       .unit = "px",
       .least = 0,
       .above_least = true},
      {.key = "prior_sigma",
       .value = &job.fit.prior_sigma,
       .doc = "standard deviation of each log factor in the prior",
       .least = 0,
       .above_least = true},
  };
}

std::vector<Option> RaceOptions(OptimiserBenchmarkOptions& options) {
  OptimiserOptions& race = options.race;
  return {
      {.key = "methods",
       .value = &options.methods,
       .doc = "which of lm, lm_patient, dogleg, subspace_dogleg, lbfgs, adam_published, adam_0.03, "
              "adam_0.1 "
              "and, with NLopt, bobyqa, sbplx, crs, direct; none: all"},
      {.key = "budget",
       .value = &race.budget,
       .doc = "of each run, in rollouts",
       .least = 1,
       .most = 1e6},
      {.key = "jacobian_cost_units",
       .value = &race.jacobian_cost_units,
       .doc = "of a Jacobian beside its rollout, in rollouts",
       .least = 0,
       .most = 1000},
      {.key = "bound",
       .value = &race.bound,
       .doc = "box of the methods of NLopt: largest log factor",
       .least = 0,
       .most = 20,
       .above_least = true},
      {.key = "failed_cost_factor",
       .value = &race.failed_cost_factor,
       .doc = "methods of NLopt see so many times the start's cost where no drape is found",
       .least = 1,
       .most = 1e6,
       .above_least = true},
      {.key = "seed", .value = &race.seed, .doc = "of methods that draw", .least = 0},
      {.key = "branch_tolerance",
       .value = &options.branch_tolerance,
       .doc = "drapes nearer than this, root mean square of the vertices, are one branch",
       .unit = "m",
       .least = 0,
       .most = 1,
       .above_least = true},
      {.key = "threads",
       .value = &options.job.threads,
       .doc = "rollouts of the grid at a time",
       .least = 1,
       .most = 1024},
      OutOption(options.out),
  };
}

std::vector<std::string> ListMethods(const OptimiserBenchmarkOptions& options) {
  std::vector<std::string> methods = options.methods;
  for (const std::string& name : methods) FindOptimiser(name);
  if (methods.empty())
    for (const OptimiserMethod& method : OptimiserMethods())
      if (method.available) methods.push_back(method.name);
  return methods;
}

void CheckOptions(const OptimiserBenchmarkOptions& options) {
  if (options.twins.empty() && options.images.empty())
    throw InputError("twins", "none, and no images, expected at least one problem");
  if (!options.twins.empty() && options.job.material.empty())
    throw InputError("material", "missing, expected the start tables of the twins' fits");
  if (!options.images.empty() && options.image_materials.empty())
    throw InputError("image_materials", "missing, expected start tables of the images' fits");
  for (const int count : options.parameters) ParseParameterTying(std::to_string(count));
}

// What must be the same for a run to be taken over.
std::string DescribeSettings(const OptimiserBenchmarkOptions& options,
                             const BenchmarkStart& start) {
  const OptimiserOptions& race = options.race;
  std::string settings = CheckpointKey(start.job, start.loaded);
  for (const double value : {race.budget, race.jacobian_cost_units, race.bound,
                             race.failed_cost_factor, static_cast<double>(race.seed)})
    settings += Format(" %.17g", value);
  return settings;
}

class BenchmarkRunner {
 public:
  BenchmarkRunner(const OptimiserBenchmarkOptions& options, const RunControl& control)
      : options_(options), control_(control) {
    race_.methods = ListMethods(options);
  }

  OptimiserBenchmark Run() {
    const std::vector<BenchmarkImage> images = BenchmarkImages(options_);
    total_ = static_cast<double>(images.size() * RunsAnImage());
    for (const BenchmarkImage& image : images) {
      Report(image.name + ", seeds");
      const BenchmarkStart start = FindBenchmarkStart(options_, image, control_.cancel);
      if (Cancelled()) break;
      if (start.branch.valid()) {
        for (const int parameters : options_.parameters) RunProblem(image, start, parameters);
      } else {
        race_.notes.push_back(image.name + ": no seed comes to rest, left out");
        done_ += RunsAnImage();
      }
    }
    race_.cancelled = Cancelled();
    return std::move(race_);
  }

 private:
  std::size_t RunsAnImage() const { return options_.parameters.size() * race_.methods.size(); }
  bool Cancelled() const { return control_.cancelled(); }
  void Report(const std::string& note) const {
    control_.Report(static_cast<double>(done_) / total_, note);
  }

  void RunProblem(const BenchmarkImage& image, const BenchmarkStart& start, int parameters) {
    const std::string problem = image.name + "_" + std::to_string(parameters);
    std::vector<BenchmarkRecord> records;
    for (const std::string& method : race_.methods) {
      if (Cancelled()) return;
      Report(problem + ", " + method);
      records.push_back(RunOne(problem, start, parameters, method));
      ++done_;
    }
    if (Cancelled()) return;
    race_.problems.push_back(problem);
    for (BenchmarkRecord& record : records) race_.records.push_back(std::move(record));
  }

  BenchmarkRecord RunOne(const std::string& problem, const BenchmarkStart& start, int parameters,
                         const std::string& method) const {
    const std::string path = options_.out + "/runs/" + problem + "." + method + ".json";
    const std::string settings = DescribeSettings(options_, start);
    if (std::optional<BenchmarkRecord> kept = ReadBenchmarkRecord(path, settings))
      return std::move(*kept);
    BenchmarkRecord record = RunMethod(start, options_, parameters, method, control_.cancel);
    record.problem = problem;
    if (!Cancelled()) WriteBenchmarkRecord(path, settings, record);
    return record;
  }

  const OptimiserBenchmarkOptions& options_;
  const RunControl& control_;
  OptimiserBenchmark race_;
  double total_ = 1.0;
  std::size_t done_ = 0;
};

}  // namespace

OptionTable OptimiserBenchmarkTable(OptimiserBenchmarkOptions& options) {
  std::vector<Option> all = ProblemOptions(options);
  for (const Option& option : RaceOptions(options)) all.push_back(option);
  return {.tool = "drape_compare_optimisers",
          .summary = "optimisers compared: the same cost, start and budget on many silhouettes",
          .example =
              "drape_compare_optimisers --config=configs/studies/compare_optimisers.json "
              "--out=out/optimisers",
          .notes =
              "files: summary.json, report.md, traces.csv, convergence.png, profiles.png and "
              "branches.png, which replace those of\n  an earlier run together, at the end; "
              "twins/ and runs/, which a run that was interrupted goes on from\n"
              "exit code 3: no problem has a start\nCtrl-C keeps the runs that are done\n",
          .options = std::move(all)};
}

OptimiserBenchmark RunOptimiserBenchmark(const OptimiserBenchmarkOptions& options,
                                         const RunControl& control) {
  CheckOptions(options);
  BenchmarkRunner racer(options, control);
  const OutputFolder out(options.out);
  std::filesystem::create_directories(options.out + "/runs");
  OptimiserBenchmark race = racer.Run();
  if (race.problems.empty()) return race;
  WriteBenchmarkReport(options, race, out);
  out.Publish();
  return race;
}

}  // namespace drape
