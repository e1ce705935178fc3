// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "tools/cli/option_table.h"

namespace drape {

// Of all but `aligned`.
std::vector<Option> DatasetOptions(DatasetQuery& query);

}  // namespace drape
