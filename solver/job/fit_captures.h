// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "solver/job/fit_spec.h"

namespace drape {

// Which drapes of the public data set are fitted, all of one fabric.
struct FitSelection {
  std::string folder;             // of the data set (ReadDataset); empty: no data set
  int fabric = 0;                 // 0: not given
  std::string samples, captures;  // ParseIndexList; empty: all
  std::string face = "both";      // or "up", "down"
};

// Reads the list, opens the files (KeepUsable) and passes the captures to UseCaptures. What was
// left out goes to data->log_lines; what of the selection, also to data->notes. Throws InputError.
void SelectCaptures(const FitSelection& selection, FitData* data);

// Takes usable captures of one fabric as the data. With source kMeshes those without a mesh of
// their own are left out, with a note. A density of 0 becomes that of PublishedDensity, an empty
// list of specimens that of the samples. Throws InputError if no capture is left or there is no
// density.
void UseCaptures(const std::vector<Capture>& captures, FitData* data);

}  // namespace drape
