// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "physics/material/material_io.h"
#include "solver/fit/observed/observation.h"
#include "solver/forward/batching_backend.h"

namespace drape {

// What is fitted: drapes of one fabric, laboratory measurements of it, or both.
struct FitData {
  std::vector<std::string> images;  // JPEG or PNG silhouettes, fitted jointly
  std::vector<Capture> captures;    // of the public data set in place of images (UseCaptures)
  ObservationSource source = ObservationSource::kSilhouettes;  // of the captures
  std::vector<int> specimens;  // FitProblem::specimens; one number for each image or capture
  std::vector<std::string> lab_measurements;  // files (ReadLabMeasurements)
  std::string experiment;                     // a file (ReadExperiments) in place of images
  std::string material = kBuiltInName;        // start tables (ReadMaterial)
  double density = 0.0;                       // of the fabric [kg/m²]; 0: that of `material`
  std::string ground_truth;        // tables that the images were made with, compared; empty: none
  std::vector<std::string> notes;  // on the data, for summary and log
  std::vector<std::string> log_lines;  // on the data, for the log alone
  // Shares backends with fits of the same spec that run side by side; null: has its own.
  SharedBackends::Member* shared = nullptr;

  std::size_t num_observations() const { return images.size() + captures.size(); }
};

// JSON files of a list like that of ExpandImages. Throws InputError for one that matches nothing.
std::vector<std::string> ExpandLabMeasurements(const std::string& text);

// Image files of a comma-separated list of files, folders (all .jpg, .jpeg, .png in it) and glob
// patterns, sorted within each. Throws InputError for one that matches nothing.
std::vector<std::string> ExpandImages(const std::string& text);

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
