// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "solver/prediction/exchange/exchange_record.h"
#include "solver/prediction/exchange/statistics/netcdf.h"

namespace drape {

// The posterior of a fit as statisticians read it: groups of arrays with the names and dimensions
// of ArviZ's InferenceData, from the files of the fit alone.

inline constexpr int kNewDraws = 1000;

struct PosteriorDataOptions {
  // Samples in all, a multiple of chains; 0: those of the fit with their outlines (samples.json),
  // as many as fill the chains, or kNewDraws where the fit has none.
  int draws = 0;
  int chains = 1;  // the samples are independent: chains divide them for readers that want some
  uint64_t seed = 1;
  std::string prediction;  // folder of drape_predict, for predictions; empty: none
};

struct PosteriorData {
  NetcdfAttributes attributes;
  // posterior and prior: log_factor [chain, draw, parameter], stretch [N/m] [.., strain,
  //   stiffness], bend [N m] [.., edge, curvature], the seven linear numbers at rest [chain, draw];
  // observed_data: drape_coefficient and nodes [image], of the images of the fit;
  // constant_data: prior_sd, posterior_mean [parameter], posterior_covariance
  //   [parameter, parameter_bis];
  // predictions: drape_coefficient and nodes [chain, draw] of a folder of drape_predict;
  // with the fit's own samples also those of outline_data.h: posterior_predictive, log_likelihood,
  //   sample_stats, and outlines and sigma in the groups above.
  std::vector<NetcdfGroup> groups;
};

// Throws InputError where the source has no posterior of kind hierarchy, for a summary, samples or
// a prediction that cannot be read, and for samples that do not fill the chains.
PosteriorData CollectPosterior(const FabricSource& source, const Law& law,
                               const PosteriorDataOptions& options);

// The posterior's samples as a table: .chain, .iteration and .draw, from 1, as R's posterior has
// them, then the log factors and the linear numbers; with the fit's own samples also lp__,
// lp_approx__ and log_lik[i], image after image, as R's loo takes them.
std::string DrawsCsv(const PosteriorData& data);

}  // namespace drape
