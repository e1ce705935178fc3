// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"

namespace drape {

// Samples to learn from and samples to predict: all captures of a sample are on one side, because
// captures of one sample repeat each other.
struct Split {
  uint64_t seed = 0;
  std::vector<Capture> train, held_out;  // in the order of the data set
};

// Draws `train_samples` samples of each fabric of `captures` by the seed, the same on each
// platform. Throws InputError unless each fabric has more samples than that; train_samples ≥ 1.
Split SplitBySample(const std::vector<Capture>& captures, int train_samples, uint64_t seed);

// JSON: the numbers of the captures on both sides, without paths; atomic. Reading looks them up in
// `dataset`, so a split can be used on another machine; InputError for a file that is no split, a
// capture that the data set lacks, or a sample on both sides.
void WriteSplit(const std::string& path, const Split& split);
Split ReadSplit(const std::string& path, const Dataset& dataset);

}  // namespace drape
