// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "physics/cloth/cloth_model.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/prediction.h"

namespace drape {

// The materials of specimens 0, 1, 2, … of a fitted fabric. From a folder of drape_fit:
//  - model homogeneous, heterogeneous: material.json, the same for all specimens;
//  - model bayes, bdp: samples of the posterior (MakePosteriorSource). summary.json says which, or,
//    if it is missing, whether there is a posterior.json.
// From a file: a table or a field (ReadMaterialFor), the same for all. kind, if not null: "table",
// "field", "hierarchy" or "bdp". A function of (seed, specimen) alone, which needs neither the
// files nor the model later. Throws InputError: nothing to read, a bad file, a negative stiffness
// under a law that rejects it.
MaterialSource ReadMaterialSource(const std::string& folder_or_file, const ClothModel& model,
                                  uint64_t seed, std::string* kind = nullptr);

// Whether the last fit in a folder of drape_fit has a posterior. Throws InputError for a summary
// that cannot be read.
bool HasPosterior(const std::string& folder);

// New specimens of a posterior:
//  - kHierarchy: one table, the fabric's log factors sampled from their mean and covariance, those
//    of the specimen from their prior;
//  - kElements: the fabric's 39 fitted means and deviations, and for each face and hinge a sample
//  of
//    its own, exp(mean + deviation·ε).
MaterialSource MakePosteriorSource(const StoredPosterior& posterior, const Mesh& mesh,
                                   uint64_t seed);

}  // namespace drape
