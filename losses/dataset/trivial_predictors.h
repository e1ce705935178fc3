// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "losses/metrics/comparison.h"
#include "losses/metrics/distribution_metrics.h"

namespace drape {

// A capture of the data set as the camera sees it.
struct ObservedCapture {
  Capture capture;
  ObservedDrape drape;
};
// Reads the silhouettes. `hard_edged`: HardEdged first. Throws InputError.
std::vector<ObservedCapture> ObserveCaptures(const std::vector<Capture>& captures,
                                             const Camera& camera, bool hard_edged = false);

// One way to predict without a model, over all pairs of a prediction and a held-out capture.
struct PredictorRow {
  std::string name;
  int pairs = 0;
  DrapeDistance mean, median;                      // as they lie; of the grey image only the mse
  std::optional<DrapeDistance> aligned_mean = {};  // after the best rotation and flip
};

// What any model has to beat on a split, computed from the same split.
struct TrivialPredictors {
  // "same sample, same face" (the floor that repeated captures set, among the held out), "another
  // sample, same face", "another fabric" (where there are several), "circle of the mean area",
  // "grey mean image". A row without pairs is left out.
  std::vector<PredictorRow> rows;
  // The other samples' drapes of the fabric and face as draws of a distribution; none where a
  // held-out capture has fewer than two of them. Captures of one sample repeat each other, so that
  // intervals of few samples hold less than independent draws would (of DC with six: 71 % for 85).
  std::optional<DistributionScore> other_samples;
  // The circle of the mean area as a distribution that does not scatter; none where a held-out
  // capture has no other sample to learn the area from.
  std::optional<DistributionScore> circle;
};

// Each held-out capture is predicted from the captures to learn from that show its fabric and face
// and not its sample. So the same list on both sides leaves each sample out in turn. Of "another
// fabric" at most 2000 pairs count, evenly chosen. `aligned` off skips the costly part.
TrivialPredictors EvaluateTrivialPredictors(const std::vector<ObservedCapture>& train,
                                            const std::vector<ObservedCapture>& held_out,
                                            const Camera& camera, bool aligned = true);

}  // namespace drape
