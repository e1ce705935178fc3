// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// Checks that a mesh can be a drape of those discs, whose support is about the z axis: its width,
// the axis that is up, and its surface, which cloth keeps. Where the cloth on the support is
// inclined, as in a scan, turns the mesh level about the middle of that cloth. Returns a sentence
// for each thing that a user should know. Throws InputError (prefix `where`) for a mesh in another
// unit, with another axis up, or with more surface than the cloth has.
std::vector<std::string> CheckSurface(ObjSurface* surface, const DrapeDiscs& discs,
                                      const std::string& where);

}  // namespace drape
