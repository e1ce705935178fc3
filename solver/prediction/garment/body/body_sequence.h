// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "solver/prediction/garment/body/body.h"

namespace drape {

struct BodySequenceOptions {
  double frames_per_second = 30;
  double max_speed = 20;  // of a vertex between two frames [m/s]
};

// Reads a user's body: the OBJ files whose names follow from a pattern such as "body_%04d.obj",
// numbered from 0 or 1 to the last that exists, with the same faces in all. Metres, z up. Vertices
// move linearly from frame to frame and rest after the last. The pelvis is the part of the body
// between 45 % and 65 % of its height in the first frame; its motion is the rigid motion that fits
// that of these vertices best.
//
// Throws InputError for a name without one %0Nd, a number out of range (fewer than one frame per
// second, a speed that is not positive), and, naming file and place, for a missing first file, a
// file that ReadObjSurface refuses, a surface that is not closed, whose faces are clockwise as seen
// from outside, or that intersects itself, faces or vertices that differ from those of the first
// frame, and a vertex that moves faster than max_speed.
std::unique_ptr<Body> ReadBodySequence(const std::string& name_pattern,
                                       const BodySequenceOptions& options);

}  // namespace drape
