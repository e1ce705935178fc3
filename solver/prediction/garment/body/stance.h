// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/mesh/obj_io.h"

namespace drape {

// How the files of a body are meant. What is left open is guessed from the first file.
struct BodyFiles {
  double frames_per_second = 30;
  std::string up = "auto";          // the axis that points up: x, -x, y, …
  std::string front = "auto";       // the axis to which the body faces
  double scale = 0;                 // the unit of length [m]; 0: guessed
  std::vector<double> offset = {};  // added in the end, x, y and z [m]; empty: guessed
  bool grow = true;                 // from half of the radii to all of them in half a second
};

// States what `files` leaves open. Of a standing person the left is the mirror image of the right,
// the depth is the smallest extent, the legs are further apart than the head is wide, and the toes
// point to the front. The unit makes the height 1.4 … 2.2 m: m, dm, cm, mm, feet or inches; else
// that of a child, .5 … 1.4 m: m, cm or mm. The feet are put on z = 0, and the hips on x = y = 0
// where they are more than 10 cm off. A guess that differs from metres with z up, facing −y, on
// z = 0, is reported (NoteInput). An axis to the front that only is left open follows from `up`.
//
// Throws InputError (prefix `where`) where `up` is left open and the proportions are not those of a
// standing person, for a height that no unit makes that of a person, a front that is not across
// `up`, an offset of other than three numbers, an extent that another unit would make that of a
// person (CheckUsual) or that is not within .1 … 10 m, and a body that is not upright.
BodyFiles FindStance(const ObjSurface& surface, const BodyFiles& files, const std::string& where);

// Turns, scales and moves a surface: to metres, z up, facing −y. All of `files` is stated.
void Stand(const BodyFiles& files, ObjSurface& surface);

}  // namespace drape
