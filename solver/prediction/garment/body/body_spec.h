// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "solver/prediction/garment/body/body_sequence.h"

namespace drape {

// Makes the body that a user names: "mannequin:walk" (any of MotionNames), with the arms lifted to
// arm_angle for dressing [rad], or the names of OBJ files, "DIR/body_%04d.obj", which the options
// are for. Throws the InputErrors of ParseMotion, MannequinMotion and ReadBodySequence.
std::unique_ptr<Body> ParseBodySpec(const std::string& spec, double arm_angle,
                                    const BodySequenceOptions& options = {});

}  // namespace drape
