// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"
#include "solver/fit/observed/experiment_file.h"
#include "solver/job/fit_data.h"
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
  std::string start_name = "of the caller";
  std::unique_ptr<Strips> strips;
  std::unique_ptr<MaterialField> ground_truth;
  std::shared_ptr<const FabricPrior> prior;  // of spec.prior, where it is given
  std::vector<std::string> notes;
  std::vector<ReadRecord::File> files;  // that were read
};

// The inputs of fits in memory. Throws InputError for a combination that cannot be fitted.
FitInput MakeFitInput(const FitSpec& spec, ObservedFabric fabric);
FitInput MakeFitInput(const FitSpec& spec, ExperimentFile experiments);
// Throws InputError for a file, a name or a combination that cannot be fitted.
FitInput ReadFitInput(const FitSpec& spec, const FitData& data);

}  // namespace drape
