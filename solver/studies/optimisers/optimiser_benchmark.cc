// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_benchmark.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

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
    throw InputError("twins", "is empty like images, expected at least one problem");
  if (!options.twins.empty() && options.material.empty())
    throw InputError("material", "missing, expected the start tables of the twins' fits");
  if (!options.images.empty() && options.image_materials.empty())
    throw InputError("image_materials", "missing, expected start tables of the images' fits");
  for (const int count : options.parameters)
    ParseName<ParameterTying>(std::to_string(count), "option 'num_parameters'");
}

// What must be the same for a run to be taken over.
std::string DescribeSettings(const OptimiserBenchmarkOptions& options,
                             const BenchmarkStart& start) {
  const OptimiserOptions& optimiser = options.optimiser;
  std::string settings = CheckpointKey(start.spec, start.data, start.input);
  for (const double value : {optimiser.budget, optimiser.jacobian_cost_units, optimiser.bound,
                             optimiser.failed_cost_factor, static_cast<double>(optimiser.seed)})
    settings += Format(" %.17g", value);
  return settings;
}

std::string ProblemName(const BenchmarkImage& image, int parameters) {
  return image.name + "_" + std::to_string(parameters);
}
std::string RunName(const std::string& problem, const std::string& method) {
  return problem + "." + method + ".json";
}
std::string CellName(const std::string& problem, const std::string& method) {
  return problem + "." + method;
}

class BenchmarkRunner {
 public:
  BenchmarkRunner(const OptimiserBenchmarkOptions& options, const RunControl& control)
      : options_(options), control_(control), share_(options.cells.ParseShare()) {
    benchmark_.methods = ListMethods(options);
  }

  OptimiserBenchmark Run() {
    const std::vector<BenchmarkImage> images = ListBenchmarkImages(options_);
    for (const BenchmarkImage& image : images) CheckRunNames(image);
    if (!share_)  // those of other shares may be in use
      for (const char* kept : {"/twins", "/runs"}) RemoveTemporaries(options_.out + kept);
    RenderTwins(options_);
    std::filesystem::create_directories(options_.out + "/runs");
    total_ = static_cast<double>(images.size() * RunsAnImage());
    for (std::size_t i = 0; i < images.size(); ++i) {
      const BenchmarkImage& image = images[i];
      first_cell_ = i * RunsAnImage();
      if (!HasWork()) {
        done_ += RunsAnImage();
        continue;
      }
      Report(image.name + ", initial guesses");
      const BenchmarkStart start = FindBenchmarkStart(options_, image, control_.cancel);
      if (Cancelled()) break;
      if (start.candidate.valid()) {
        for (const int parameters : options_.parameters) RunProblem(image, start, parameters);
      } else {
        benchmark_.notes.push_back(image.name + ": left out, since no initial guess comes to rest");
        done_ += RunsAnImage();
      }
    }
    benchmark_.cancelled = Cancelled();
    return std::move(benchmark_);
  }

 private:
  bool IsMine(std::size_t cell) const { return !share_ || share_->Has(cell); }
  // Whether a run of the present image is of the share.
  bool HasWork() const {
    for (std::size_t k = 0; k < RunsAnImage(); ++k)
      if (IsMine(first_cell_ + k)) return true;
    return false;
  }
  std::size_t RunsAnImage() const { return options_.parameters.size() * benchmark_.methods.size(); }
  bool Cancelled() const { return control_.cancelled(); }
  void Report(const std::string& note) const {
    control_.Report(static_cast<double>(done_) / total_, note);
  }

  void CheckRunNames(const BenchmarkImage& image) const {
    for (const int parameters : options_.parameters)
      for (const std::string& method : benchmark_.methods)
        CheckNameLength(image.data.images.front(), RunName(ProblemName(image, parameters), method));
  }

  void RunProblem(const BenchmarkImage& image, const BenchmarkStart& start, int parameters) {
    const std::string problem = ProblemName(image, parameters);
    std::vector<BenchmarkRecord> records;
    for (const std::string& method : benchmark_.methods) {
      if (Cancelled()) return;
      const bool is_mine = IsMine(done_++);
      if (!is_mine) continue;
      ++benchmark_.cells;
      Report(problem + ", " + method);
      records.push_back(RunOne(problem, start, parameters, method));
      if (!Cancelled()) ++benchmark_.done;
    }
    if (Cancelled() || share_) return;
    benchmark_.problems.push_back(problem);
    for (BenchmarkRecord& record : records) benchmark_.records.push_back(std::move(record));
  }

  BenchmarkRecord RunOne(const std::string& problem, const BenchmarkStart& start, int parameters,
                         const std::string& method) const {
    const std::string path = options_.out + "/runs/" + RunName(problem, method);
    const ExpectedRecord expected = Expected(problem, start, parameters, method);
    if (std::optional<BenchmarkRecord> kept = ReadBenchmarkRecord(path, expected))
      return std::move(*kept);
    BenchmarkRecord record = RunMethod(start, options_, parameters, method, control_.cancel);
    record.problem = problem;
    if (!Cancelled()) WriteBenchmarkRecord(path, expected.settings, record);
    return record;
  }

  ExpectedRecord Expected(const std::string& problem, const BenchmarkStart& start, int parameters,
                          const std::string& method) const {
    const OptimiserOptions& optimiser = options_.optimiser;
    ExpectedRecord expected{
        .settings = DescribeSettings(options_, start),
        .problem = problem,
        .method = method,
        .most_spent = optimiser.budget + std::max(1.0, optimiser.jacobian_cost_units),
        .fit = start.input.problem,
        .stages = start.spec.stages,
        .guess = start.candidate.guess};
    expected.stages.parameters =
        ParseName<ParameterTying>(std::to_string(parameters), "num_parameters");
    return expected;
  }

  const OptimiserBenchmarkOptions& options_;
  const RunControl& control_;
  std::optional<Share> share_;
  OptimiserBenchmark benchmark_;
  std::size_t first_cell_ = 0;  // of the present image
  double total_ = 1.0;
  std::size_t done_ = 0;
};

}  // namespace

const BenchmarkRecord& OptimiserBenchmark::Best(int problem) const {
  int best = 0;
  for (int m = 1; m < num_methods(); ++m)
    if (Record(problem, m).run.cost < Record(problem, best).run.cost) best = m;
  return Record(problem, best);
}

double OptimiserBenchmark::StartCost(int problem) const {
  for (int m = 0; m < num_methods(); ++m)
    if (!Record(problem, m).run.trace.empty()) return Record(problem, m).run.trace.front().cost;
  return std::numeric_limits<double>::infinity();
}

std::vector<std::string> ListOptimiserCells(const OptimiserBenchmarkOptions& options) {
  CheckOptions(options);
  std::vector<std::string> cells;
  for (const BenchmarkImage& image : ListBenchmarkImages(options))
    for (const int parameters : options.parameters)
      for (const std::string& method : ListMethods(options))
        cells.push_back(CellName(ProblemName(image, parameters), method));
  return cells;
}

OptimiserBenchmark RunOptimiserBenchmark(const OptimiserBenchmarkOptions& options,
                                         const RunControl& control) {
  CheckOptions(options);
  return BenchmarkRunner(options, control).Run();
}

}  // namespace drape
