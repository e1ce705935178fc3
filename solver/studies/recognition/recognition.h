// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/posterior/space/material_space.h"
#include "solver/prediction/generative/distribution_fit.h"
#include "solver/studies/recognition/fit_cells.h"

namespace drape {

// Which fabric is a sample of? Each sample is left out with all its captures and compared with the
// fabrics as the other samples show them [METHODS, P62].

// What samples and fabrics are compared by.
struct RecognitionWays {
  bool posterior = true;    // of a fit of each sample alone
  bool predictions = true;  // learned distributions of specimens
  bool features = true;     // of images, without a model of cloth
};

struct RecognitionJob {
  RecognitionWays ways = {};
  FitCellJob fits;                           // of each sample alone, for the posterior
  std::vector<FitCell> cells = {};           // CellsBySample
  std::vector<ObservedCapture> images = {};  // of all captures of the cells
  SpaceBy by = SpaceBy::kDrape;
  // The pool that predictions learn from. Its law, contact and backend are those of the fits; its
  // mesh may be another.
  PoolOptions pool = {};
  std::string pool_file = {};  // ReadOrSimulatePool
  DistributionFitOptions distribution = {};
};

// Compares by each way of the job. The way posterior makes the fits that are missing and takes the
// samples that have one. Returns
//   {"fabrics": numbers, "failures": [{"name", "reason"}],
//    "samples": [{"name", "fabric": index, "by_way": {way: log probabilities of all fabrics}}]},
// log probabilities up to a constant; those of "predictions" up to a factor too; "density" is of a
// fabric weighed to 3 % and looks at no drape. Returns nothing when cancelled. Throws InputError.
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

}  // namespace drape
