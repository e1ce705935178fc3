// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/job/fit_input.h"
#include "solver/studies/cells/share.h"
#include "solver/studies/optimisers/optimiser_record.h"

namespace drape {

// What a user of drape_compare_optimisers sets.
struct OptimiserBenchmarkOptions {
  // Of all fits, but for meshes and stages; threads 0: all cores, to be counted by the caller.
  FitSpec spec = FitSpecWithThreads(0);
  std::string material;            // start tables of the twins' fits
  std::string base;                // of materials without stretch; the caller applies it
  std::vector<std::string> twins;  // fabrics whose drapes are made and fitted
  std::string mesh = "disc:400", coarse_mesh = "disc:200";  // of the fits
  std::string twin_mesh = "disc:500";
  int twin_seed = 1;           // of the twins' random starts; the i-th fabric has twin_seed + i
  double twin_hem_rms = 5e-3;  // of the starts [m]
  std::vector<std::string> images;           // real silhouettes (ExpandImages)
  std::vector<std::string> image_materials;  // their start tables: one of each, or one for all
  std::vector<int> parameters = {7, 39};     // ParameterTying
  std::vector<std::string> methods;          // none: OptimiserMethod::by_default
  OptimiserOptions optimiser;
  int seeds = 1;  // runs of a method that draws random numbers, from optimiser.seed upwards
  std::vector<double> checkpoints = {60.0, 200.0, 1000.0};  // budgets that tables report
  double branch_tolerance = 3e-3;  // drapes nearer than this are one branch [m]
  CellChoice cells;
  std::string out;
};

// The checkpoints below the budget, ascending, and the budget.
std::vector<double> ReportedBudgets(const OptimiserBenchmarkOptions& options);

// An image of the benchmark with its start tables.
struct BenchmarkImage {
  std::string name;
  FitData data;
  bool is_twin = false;
};

// The images of the options; those of twins are out/twins/<fabric>_<seed>.png. Reads what they are
// made of. Throws InputError, also for names that appear twice.
std::vector<BenchmarkImage> ListBenchmarkImages(const OptimiserBenchmarkOptions& options);
// Drapes the twins and writes their images, unless they are there. Throws InputError.
void RenderTwins(const OptimiserBenchmarkOptions& options);

// An image read, with the initial guess that all methods start from.
struct BenchmarkStart {
  FitSpec spec;
  FitData data;
  FitInput input;
  FitCandidate candidate;  // without shapes where no initial guess settles into a stable drape
};
// The start is kept in out/runs/<name>.start.json. cancel: ends the search; then without shapes.
BenchmarkStart FindBenchmarkStart(const OptimiserBenchmarkOptions& options,
                                  const BenchmarkImage& image, const std::atomic<bool>* cancel);

// A run of one method.
struct BenchmarkJob {
  int parameters = 0;  // free numbers
  std::string method;
  int seed = 0;  // 0 where the method draws no random numbers
};
// Runs a job on one core. May be called from several threads at a time.
BenchmarkRecord RunMethod(const BenchmarkStart& start, const OptimiserBenchmarkOptions& options,
                          const BenchmarkJob& job, const std::atomic<bool>* cancel);

// Learning rates of Adam in log units, shape [P]: the published experiments train table entries
// with 1e-14 for stretch and 3e-6 for bend (ARCSim convention), here by the mean entry of each
// parameter. Code of [Gong 2024]: experiments/drape_image_bayes_cuda_*.py.
Eigen::VectorXd PublishedAdamRates(const MaterialField& material, const Eigen::MatrixXd& tie);

}  // namespace drape
