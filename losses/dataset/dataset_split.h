// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"

namespace drape {

// "1,3-5" → {1, 3, 4, 5}: parses whole numbers from 1 to 9999 and ranges of them into an ascending
// list without repetition. An empty text is an empty list. Throws InputError (prefix `where`) that
// names the wrong part.
std::vector<int> ParseIndexList(const std::string& text, const std::string& where);

// The inverse, for messages and reports: {1, 3, 4, 5} → "1,3-5". `numbers` must ascend.
std::string IndexListText(const std::vector<int>& numbers);

// Training samples and held-out samples. All captures of a sample are on one side, because captures
// of one sample repeat each other.
struct Split {
  uint64_t seed = 0;
  std::vector<Capture> train, held_out;  // in the order of the data set
};

// Selects `train_samples` samples of each fabric of `captures` at random, with the same result for
// the same seed on every platform. Throws InputError unless each fabric has more samples than that.
// train_samples ≥ 1.
Split SplitBySample(const std::vector<Capture>& captures, int train_samples, uint64_t seed);

// Write and read the split as JSON: the numbers of the captures on both sides, without paths.
// Writing is atomic. Reading looks the captures up in `dataset`, so that a split can be used on
// another machine. Throws InputError for a file that is not a split, a capture that the data set
// lacks, and a sample on both sides.
void WriteSplit(const std::string& path, const Split& split);
Split ReadSplit(const std::string& path, const Dataset& dataset);

}  // namespace drape
