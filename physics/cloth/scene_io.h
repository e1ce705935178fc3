// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/cloth/scene.h"
#include "physics/util/options/field.h"

namespace drape {

class JsonInput;

// Here and not in scene.h, which device code includes: names take C++20.
constexpr auto EnumNames(ContactModel) {
  return MakeNames<ContactModel>({{ContactModel::kNone, "none"},
                                  {ContactModel::kSupport, "support"},
                                  {ContactModel::kSelf, "self"}});
}

template <MutableOrConst<CusickContact> Contact, class Visitor>
void VisitFields(Contact& contact, Visitor&& visit) {
  auto& [model, thickness] = contact;
  visit(model,
        Field{.key = "contact",
              .doc = "what the hanging cloth can touch: none; support: the support of the drape "
                     "test; self: this and itself, which takes the CPU"});
  visit(thickness, Field{.key = "thickness",
                         .doc = "thickness of the cloth in contact",
                         .unit = "m",
                         .range = {.least = 0, .most = 0.01}});
}

// Reads a scene from a JSON file that lists the terms that act. A term that is not listed is
// absent, except stretch and bend, which act unless they are switched off:
//   {"stretch": false, "bend": false,
//    "gravity": [0, 0, -9.81],                                    m/s²
//    "handles": {"regions": […, …], "vertices": [0, 20], "stiffness": 1000},  N/m at each vertex
//    "load": {"region": …, "force": [2, 0, 0]},                   N in total, on the hem there
//    "contact": {"thickness": 4e-4, "range": 5e-4, "stiffness": 100,  m, m, Pa
//                "obstacles": […], "self": true}}               the cloth with itself too
// Held are the vertices in any of the regions and those of these numbers, from 0 in the order of
// the mesh; "region" stands for a list of one. A region of rest positions [m] is one of
//   {"disc": {"radius": 0.09, "centre": [0, 0]}},
//   {"ring": {"inner": 0.149, "outer": 0.15, "centre": [0, 0]}},
//   {"half_plane": {"normal": [1, 0, 0], "offset": 0}}            normal·x ≤ offset
// An obstacle [m] is one of
//   {"plane": {"normal": [0, 0, 1], "offset": -0.2}}              the half-space below it
//   {"sphere": {"centre": [0, 0, -0.1], "radius": 0.1}}
//   {"capsule": {"from": [-0.1, 0, -0.1], "to": [0.1, 0, -0.1], "radius": 0.05}}
//   {"plate": {"top": [0, 0, -0.001], "radius": 0.09, "thickness": 0.05, "rim_radius": 0.001}}
//   {"mesh": {"file": "head.obj", "scale": 0.001, "translation": [0, 0, -0.1]}}
// Of a mesh, the file is relative to the folder of the scene; its vertices times the scale, by
// default 1, plus the translation, by default 0, are the surface of a solid (RequireSolid).
// By default centre is the origin, inner 0, outer infinite and normal [1, 0, 0]; a normal need not
// have length 1. Comments are allowed. Throws InputError, naming the file, the key, the value and
// what was expected.
Scene ReadScene(const std::string& path);
// The same from an object of another file. folder: that its paths are relative to.
Scene ReadScene(const JsonInput& input, const std::string& folder);

}  // namespace drape
