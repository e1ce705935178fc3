// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/mesh/mesh.h"

namespace drape {

// The mesh with needles: edges of the free cloth are shortened to `ratio` times their length, both
// ends drawn to the middle, 0 < ratio ≤ 1, so that the two triangles beside each have sides of
// about 1 : ratio. Of edges that share no neighbour, as many as there are, where both ends lie
// beyond `support_radius` and off the hem: the outline and the support stay. Faces and their order
// stay. Throws InputError when the mesh has no such edge. CHECKs the range of ratio.
Mesh AddSliverTriangles(const Mesh& mesh, double support_radius, double ratio);

// The smallest height of a triangle by its longest side, 0.87 where all are equilateral.
double MinTriangleQuality(const Mesh& mesh);

}  // namespace drape
