// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "solver/posterior/samples/stored_samples.h"
#include "solver/prediction/exchange/statistics/netcdf.h"

namespace drape {

// The outlines of a fit's samples as groups of InferenceData, for S samples, a multiple of
// `chains`. Arrays of outlines are [chain, draw, image, angle] in m.

inline constexpr char kLogLikelihoodGroup[] = "log_likelihood",
                      kSampleStatsGroup[] = "sample_stats";

// outline [image, angle] and, of constant data, sigma [image].
void AddObservedOutlines(const StoredSamples& samples, NetcdfGroup* observed_data);
void AddSigma(const StoredSamples& samples, NetcdfGroup* constant_data);
// drape_outline: of the drape of each sample, without the error of an observation.
void AddSampleOutlines(const StoredSamples& samples, NetcdfGroup* posterior);

// posterior_predictive: `outline` with an independent error of sigma at each angle, which depends
// on the seed alone; log_likelihood: `outline`, ln of the normal density of each observed radius;
// sample_stats: lp = ln p(r | u) + ln p(u) and lp_approx = ln q(u) of the latent numbers u [chain,
// draw], whose difference is the log weight of a sample.
std::vector<NetcdfGroup> OutlineGroups(const StoredSamples& samples, int chains, uint64_t seed);

}  // namespace drape
