// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "losses/dataset/dataset.h"

namespace drape {

// Internal to losses/: parsers of the file names of the public data set. Each takes a name without
// its extension and returns std::nullopt when the name does not have the form.

struct CaptureName {
  std::optional<int> fabric;
  int sample = 0, capture = 0;
};
std::optional<CaptureName> ParseCaptureName(const std::string& stem);

// Fills in all but the fabric and the path.
std::optional<TrainingImage> ParseTrainingName(const std::string& stem);

// "Fabric 7" → 7.
std::optional<int> ParseFabricFolder(const std::string& name);

// The name in lower case, with blanks and hyphens as underscores.
std::string PlainName(const std::string& name);

}  // namespace drape
