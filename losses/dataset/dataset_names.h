// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "losses/dataset/dataset.h"

namespace drape {

// Internal to losses/: what the file names of the public data set say. Each takes a name without
// its extension and gives nothing when it does not look like one.

struct CaptureName {
  std::optional<int> fabric;
  int sample = 0, capture = 0;
};
std::optional<CaptureName> ParseCaptureName(const std::string& stem);

// All but the fabric and the path.
std::optional<TrainingImage> ParseTrainingName(const std::string& stem);

// "Fabric 7" → 7.
std::optional<int> ParseFabricFolder(const std::string& name);

// Lower case, blanks and hyphens as underscores.
std::string PlainName(const std::string& name);

}  // namespace drape
