// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/mesh/mesh.h"

namespace drape {

// The specimen of BS 5058 / ISO 9073-9 as a mesh.
struct DiscOptions {
  double radius = 0.15;          // [m]
  double support_radius = 0.09;  // [m]
  int target_vertices = 1200;    // the mesh has exactly that many; at least 100
};

// A flat disc (z = 0, uv = xy) of relaxed, unstructured, nearly equilateral triangles without a
// preferred direction. A ring of equally spaced vertices lies on the support's radius and one on
// the hem, both to 1e-15 relative; neighbours on a ring are joined by mesh edges. The result is the
// same bit for bit on each run of a build.
// Measured for 100 … 50,000 vertices: smallest angle ≥ 29°, mean smallest angle of a face ≥ 48°
// (53° from 1,200 on); 0.2 s for 1,200, 10 s for 50,000. disc_test has the guarantees.
//
// Throws InputError for fewer than 100 or over 1,000,000 vertices, or radii that leave no room for
// a row of triangles.
Mesh MakeDisc(const DiscOptions& options = {});

}  // namespace drape
