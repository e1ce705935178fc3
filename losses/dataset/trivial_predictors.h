// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "physics/util/options/field.h"
#include "physics/util/run_control.h"

namespace drape {

// A capture of the data set and its observation by the camera.
struct ObservedCapture {
  Capture capture;
  ObservedDrape drape;
};
// Reads the silhouettes. Throws InputError as ObserveImage and ReadSilhouette do.
std::vector<ObservedCapture> ObserveCaptures(const std::vector<Capture>& captures,
                                             const Camera& camera);

// One method of predicting without a model, evaluated over all pairs of a prediction and a held-out
// capture.
struct PredictorRow {
  std::string name;
  int pairs = 0;
  DrapeDistance mean, median;  // without alignment; the grey image has an mse only
  std::optional<DrapeDistance> aligned_mean = {};  // after the best rotation and flip
};

// The baselines that a model has to beat on a split, computed from the same split.
struct TrivialPredictors {
  // "same sample, same face" (the lower bound set by repeated captures, among the held-out ones),
  // "another sample, same face", "another fabric" (if there are several), "circle of the mean
  // area", "grey mean image". A row without pairs is left out.
  std::vector<PredictorRow> rows;
  // The drapes of the other samples of the same fabric and face as an ensemble; std::nullopt where
  // a held-out capture has fewer than two of them. Captures of one sample repeat each other, so
  // that intervals from few samples cover less than independent samples would (for DC with six
  // samples: 71 % instead of 85 %).
  std::optional<DistributionScore> other_samples;
  // The circle of the mean area as a distribution without scatter; std::nullopt where a held-out
  // capture has no other sample from which to estimate the area.
  std::optional<DistributionScore> circle;
  // What the features of the other samples tell without a model of cloth: a normal distribution by
  // their mean and covariance, the latter halfway to its diagonal and wider by what their number n
  // leaves of the mean, (1 + 1/n). Of features alone; std::nullopt as other_samples. Fair scores
  // [Ferro 2014] of `other_samples` are those of the true distribution in the mean; n samples leave
  // the mean uncertain, which costs a normal distribution of known width √(4 + 2/n) − 2 of it, .08
  // for six.
  std::optional<DistributionScore> normal;
};

// Each held-out capture is predicted from the training captures that show its fabric and face but
// not its sample. The same list on both sides therefore leaves each sample out in turn. For
// "another fabric" at most 2000 evenly chosen pairs count. `aligned` = false skips the expensive
// part.
TrivialPredictors EvaluateTrivialPredictors(const std::vector<ObservedCapture>& train,
                                            const std::vector<ObservedCapture>& held_out,
                                            const Camera& camera, bool aligned = true);

// Which drapes of the public data set to use, and how they are split into training and held-out
// samples.
struct DatasetQuery {
  std::string folder;                                    // empty: no data set
  std::string fabric, samples, captures, face = "both";  // ParseIndexList, ClothFace
  int train = 6;           // samples of each fabric; 0: each is left out in turn
  int seed = 1;            // of the split
  std::string split;       // a stored split instead of a random one
  std::string save_split;  // file to store it in
  bool aligned = true;     // EvaluateTrivialPredictors
};

template <MutableOrConst<DatasetQuery> Query, class Visitor>
void VisitFields(Query& query, Visitor&& visit) {
  auto& [folder, fabric, samples, captures, face, train, seed, split, save_split, aligned] = query;
  visit(folder, Field{.key = "data",
                      .doc = "folder of the published data set: lists it and evaluates predictors "
                             "without a model",
                      .is_path = true});
  visit(fabric,
        Field{.key = "data_fabric", .doc = "fabrics of the data set, as in 1,3-5; none: all"});
  visit(samples, Field{.key = "samples", .doc = "samples of each fabric, as in 1,3-5; none: all"});
  visit(captures,
        Field{.key = "captures", .doc = "captures of each sample, as in 1,3-5; none: all"});
  visit(face, Field{.key = "face",
                    .doc = "face of the cloth that lies up: captures 1 and 2 show it up, 3 and 4 "
                           "down",
                    .choices = {"up", "down", "both"}});
  visit(train, Field{.key = "train",
                     .doc = "number of training samples of each fabric, the others are held out; "
                            "0: each sample is held out in turn",
                     .range = {.least = 0, .most = 9999}});
  visit(seed, Field{.key = "split_seed",
                    .doc = "random seed of the split alone, so that it stays the same in other "
                           "programs and runs",
                    .range = {.least = 0}});
  visit(split, Field{.key = "split",
                     .doc = "file of a stored split, used instead of a random one",
                     .is_path = true});
  visit(save_split,
        Field{.key = "save_split", .doc = "file to store the split in", .is_path = true});
  visit(aligned, Field{.key = "aligned",
                       .doc = "with --data: also evaluate after the best rotation and reflection, "
                              "which takes longer"});
}

// A data set: what the loader found, the split, and what it gives without a model.
struct DatasetReport {
  size_t training_images = 0;
  std::vector<Capture> captures;  // selected and usable
  std::vector<FileNote> skipped, notes;
  Split split;  // both sides hold all captures when each sample is held out in turn
  bool in_turn = false;
  std::vector<ObservedCapture> seen_train, seen_held_out;
  TrivialPredictors predictors;
};

// Also stores the split where `query` says so. A cancelled report has neither observed captures nor
// predictors. Throws InputError.
DatasetReport EvaluateDataset(const DatasetQuery& query, const Camera& camera,
                              const RunControl& control);

}  // namespace drape
