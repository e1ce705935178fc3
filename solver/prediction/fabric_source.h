// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/prediction.h"

namespace drape {

// A fabric as drapefit stores it.
struct FabricSource {
  std::string path;
  std::string kind;   // "table", "field"; of a posterior "hierarchy", "bdp"
  Material material;  // of a posterior the median
  std::optional<StoredPosterior> posterior;
};

// Reads what ReadMaterial does, or a folder of drape_fit: its posterior where the last fit has one,
// otherwise its material.json. mesh: the cloth of tables that vary over it; nullptr: such tables
// are refused. Throws InputError.
FabricSource ReadFabric(const std::string& path, const MaterialPolicy& policy = {},
                        const Mesh* mesh = nullptr);

// The materials of specimens 0, 1, 2, … of a fabric on a mesh, a function of (seed, specimen)
// alone:
//  - "table", "field": the same for all;
//  - "hierarchy": one table, the fabric's log factors sampled from their mean and covariance, those
//    of the specimen from their prior;
//  - "bdp": the fabric's 39 fitted means and deviations, and for each face and hinge a sample of
//  its
//    own, exp(mean + deviation·ε).
MaterialSource MakeSpecimens(const FabricSource& fabric, const Mesh& mesh, uint64_t seed);

// Independent samples of what a fit knows of a fabric, or assumed of it.
struct FabricSamples {
  std::vector<std::string> names;     // of the log factors (StoredPosterior::NameFor), [P]
  Eigen::MatrixXd log_factors;        // shape [P, S]
  std::vector<MaterialField> tables;  // of the fabric, without its specimens' factors, [S]
};

// count ≥ 1 samples, which depend on the seed alone. CHECKs kind hierarchy: the deviations of kind
// bdp are a scatter over the cloth, not an uncertainty.
FabricSamples SamplePosterior(const StoredPosterior& posterior, int count, uint64_t seed);
FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed);
// The fabric at log factors of the posterior, shape [P, S].
FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors);

// The tables of the fabric at the mean of the log factors, which is the median of every entry.
MaterialField MedianTables(const StoredPosterior& posterior);

}  // namespace drape
