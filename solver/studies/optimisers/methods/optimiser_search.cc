// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "physics/util/math/random.h"
#include "solver/studies/optimisers/methods/metered_cost.h"
#include "solver/studies/optimisers/methods/optimiser_methods.h"
#include "solver/studies/optimisers/methods/search/bayesian_search.h"
#include "solver/studies/optimisers/methods/search/cma_es.h"

namespace drape {
namespace {

// The number after a prefix that the name has, else 0.
int DimensionAfter(std::string_view prefix, const std::string& name) {
  return name.starts_with(prefix) ? std::stoi(name.substr(prefix.size())) : 0;
}

}  // namespace

std::string RunSearch(BudgetedFunction& function, SearchMethod& search) {
  MeteredCost cost(function);
  while (!function.exhausted() && !search.converged())
    search.Report(cost.Evaluate(search.Propose()));
  return search.converged() ? "converged" : "budget spent";
}

std::unique_ptr<SearchMethod> MakeSearch(const std::string& name, int size,
                                         const OptimiserOptions& options) {
  constexpr uint64_t kEmbeddings = 0, kSearches = 1;  // streams of the seed
  constexpr double kStepsToBound = 3.0;               // of the evolution strategy
  std::mt19937_64 random(SeedOfStream(options.seed, kEmbeddings));
  const uint64_t seed = SeedOfStream(options.seed, kSearches);
  if (name == "cmaes")
    return std::make_unique<CmaEs>(size, options.bound, options.bound / kStepsToBound, seed);
  BayesianSearchOptions settings;
  Embedding embedding;
  if (name == "bo") {
    embedding = MakeIdentityEmbedding(size);
  } else if (const int upper = DimensionAfter("rembo_ucb_", name); upper > 0) {
    settings.kernel = Kernel::kSquaredExponential;
    settings.acquisition = BayesianSearchOptions::Acquisition::kUpperConfidenceBound;
    settings.initial_points = 1;
    settings.initial_variance = 1e-6;
    embedding = MakeGaussianEmbedding(size, upper, random);
    embedding.box = std::max(1.5, 1.5 * std::log(static_cast<double>(upper)));
  } else if (const int gaussian = DimensionAfter("rembo_", name); gaussian > 0) {
    settings.initial_variance = 1e-6;
    embedding = MakeGaussianEmbedding(size, gaussian, random);
  } else {
    const int hashed = DimensionAfter("hesbo_", name);
    CHECK_GT(hashed, 0) << name;
    embedding = MakeHashingEmbedding(size, hashed, random);
  }
  return std::make_unique<BayesianSearch>(std::move(embedding), options.bound, settings, seed);
}

}  // namespace drape
