// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

// What one of several threads adds up: all that the elements add at the vertices of its own part of
// the mesh. Elements across a border of parts are computed once for each part. Each sum has the
// order that it has without parts, and the same bits.
struct AssemblyPart {
  struct Element {
    int index;
    unsigned corners;  // bit a: whether corner a is of this part
  };
  std::vector<Element> faces, hinges;  // ascending
};

// Parts with about as many vertices each, ≥ 1.
std::vector<AssemblyPart> SplitAssembly(const Mesh& mesh, int parts);

}  // namespace drape
