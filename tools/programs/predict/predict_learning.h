// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/predict/predict_result.h"

namespace drape {

// The learning of drape_predict.

std::vector<Option> LearningOptionRows(PredictToolOptions& options);

// Throws InputError for images that are not to be learned from, or of other discs than a pool's.
void CheckTrainingImages(const PredictToolOptions& options, const DrapeDiscs& discs);

// Sets run->learned by the drapes seen, and run->specimen where they are of one sample; nothing
// when it is cancelled. Throws InputError.
void Learn(const PredictToolOptions& options, Backend& backend,
           const std::vector<ObservedCapture>& seen, const RunControl& control, PredictionRun* run);

}  // namespace drape
