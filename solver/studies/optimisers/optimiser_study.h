// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "solver/fit/rollout_residuals.h"
#include "solver/job/fit_input.h"
#include "solver/studies/optimisers/optimiser.h"
#include "solver/studies/runner/study.h"

namespace drape {

// The residuals of a fit as an optimiser's function: outlines by σ of all observations, then θ by σ
// of the log-prior; ½‖r‖² is the cost of Fit. Each drape is sought from the linear prediction of
// the last point with a Jacobian, so the function follows the branch of its starts; where a drape
// is not found, or refused by the options, it cannot be evaluated. any_branch: any stable drape
// counts until RefineFromBest, for methods that search globally.
class DrapeFunction final : public ResidualFunction {
 public:
  // Pointers outlive the object.
  DrapeFunction(Backend* backend, const MaterialParametrisation* parametrisation,
                std::vector<Observation> observations, const std::vector<State>& starts,
                const ResidualOptions& options, double prior_sigma, bool any_branch = false);

  int size() const override { return outlines_.num_parameters(); }
  int num_residuals() const override;
  bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                RowMatrix* jacobian) override;
  double cost_units() const override { return cost_units_; }
  // Follows the branch of the drapes of least cost from here on, with the refusals of the options.
  void RefineFromBest() override;

  // The drapes of least cost so far [m], shape [observations] of [3V]; empty before the first.
  const std::vector<Eigen::VectorXd>& best_shapes() const { return best_shapes_; }

 private:
  void Keep(double cost);

  Backend* backend_;
  std::vector<Observation> observations_;
  ResidualOptions options_;
  RolloutResiduals outlines_;
  double prior_sigma_;
  double cost_units_ = 1.0;
  double best_cost_ = std::numeric_limits<double>::infinity();
  std::vector<Eigen::VectorXd> best_shapes_;
};

// What a user of drape_compare_optimisers sets.
struct OptimiserStudyOptions {
  // How all images are fitted, except for meshes and stages. threads 0: all cores, to be counted by
  // the caller.
  FitSpec spec = FitSpecWithThreads(0);
  std::string material = kBuiltInName;  // start tables of the twins' fits
  std::vector<std::string> twins;       // fabrics whose drapes are made and fitted
  std::string mesh = "disc:400", coarse_mesh = "disc:200";  // of the fits
  std::string twin_mesh = "disc:500";
  int twin_seed = 1;  // of the twins' random starts; the i-th fabric has twin_seed + i
  std::vector<std::string> images;  // real silhouettes (ExpandImages)
  // Their start tables: one of each, or one for all.
  std::vector<std::string> image_materials = {kBuiltInName};
  std::vector<int> parameters = {7, 39};  // ParameterTying
  std::vector<std::string> methods;       // none: OptimiserMethod::by_default
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
