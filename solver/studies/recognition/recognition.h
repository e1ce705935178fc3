// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/posterior/space/fabric_belief.h"
#include "solver/prediction/prediction.h"
#include "solver/studies/cells/share.h"
#include "solver/studies/recognition/fabric_fits.h"
#include "solver/studies/recognition/recognition_scores.h"

namespace drape {

// Which fabric is a sample of? Each sample is left out with all its captures and compared with the
// fabrics as the other samples show them [METHODS, P62].
struct RecognitionJob {
  FitCellJob fits;                           // of each sample alone
  std::vector<FitCell> cells = {};           // CellsBySample
  std::vector<ObservedCapture> images = {};  // of all captures of the cells
  SpaceBy by = SpaceBy::kDrape;
  // Drapes of each fabric that are predicted for the synthetic likelihood; 0: without it.
  int draws = 64;
  bool calibrate = false;             // each prediction first (CalibrateBend)
  PredictionOptions prediction = {};  // its specimens, faces, seed and camera are not used
  // What must be the same for predictions to be taken over from an earlier run: key → value.
  std::map<std::string, std::string> prediction_settings = {};
  std::optional<Share> share = {};  // of the cells; none: this process has the folder alone
};

// Names of ways.
inline constexpr char kByPosterior[] = "posterior (A)";
inline constexpr char kByDrapes[] = "predicted drapes (B)";
inline constexpr char kByFeatures[] = "image features";
inline constexpr char kByDensity[] = "density alone, weighed to 3 %";

struct Recognition {
  bool cancelled = false;
  std::vector<int> fabrics = {};  // numbers of those with two samples or more
  std::vector<RecognisedSample> samples = {};
  std::vector<RecognitionScore> scores = {};
  std::vector<FitFailure> failures = {};  // cells, and predictions, that are missing
};

// Fits what is missing, then predicts what is missing, in fits.out/prediction, and scores: A by
// posteriors of samples, B by predicted drapes, features of images alone, and products of them with
// nested weights. Throws InputError.
Recognition Recognise(const RecognitionJob& job, const RunControl& control);

// The names of all cells in their order: the fits, then the predictions that need the fits of all
// samples, "prediction/fabric_3" and "prediction/fabric_3_without_2".
std::vector<std::string> ListRecognitionCells(const RecognitionJob& job);

struct RecognitionShare {
  bool cancelled = false;
  std::size_t cells = 0, done = 0;  // of the share; done: also those that failed
  std::size_t waiting = 0;          // predictions of the share that need fits of other shares
  std::vector<FitFailure> failures = {};
};

// Runs the cells of job.share: its fits, and its predictions once the fits of all shares have
// ended. Throws InputError.
RecognitionShare RunRecognitionShare(const RecognitionJob& job, const RunControl& control);

std::string RecognitionReport(const Recognition& recognition);

}  // namespace drape
