// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_benchmark.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

template <class T>
bool HasTwice(const std::vector<T>& values) {
  return std::set<T>(values.begin(), values.end()).size() < values.size();
}

std::vector<std::string> ListMethods(const OptimiserBenchmarkOptions& options) {
  std::vector<std::string> methods = options.methods;
  for (const std::string& name : methods) FindOptimiser(name);
  if (HasTwice(methods)) throw InputError("methods", "names one twice, expected distinct names");
  if (methods.empty())
    for (const OptimiserMethod& method : OptimiserMethods())
      if (method.available && method.by_default) methods.push_back(method.name);
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
  if (HasTwice(options.parameters))
    throw InputError("num_parameters", "has one number twice, expected distinct ones");
}

// What must be the same for a run to be taken over.
std::string DescribeSettings(const OptimiserBenchmarkOptions& options,
                             const BenchmarkStart& start) {
  const OptimiserOptions& optimiser = options.optimiser;
  std::string settings = CheckpointKey(start.spec, start.data, start.input);
  for (const double value : {optimiser.budget, optimiser.jacobian_cost_units, optimiser.bound,
                             optimiser.failed_cost_factor})
    settings += Format(" %.17g", value);
  return settings;
}

std::string ProblemName(const BenchmarkImage& image, int parameters) {
  return image.name + "_" + std::to_string(parameters);
}
std::string RunName(const BenchmarkImage& image, const BenchmarkJob& job) {
  const std::string seed = job.seed == 0 ? "" : ".seed" + std::to_string(job.seed);
  return ProblemName(image, job.parameters) + "." + job.method + seed;
}

// The runs of an image: with each count of numbers of each method all seeds.
std::vector<BenchmarkJob> ListJobs(const OptimiserBenchmarkOptions& options,
                                   const std::vector<std::string>& methods) {
  std::vector<BenchmarkJob> jobs;
  for (const int parameters : options.parameters)
    for (const std::string& method : methods) {
      if (!FindOptimiser(method).random) {
        jobs.push_back({parameters, method, 0});
        continue;
      }
      for (int i = 0; i < options.seeds; ++i)
        jobs.push_back({parameters, method, options.optimiser.seed + i});
    }
  return jobs;
}

class BenchmarkRunner {
 public:
  BenchmarkRunner(const OptimiserBenchmarkOptions& options, const RunControl& control)
      : options_(options), control_(control), share_(options.cells.ParseShare()) {
    benchmark_.methods = ListMethods(options);
    jobs_ = ListJobs(options, benchmark_.methods);
  }

  OptimiserBenchmark Run() {
    const std::vector<BenchmarkImage> images = ListBenchmarkImages(options_);
    for (const BenchmarkImage& image : images)
      for (const BenchmarkJob& job : jobs_)
        CheckNameLength(image.data.images.front(), RunName(image, job) + ".json");
    if (!share_)  // those of other shares may be in use
      for (const char* kept : {"/twins", "/runs"}) RemoveTemporaries(options_.out + kept);
    RenderTwins(options_);
    std::filesystem::create_directories(options_.out + "/runs");
    total_ = static_cast<double>(images.size() * jobs_.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
      const BenchmarkImage& image = images[i];
      first_cell_ = i * jobs_.size();
      const std::size_t mine = CountMine();
      benchmark_.cells += mine;
      if (mine == 0) {
        done_ += jobs_.size();
        continue;
      }
      Report(image.name + ", initial guesses");
      const BenchmarkStart start = FindBenchmarkStart(options_, image, control_.cancel);
      if (Cancelled()) break;
      if (start.candidate.valid()) {
        RunImage(image, start);
      } else {
        benchmark_.notes.push_back(image.name + ": left out, since no initial guess comes to rest");
        done_ += jobs_.size();
      }
    }
    benchmark_.cancelled = Cancelled();
    return std::move(benchmark_);
  }

 private:
  using Records = std::vector<std::optional<BenchmarkRecord>>;  // by job

  // Whether a job of the present image is of the share.
  bool IsMine(std::size_t job) const { return !share_ || share_->Has(first_cell_ + job); }
  std::size_t CountMine() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < jobs_.size(); ++i) count += IsMine(i);
    return count;
  }
  bool Cancelled() const { return control_.cancelled(); }
  void Report(const std::string& note) const {
    control_.Report(static_cast<double>(done_) / total_, note);
  }

  void RunImage(const BenchmarkImage& image, const BenchmarkStart& start) {
    Records records;
    for (const BenchmarkJob& job : jobs_) {
      records.push_back(
          ReadBenchmarkRecord(RecordPath(image, job), ExpectRecord(image, start, job)));
      done_ += records.back().has_value();
    }
    RunMissing(image, start, records);
    for (std::size_t i = 0; i < jobs_.size(); ++i)
      benchmark_.done += IsMine(i) && records[i].has_value();
    if (!share_) AddProblems(image, records);
  }

  void AddProblems(const BenchmarkImage& image, Records& records) {
    std::size_t next = 0;
    for (const int parameters : options_.parameters) {
      const auto first = static_cast<std::ptrdiff_t>(next);
      while (next < jobs_.size() && jobs_[next].parameters == parameters) ++next;
      const auto end = records.begin() + static_cast<std::ptrdiff_t>(next);
      const bool complete =
          std::all_of(records.begin() + first, end, [](const auto& r) { return r.has_value(); });
      if (!complete) continue;
      benchmark_.problems.push_back(ProblemName(image, parameters));
      AddRuns(records, static_cast<std::size_t>(first), next);
    }
  }

  // Jobs first … end of one problem.
  void AddRuns(Records& records, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      if (i == first || jobs_[i].method != jobs_[i - 1].method) benchmark_.runs.emplace_back();
      benchmark_.runs.back().push_back(std::move(*records[i]));
    }
  }

  void RunMissing(const BenchmarkImage& image, const BenchmarkStart& start, Records& records) {
    std::vector<int> missing;
    for (int i = 0; i < static_cast<int>(jobs_.size()); ++i)
      if (!records[i] && IsMine(i)) missing.push_back(i);
    std::exception_ptr error;
#pragma omp parallel for schedule(dynamic, 1) num_threads(options_.spec.threads)
    for (int i = 0; i < static_cast<int>(missing.size()); ++i) {
      if (Cancelled()) continue;
      try {
        records[missing[i]] = RunOne(image, start, jobs_[missing[i]]);
      } catch (...) {
#pragma omp critical(drape_optimisers)
        error = std::current_exception();
      }
    }
    if (error) std::rethrow_exception(error);
  }

  // Nothing when it was cancelled.
  std::optional<BenchmarkRecord> RunOne(const BenchmarkImage& image, const BenchmarkStart& start,
                                        const BenchmarkJob& job) {
    const std::string problem = ProblemName(image, job.parameters);
#pragma omp critical(drape_optimisers)
    Report(problem + ", " + job.method);
    BenchmarkRecord record = RunMethod(start, options_, job, control_.cancel);
    record.problem = problem;
    if (Cancelled()) return std::nullopt;
    WriteBenchmarkRecord(RecordPath(image, job), DescribeSettings(options_, start), record);
#pragma omp critical(drape_optimisers)
    ++done_;
    return record;
  }

  std::string RecordPath(const BenchmarkImage& image, const BenchmarkJob& job) const {
    return options_.out + "/runs/" + RunName(image, job) + ".json";
  }

  ExpectedRecord ExpectRecord(const BenchmarkImage& image, const BenchmarkStart& start,
                              const BenchmarkJob& job) const {
    const OptimiserOptions& optimiser = options_.optimiser;
    ExpectedRecord expected{
        .settings = DescribeSettings(options_, start),
        .problem = ProblemName(image, job.parameters),
        .method = job.method,
        .seed = job.seed,
        .most_spent = optimiser.budget + std::max(1.0, optimiser.jacobian_cost_units),
        .fit = start.input.problem,
        .stages = start.spec.stages,
        .guess = start.candidate.guess};
    expected.stages.parameters =
        ParseName<ParameterTying>(std::to_string(job.parameters), "num_parameters");
    return expected;
  }

  const OptimiserBenchmarkOptions& options_;
  const RunControl& control_;
  std::optional<Share> share_;
  std::vector<BenchmarkJob> jobs_;  // of each image
  OptimiserBenchmark benchmark_;
  std::size_t first_cell_ = 0;  // of the present image
  double total_ = 1.0;
  std::size_t done_ = 0;
};

}  // namespace

int OptimiserBenchmark::num_seeds() const {
  std::size_t most = 0;
  for (const std::vector<BenchmarkRecord>& all : runs) most = std::max(most, all.size());
  return static_cast<int>(most);
}

const BenchmarkRecord& OptimiserBenchmark::Best(int problem) const {
  const BenchmarkRecord* best = &Runs(problem, 0).front();
  for (int m = 0; m < num_methods(); ++m)
    for (const BenchmarkRecord& record : Runs(problem, m))
      if (record.run.cost < best->run.cost) best = &record;
  return *best;
}

double OptimiserBenchmark::StartCost(int problem) const {
  for (int m = 0; m < num_methods(); ++m)
    for (const BenchmarkRecord& record : Runs(problem, m))
      if (!record.run.trace.empty()) return record.run.trace.front().cost;
  return std::numeric_limits<double>::infinity();
}

std::vector<std::string> ListOptimiserCells(const OptimiserBenchmarkOptions& options) {
  CheckOptions(options);
  const std::vector<BenchmarkJob> jobs = ListJobs(options, ListMethods(options));
  std::vector<std::string> cells;
  for (const BenchmarkImage& image : ListBenchmarkImages(options))
    for (const BenchmarkJob& job : jobs) cells.push_back(RunName(image, job));
  return cells;
}

OptimiserBenchmark RunOptimiserBenchmark(const OptimiserBenchmarkOptions& options,
                                         const RunControl& control) {
  CheckOptions(options);
  return BenchmarkRunner(options, control).Run();
}

}  // namespace drape
