// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "solver/fit/observation_input.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_fit.h"

namespace drape {

// A fit from files to files: what drape_fit does.
struct FitJob {
  std::vector<std::string> images;  // JPEG or PNG silhouettes of one fabric, fitted jointly
  std::vector<Capture> captures;    // of the public data set in place of images (UseCaptures)
  ObservationSource targets = ObservationSource::kSilhouettes;  // of the captures
  std::vector<std::string> tests;     // mechanical tests of the same fabric (ReadLabMeasurement),
                                      // fitted alone or jointly with the images
  std::string model = "homogeneous";  // one table for the whole cloth; "heterogeneous": then one
                                      // for each element (FitFields); "bayes": then how sure it is,
                                      // "bdp": how elements scatter (FitDrapePosterior)
  std::string mesh = "disc:1200";     // ParseMeshSpec
  std::string coarse_mesh = "disc:300";  // of the seed grid
  std::string material;                  // start tables, "FILE" or "FILE#name"
  std::string truth;     // optional: tables that the images were made with, compared
  double density = 0.0;  // of the fabric [kg/m²]; 0: that of the start tables
  std::string law = "smooth";
  std::string camera = "orthographic";
  std::string centre = "outline";
  std::string backend = "auto";    // MakeBackend
  std::string out;                 // existing folder of the results
  std::string checkpoint;          // file of the fit of one table; removed at the end, unless
  bool keep_checkpoint = false;    // it stays, and another model of the same job can go on from it
  std::string log;                 // text file, one line a branch
  std::vector<std::string> notes;  // on the input, for summary and log
  std::vector<std::string> log_lines;  // on the input, for the log alone
  bool resume = false;                 // go on from the checkpoint
  int threads = 1;
  double floor = 0.0;  // start entries under this share of their column's largest are
                       // raised to it: a log scale cannot move what is not positive.
                       // 0: tables as they are, negative entries as the law takes them
  TableForm tables = TableForm::kGiven;  // of the start, after that; a simpler one stays so with
                                         // fit.parameters of 2, a linear one with 7 too
  std::map<std::string, std::string> versions;  // for the summary
  int evaluation_steps = 300;  // of h = fit.settle_h: how far the fitted drape still moves
  StagedFitOptions fit;
  FieldOptions fields;         // of model heter
  PosteriorOptions posterior;  // of models bayes and bdp, which set its kind

  std::size_t num_targets() const { return images.size() + captures.size(); }
};

// Work done, for a progress line.
struct FitProgress {
  std::string stage;
  double fraction = 0.0;     // of all work, estimated
  double profile_rms = 0.0;  // best so far [px]; 0 when not known
};

struct FitJobCallbacks {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(const FitProgress&)> progress;
  std::function<void(const std::string& line)> log = {};
};

struct FitJobResult {
  bool cancelled = false;  // the files hold the best so far
  bool fitted = false;     // false: nothing could be fitted, summary.json says why
  std::string table;       // for a person: one line an image, one a point of a test, the material
};

// Tests are first fitted alone from the start tables. With images, the staged fit follows: it
// starts from the tables of that fit, on which its prior is centred, and each branch has the tests'
// residuals beside the outlines'; the seed grid leaves alone what tests have measured (bend after a
// cantilever, stretch after a tensile test).
// Reads and checks all input before it computes; writes to job.out: summary.json, material.json,
// for each image fit_<name>.png, drape_<name>.obj and start_<name>.json; model heter also
// material_homogeneous.json and maps of the fields (WriteFields), bayes and bdp
// material_homogeneous.json, base.json and posterior.json. Throws InputError.
FitJobResult RunFitJob(const FitJob& job, const FitJobCallbacks& callbacks);

// JSON files of a list like that of ExpandImages. Throws InputError for one that matches nothing.
std::vector<std::string> ExpandTests(const std::string& text);

// Image files of a comma-separated list of files, folders (all .jpg, .jpeg, .png in it) and glob
// patterns, sorted within each. Throws InputError for one that matches nothing.
std::vector<std::string> ExpandImages(const std::string& text);

}  // namespace drape
