// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/dataset_evaluation.h"
#include "tools/cli/option_table.h"

namespace drape {

// Of all but `aligned`. seed_key: what the option of the split's seed is called.
std::vector<Option> DatasetOptions(DatasetQuery& query, const std::string& seed_key);

}  // namespace drape
