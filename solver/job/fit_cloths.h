// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/mesh/disc.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_spec.h"

namespace drape {

// The meshes of a fit before spec.mesh: spec.search_mesh and, where both are built-in discs, those
// between them, each with at most twice the vertices of the one before. None where search_mesh
// is not clearly coarser than mesh, or is another cloth, of which there is a note. Throws
// InputError for a malformed one.
std::vector<std::string> SearchMeshes(const FitSpec& spec, const DrapeDiscs& discs,
                                      std::vector<std::string>* notes);

// Makes the cloths of images, of spec.mesh, the search meshes and spec.coarse_mesh, with their
// backends, and points the problem to them. shared: FitData::shared. Throws InputError for a mesh
// that does not suit the discs.
void MakeCloths(const FitSpec& spec, SharedBackends::Member* shared, FitInput* input);

}  // namespace drape
