// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/inputs/samples.h"

namespace drape {

// A picture of a table of samples, measured.
struct MeasuredSample {
  SampleRow row;
  std::string error = {};       // why it could not be measured; empty: it was
  double coefficient = 0.0;     // drape coefficient
  double coefficient_sd = 0.0;  // standard deviation of its measurement
  int nodes = 0;
  std::string notes = {};
};

// Sums up pictures by fabric, sample (where a fabric has several), specimen and face. The value of
// a specimen is the mean of its faces, each the mean of its pictures; that of a sample the mean of
// its specimens; that of a fabric the mean of its samples. So repeats add no degrees of freedom
// [METHODS, P79]. Nodes are the most frequent numbers.
// {"pictures": [{columns, "dc_percent", "dc_sd_percent", "nodes", "notes", "error"}], "groups":
// [{"fabric", "sample", "specimen", "face", "pictures", "dc_percent", "dc_sd_percent", "n", "of",
// "dc_low_percent", "dc_high_percent", "nodes"}], "differences": [{"a", "b", "dc_points", "low",
// "high", "text"}], "notes"}. "": all. What is unknown is null. "of": what n counts.
nlohmann::ordered_json SamplesJson(const std::vector<MeasuredSample>& pictures);

// The groups, differences and notes of such an object, for a terminal.
std::string SamplesText(const nlohmann::ordered_json& samples);

// Objects of the same keys as lines below a line of these keys.
std::string CsvOfObjects(const nlohmann::ordered_json& objects);

}  // namespace drape
