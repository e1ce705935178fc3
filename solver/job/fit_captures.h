// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "solver/job/fit_job.h"

namespace drape {

// Which drapes of the public data set a fit learns from, all of one fabric.
struct FitSelection {
  std::string folder;             // of the data set (ReadDataset); empty: no data set
  int fabric = 0;                 // 0: none was given
  std::string samples, captures;  // ParseIndexList; empty: all
  std::string face = "both";      // or "up", "down"
};

// Reads the list, opens the files (KeepUsable) and gives the captures to the job (UseCaptures).
// What was left out goes to job->log_lines, of the selection also to job->notes. Throws InputError.
void SelectCaptures(const FitSelection& selection, FitJob* job);

// Usable captures of one fabric become the job's. With targets kMeshes those without a mesh of
// their own are left out, with a note. A density that is 0 becomes that of PublishedDensity, an
// empty list of specimens that of the samples. Throws InputError when none is left, or there is no
// density.
void UseCaptures(const std::vector<Capture>& captures, FitJob* job);

}  // namespace drape
