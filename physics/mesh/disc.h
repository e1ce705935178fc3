// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/mesh/mesh.h"

namespace drape {

// The specimen of the drape test [BS 5058], [ISO 9073-9] as a mesh.
struct DiscOptions {
  double radius = 0.15;          // [m]
  double support_radius = 0.09;  // [m]
  int target_vertices = 1200;    // exact number of vertices, 100 … 1,000,000
};

// A flat disc (z = 0, uv = xy) of relaxed, unstructured, nearly equilateral triangles without a
// preferred direction [MODEL, M3]. A ring of equally spaced vertices lies on the support radius and
// one on the hem, both to 1e-15 relative. Neighbours on a ring are joined by mesh edges. A build
// returns the same result bit for bit on every run.
//
// Measured for 100 … 50,000 vertices: the smallest angle is at least 29°, and the mean over the
// faces of the smallest angle is at least 48° (53° from 1,200 vertices on). The time is 0.2 s for
// 1,200 vertices and 10 s for 50,000. disc_test checks the guaranteed bounds.
//
// Throws InputError for fewer than 100 or more than 1,000,000 vertices, and for radii that leave no
// room for a row of triangles.
Mesh MakeDisc(const DiscOptions& options = {});

}  // namespace drape
