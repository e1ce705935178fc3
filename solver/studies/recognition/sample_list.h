// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "solver/studies/recognition/fabric_fits.h"

namespace drape {

// A sample that is compared with fabrics.
struct ListedSample {
  std::string name;  // of its cell: "fabric_3/sample_2"
  int fabric = 0;    // from 0 among those of the list
  std::vector<const ObservedCapture*> images = {};
};

struct SampleList {
  std::vector<int> fabrics;  // numbers in the data set
  std::vector<ListedSample> samples;

  int num_fabrics() const { return static_cast<int>(fabrics.size()); }
};

// The cells (CellsBySample) of these names, by fabric; those of a fabric with one sample are left
// out, since there is no other to know the fabric by. The list points into `images`. Throws
// InputError where fewer than two fabrics are left.
SampleList ListSamples(const std::vector<FitCell>& cells, const std::vector<std::string>& names,
                       const std::vector<ObservedCapture>& images);

}  // namespace drape
