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

struct PosteriorDataOptions {
  int draws = 1000;  // in all, a multiple of chains
  int chains = 1;    // the samples are independent: chains divide them for readers that want some
  uint64_t seed = 1;
  std::string prediction;  // folder of drape_predict, for posterior_predictive; empty: none
};

struct PosteriorData {
  NetcdfAttributes attributes;
  // posterior and prior: log_factor [chain, draw, parameter], stretch [N/m] [.., strain,
  // stiffness],
  //   bend [N m] [.., edge, curvature], and the seven linear numbers at rest [chain, draw];
  // observed_data: drape_coefficient and nodes [image], of the images of the fit;
  // constant_data: prior_sd, posterior_mean [parameter], posterior_covariance
  //   [parameter, parameter_bis];
  // posterior_predictive: drape_coefficient and nodes [chain, draw] of the prediction.
  // log_likelihood is left out: a fit stores no outlines of samples.
  std::vector<NetcdfGroup> groups;
};

// Throws InputError where the source has no posterior of kind hierarchy, and for a summary or a
// prediction that cannot be read.
PosteriorData CollectPosterior(const FabricSource& source, const Law& law,
                               const PosteriorDataOptions& options);

// The posterior's samples as a table: .chain, .iteration and .draw, from 1, as R's posterior has
// them, then the log factors and the linear numbers.
std::string DrawsCsv(const PosteriorData& data);

}  // namespace drape
