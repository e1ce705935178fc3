// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_spec.h"
#include "solver/posterior/space/material_space.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/studies/runner/study.h"

namespace drape {

// Many posteriors of the public data set, each in a folder of its own. A fit that fails is named
// and does not end the study.

struct FitCell {
  std::string name;               // "fabric_3", "fabric_3/sample_2": its folder below the study's
  std::vector<Capture> captures;  // of one fabric
};
// One cell for each fabric, or for each sample. The captures are in the order of the data set.
std::vector<FitCell> MakeFitCells(const std::vector<Capture>& captures, bool by_sample);

struct FitCellJob {
  FitSpec fit;           // of one thread each; its model has a posterior
  std::string material;  // start tables
  std::function<nlohmann::ordered_json()> provenance = {};  // FitFiles::provenance of each fit
  nlohmann::json settings = {};                             // Study::settings
  StudyOptions study = {};  // its threads: fits side by side; its folder has those of the fits
};

struct FitFailure {
  std::string name, reason;
};

struct FitCellRun {
  StudyResult study;
  std::vector<std::string> done = {};  // names of cells with a posterior, in their order
  std::vector<FitFailure> failures = {};
};

// Fits the missing cells, each from its checkpoint if it has one. A fit remembers why it failed, as
// for an image without a drape; a refusal of the system, such as a full disk, ends the study and is
// not remembered. Throws InputError and IoError.
FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control);

// Which fabric is a sample of? Each sample is left out with all its captures and compared with the
// fabrics as the other samples show them [METHODS, P62].

struct RecognitionJob {
  // What samples and fabrics are compared by: "posterior" of a fit of each sample alone,
  // "predictions" of learned distributions of specimens, "features" of images, without a model of
  // cloth.
  std::set<std::string> ways;
  FitCellJob fits;                           // of each sample alone, for the posterior
  std::vector<FitCell> cells = {};           // by sample
  std::vector<ObservedCapture> images = {};  // of all captures of the cells
  SpaceBy by = SpaceBy::kDrape;
  // The pool that predictions learn from, and how. Its law, contact and backend are those of the
  // fits; its mesh may be another. Its further rounds are not used.
  LearningOptions learning = {};
};

// Finds what is seen of each sample by each way of the job. The way posterior makes the fits that
// are missing and takes the samples that have one. Returns
//   {"fabrics": numbers, "failures": [{"name", "reason"}], "scales": {way: numbers},
//    "samples": [{"name", "fabric": index, "seen": {way: {"mean", "covariance"}}, "density",
//                 "predictions": log probabilities of all fabrics}]}
// for scripts/space.py, which compares the normal distributions "seen" of the ways posterior
// and features; their samples scatter by about "scales". Log probabilities are up to a factor and a
// constant. Returns nothing when cancelled. Throws InputError.
std::optional<nlohmann::json> Recognise(const RecognitionJob& job, const RunControl& control);

// A sample that is compared with fabrics.
struct ListedSample {
  std::string name;  // of its cell: "fabric_3/sample_2"
  int fabric = 0;    // index in SampleList::fabrics
  std::vector<const ObservedCapture*> images = {};
};

struct SampleList {
  std::vector<int> fabrics;  // numbers in the data set
  std::vector<ListedSample> samples;

  int num_fabrics() const { return static_cast<int>(fabrics.size()); }
};

// The cells of these names, by fabric. A fabric with one sample is left out, since no other sample
// shows it. The list points into `images`. Throws InputError for fewer than two fabrics.
SampleList ListSamples(const std::vector<FitCell>& cells, const std::vector<std::string>& names,
                       const std::vector<ObservedCapture>& images);

// The drapes of one sample.
struct DrapesOfSample {
  int fabric = 0;  // from 0
  std::vector<TrainingDrape> drapes = {};
};

// Compares the drapes of each sample with predictions of the fabrics: distributions of specimens
// that are learned from all samples of a fabric, and from all but this one of its own. Returns
// minus the energy score of the drapes under each fabric: the mean over the captures of a face,
// which repeat each other, summed over the faces; shape [samples][fabrics]. These are log
// probabilities up to a constant factor (loss-likelihood [Bissiri 2016]) and a constant. Of each
// fabric two samples or more (CHECK). Of `options`, resamples and cross_validate are not used.
// Empty when cancelled. Throws InputError (prefix "pool") where the pool has too few drapes near a
// fabric.
std::vector<Eigen::VectorXd> CompareByPredictions(const DrapePool& pool,
                                                  const std::vector<DrapesOfSample>& samples,
                                                  int fabrics,
                                                  const DistributionFitOptions& options,
                                                  const RunControl& control);

}  // namespace drape
