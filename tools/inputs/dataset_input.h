// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/cli/option_table.h"

namespace drape {

// Which drapes of the public data set a user wants, and what is learnt from and held out of them.
struct DatasetInput {
  std::string folder;                                    // empty: no data set
  std::string fabric, samples, captures, face = "both";  // ParseIndexList, ClothFace
  int train = 6;                                         // samples a fabric; 0: each left out
  int seed = 1;                                          // of the split
  std::string split;                                     // a stored split in place of a drawn one
  std::string save_split;                                // file to store it in
  bool hard_edged = false;                               // HardEdged
  bool aligned = true;                                   // EvaluateTrivialPredictors
};

// Of all but `aligned`. seed_key: what the option of the split's seed is called.
std::vector<Option> DatasetOptions(DatasetInput& input, const std::string& seed_key);

}  // namespace drape
