// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/predict/predict_result.h"

namespace drape {

// The distribution of each feature, the samples that did not come to rest, and the scores beside
// those of the trivial predictors.
std::string PredictionText(const PredictionRun& run);

// Throws InputError when the file cannot be written.
void WritePredictionSummary(const std::string& path, const PredictToolOptions& options,
                            const PredictionRun& run);

// Of the drapes that were seen, a group for each specimen. Throws InputError when the file cannot
// be written.
void WritePredictedOutlines(const std::string& path, const PredictionRun& run);

}  // namespace drape
