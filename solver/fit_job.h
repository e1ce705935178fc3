// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "solver/staged_fit.h"

namespace drape {

// Where the support's centre is in an image.
enum class CentreMode {
  kNominal,  // the image's centre
  kOutline   // where the outline has no first harmonic: the published images are off by up to 10 px
};
// "nominal" or "outline". Throws InputError for any other.
CentreMode ParseCentreMode(const std::string& text);

// A fit from files to files: what drape_fit does.
struct FitJob {
  std::vector<std::string> images;  // JPEG or PNG silhouettes of one fabric, fitted jointly
  std::string model = "homo";       // one table for the whole cloth
  std::string mesh = "disc:1200";   // ParseMeshSpec
  std::string coarse_mesh = "disc:300";  // of the seed grid
  std::string material;             // start tables, "FILE" or "FILE#name"
  std::string truth;                // optional: tables that the images were made with, compared
  std::string law = "smooth";
  std::string camera = "orthographic";
  std::string centre = "outline";
  std::string backend = "cpu";
  std::string out;                  // folder, made when missing
  bool resume = false;              // go on from the checkpoint in `out`
  int threads = 1;
  int evaluation_steps = 300;       // of h = fit.settle_h: how far the fitted drape still moves
  StagedFitOptions fit;             // its `cancel` is set by RunFitJob
};

struct FitJobCallbacks {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(const StageProgress&)> progress;
};

struct FitJobResult {
  bool cancelled = false;  // the files hold the best so far
  bool converged = false;  // false: the fit ended by failure, no fit was written
  std::string table;       // for a person: one line an image, then the material
};

// Reads and checks all input before it computes; writes to job.out: summary.json, material.json, for
// each image fit_<name>.png, drape_<name>.obj and start_<name>.json, checkpoint.json while it runs,
// and fit.log. Throws InputError; then what lay in the folder is as it was.
FitJobResult RunFitJob(const FitJob& job, const FitJobCallbacks& callbacks);

// Image files of a comma-separated list of files, folders (all .jpg, .jpeg, .png in it) and glob
// patterns, sorted within each. Throws InputError for one that matches nothing.
std::vector<std::string> ExpandImages(const std::string& text);

}  // namespace drape
