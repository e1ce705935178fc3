// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "solver/prediction/exchange/exchange_record.h"

namespace drape {

struct PosteriorTableOptions {
  // Samples in all, a multiple of chains; 0: the samples of the fit with their outlines
  // (samples.json), as many as fill the chains, or 1000 where the fit has none.
  int draws = 0;
  int chains = 1;  // the samples are independent: chains divide them for readers that want some
  uint64_t seed = 1;
};

// Samples of the posterior of a fit as a table in CSV: .chain, .iteration and .draw, from 1, as R's
// posterior has them, then the log factors and the linear numbers at rest. The fit's own samples
// also have lp__ = ln p(r | u) + ln p(u) and lp_approx__ = ln q(u) of the latent numbers u, whose
// difference is the log weight of a sample, and log_lik[i], the ln of the density of each observed
// radius, image after image, as R's loo takes them. Throws InputError where the source has no
// posterior of kind hierarchy, for samples that cannot be read, that do not fill the chains, or
// that have other images than the summary of the fit.
std::string PosteriorCsv(const FabricSource& source, const Law& law,
                         const PosteriorTableOptions& options);

}  // namespace drape
