// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/cloth/scene.h"

namespace drape {

// A JSON file that lists the terms that act; what it does not list is absent, but for stretch and
// bend, which are there unless they are switched off:
//   {"stretch": false, "bend": false,
//    "gravity": [0, 0, -9.81],                                    m/s²
//    "handles": {"region": …, "stiffness": 1000},                 N/m a vertex
//    "load": {"region": …, "force": [2, 0, 0]}}                   N in total, on that part of the
//    hem
// A region of rest positions [m] is one of
//   {"disc": {"radius": 0.09}}, {"ring": {"inner": 0.149, "outer": 0.15}},
//   {"half_plane": {"normal": [1, 0, 0], "offset": 0}}            normal·x ≤ offset
// where inner is 0, outer endless and normal [1, 0, 0] when left out; a normal need not be of
// length 1. Comments are allowed. Throws InputError (file, key, value, what was expected).
Scene ReadScene(const std::string& path);

}  // namespace drape
