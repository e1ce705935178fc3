// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/mesh/mesh.h"

namespace drape {

// The specimen of a drape test and the disc that it lies on. Drapes of other discs are of another
// quantity: specimens of 24, 30 and 36 cm on a support of 18 cm give three drape coefficients of
// one fabric [BS 5058], [ISO 9073-9].
struct DrapeDiscs {
  double specimen = 0.15;  // radius [m]
  double support = 0.09;   // radius [m]

  // Not defaulted, which CUDA files in C++17 do not take.
  bool operator==(const DrapeDiscs& other) const {
    return specimen == other.specimen && support == other.support;
  }
};

// "30 cm on 18 cm": their diameters.
std::string ToString(const DrapeDiscs& discs);

// A line that files of a drape hold (WriteObj, WritePng), so that drapes of other discs are not
// mixed up: "specimen_diameter_m=0.3 support_diameter_m=0.18". None for a text that is no such
// line.
std::string DiscsLine(const DrapeDiscs& discs);
std::optional<DrapeDiscs> ParseDiscsLine(const std::string& line);

// The specimen as a mesh.
struct DiscOptions {
  double radius = DrapeDiscs().specimen;         // [m]
  double support_radius = DrapeDiscs().support;  // [m]
  int target_vertices = 1200;                    // exact number of vertices, 100 … 1,000,000
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
