// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "physics/util/atomic_file.h"
#include "solver/job/fit_spec.h"

namespace drape {

// The inputs of a fit, read and checked, with the backends that the problem points to.
struct FitInput {
  struct Cloth {
    std::shared_ptr<const ClothModel> model;
    std::unique_ptr<Backend> backend;
  };
  // Without clothes where there are laboratory measurements alone. search: of SearchMeshes.
  Cloth fine, coarse;
  std::vector<Cloth> search;
  std::string device;  // of MakeBackend; empty: laboratory measurements alone, without a backend
  FitProblem problem;  // without strips
  DrapeDiscs discs;
  bool density_is_given = false;  // else it is that of the start tables
  std::unique_ptr<Strips> strips;
  std::unique_ptr<MaterialField> ground_truth;
  std::shared_ptr<const FabricPrior> prior;  // of spec.prior, where it is given
  std::vector<std::string> notes;
  std::vector<ReadRecord::File> files;  // that were read
};

// The meshes of a fit before spec.mesh: spec.search_mesh and, where both are built-in discs, those
// between them, each with at most twice the vertices of the one before. None where search_mesh
// is not clearly coarser than mesh, or is another cloth, of which there is a note. Throws
// InputError for a malformed one.
std::vector<std::string> SearchMeshes(const FitSpec& spec, const DrapeDiscs& discs,
                                      std::vector<std::string>* notes);

// The input of a fit in memory. Throws InputError for a combination that cannot be fitted.
FitInput MakeFitInput(const FitSpec& spec, ObservedFabric fabric);
// Throws InputError for a file, a name or a combination that cannot be fitted.
FitInput ReadFitInput(const FitSpec& spec, const FitData& data);

// What must be equal for a checkpoint to be continued: all that determines the fit of one table,
// which is the same for all models.
std::string CheckpointKey(const FitSpec& spec, const FitData& data, const FitInput& input);

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
