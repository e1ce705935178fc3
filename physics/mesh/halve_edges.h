// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/mesh/mesh.h"

namespace drape {

// The cloth on a mesh of half the edges: each face becomes four by the midpoints of its edges,
// which follow the vertices of `mesh`. A curved boundary stays the polygon that it was.
Mesh HalveEdges(const Mesh& mesh);

}  // namespace drape
