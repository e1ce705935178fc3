// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/fit_input.h"
#include "tools/optimisers_tool.h"

namespace drape {

// An image of a race and where its fits begin.
struct RaceImage {
  std::string name;
  FitJob job;
  bool is_twin = false;
};

// The images of the options: twins are draped and written to out/twins/<fabric>.png unless they are
// there. Throws InputError, also for names that appear twice.
std::vector<RaceImage> RaceImages(const OptimisersOptions& options);

// An image read, with the seed that all methods start from.
struct RaceStart {
  FitJob job;
  LoadedJob loaded;
  BranchFit branch;  // without shapes where no seed comes to rest
};
// The start is kept in out/runs/<name>.start.json. cancel: ends the search; then without shapes.
RaceStart FindRaceStart(const OptimisersOptions& options, const RaceImage& image,
                        const std::atomic<bool>* cancel);

// Runs one method with so many free numbers.
RaceRecord RunMethod(const RaceStart& start, const OptimisersOptions& options, int parameters,
                     const std::string& method, const std::atomic<bool>* cancel);

// Learning rates of Adam in log units, shape [P]: the published experiments train table entries
// with 1e-14 for stretch and 3e-6 for bend (ARCSim convention), here by the mean entry of each
// parameter. Gong, Mao, Wang, CVPR 2024: experiments/drape_image_bayes_cuda_*.py.
Eigen::VectorXd PublishedAdamRates(const MaterialField& material, const Eigen::MatrixXd& tie);

}  // namespace drape
