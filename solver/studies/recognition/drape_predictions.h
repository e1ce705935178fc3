// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "physics/util/stored/stored_json.h"
#include "solver/studies/recognition/fitted_samples.h"

namespace drape {

// Drapes that are predicted of the fabrics of a recognition, as features, one file each in
// fits.out/prediction. Every prediction needs the fits of all samples: their common directions and
// their mean.

// Version 1 did not say which fits it is of.
inline constexpr StoredFormat kRecognitionPredictionFormat = {"drapefit-recognition-prediction", 2};

// A prediction: of a fabric, or of it without one of its samples.
struct PredictionCell {
  int fabric = 0;    // from 0
  int without = -1;  // of the fitted samples; −1: all count
  std::string name;  // of the file
};

std::vector<PredictionCell> ListPredictions(const FittedSamples& samples);
// Their names in the same order where each cell has a posterior.
std::vector<std::string> ListPredictionNames(const std::vector<FitCell>& cells);

// Whether it is there, with the same fits behind it.
bool HasPrediction(const RecognitionJob& job, const FittedSamples& samples,
                   const PredictionCell& cell);

// Throws InputError where fits.out has predictions of other settings.
void CheckPredictionSettings(const RecognitionJob& job);

// Predicts those of `cells` that are missing. False when it was cancelled. Throws InputError.
bool RunPredictions(const RecognitionJob& job, const FittedSamples& samples,
                    const std::vector<PredictionCell>& cells, const RunControl& control);

// Moments of each face, up and down.
struct PredictedFeatures {
  std::array<NormalDistribution, 2> face;
};

// Throws InputError where the file is missing, damaged or of too few drapes at rest.
PredictedFeatures ReadPrediction(const RecognitionJob& job, const PredictionCell& cell);

}  // namespace drape
