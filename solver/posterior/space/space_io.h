// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/posterior/space/material_space.h"

namespace drape {

// A space of materials as files.

// Writes space.json,
//   {"format": "drapefit-space", "version": 1, "by", "kind", "names" [P], "base", "fabrics",
//    "wasserstein", "hellinger", "log_bending_lengths" (ln m; weft, warp), "population", "prior",
//    …},
// and distances.csv, one line per pair of fabrics and level, to `folder`, each atomically.
// provenance: where the results are from, for the JSON. Throws InputError.
void WriteMaterialSpace(const std::string& folder, const MaterialSpace& space,
                        const nlohmann::ordered_json& provenance);

// The space for a person: distances to the nearest fabrics, the population, judged materials.
std::string MaterialSpaceText(const MaterialSpace& space);

// What a new fit takes from space.json: the prior of a fabric's log factors.
struct SpacePrior {
  SpaceFrame frame;
  NormalDistribution theta;
};
// Throws InputError naming the file and the key: another format, a space without a population (of
// kind bdp, too), an unknown key, a covariance that is not positive definite or has a standard
// deviation outside 1e-9 … 1e9.
SpacePrior ReadSpacePrior(const std::string& path);

}  // namespace drape
