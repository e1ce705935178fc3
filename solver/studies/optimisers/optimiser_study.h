// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/job/fit_input.h"
#include "solver/studies/optimisers/methods/budgeted_function.h"
#include "solver/studies/runner/study.h"

namespace drape {

// What a user of drape_compare_optimisers sets.
struct OptimiserStudyOptions {
  // How all images are fitted, except for meshes and stages. threads 0: all cores, to be counted by
  // the caller.
  FitSpec spec = FitSpecWithThreads(0);
  std::string material;            // start tables of the twins' fits
  std::string base;                // of materials without stretch; the caller applies it
  std::vector<std::string> twins;  // fabrics whose drapes are made and fitted
  std::string mesh = "disc:400", coarse_mesh = "disc:200";  // of the fits
  std::string twin_mesh = "disc:500";
  int twin_seed = 1;  // of the twins' random starts; the i-th fabric has twin_seed + i
  std::vector<std::string> images;           // real silhouettes (ExpandImages)
  std::vector<std::string> image_materials;  // their start tables: one of each, or one for all
  std::vector<int> parameters = {7, 39};     // ParameterTying
  std::vector<std::string> methods;          // none: OptimiserMethod::by_default
  OptimiserOptions optimiser;
  int seeds = 1;  // runs of a method that draws random numbers, from optimiser.seed upwards
  std::vector<double> checkpoints = {60.0, 200.0, 1000.0};  // budgets that tables report
  StudyOptions study;
};

// Each method on each problem: an image (real, or the silhouette of a twin) with 1 to 39 free
// numbers, from the best initial guess of the grid as RunStagedFit finds it. A cell is a run on one
// core, "synthetic_wool_1_7.bo.seed2": image, free numbers, method and seed; it fails where no
// initial guess comes to rest. Reads all inputs and writes the silhouettes of the twins to
// OUT/twins, unless the cells are only listed. `options` outlives the study. Throws InputError.
Study MakeOptimiserStudy(const OptimiserStudyOptions& options);

// Learning rates of Adam in log units, shape [P]: the published experiments train table entries
// with 1e-14 for stretch and 3e-6 for bend (ARCSim convention), here by the mean entry of each
// parameter. Code of [Gong 2024]: experiments/drape_image_bayes_cuda_*.py.
Eigen::VectorXd PublishedAdamRates(const MaterialField& material, const Eigen::MatrixXd& tie);

}  // namespace drape
