// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body_spec.h"

#include "solver/prediction/garment/body/mannequin.h"

namespace drape {

std::unique_ptr<Body> ParseBodySpec(const std::string& spec, double arm_angle,
                                    const BodySequenceOptions& options) {
  constexpr char kMannequin[] = "mannequin:";
  if (!spec.starts_with(kMannequin)) return ReadBodySequence(spec, options);
  const MotionKind kind = ParseMotion(spec.substr(sizeof(kMannequin) - 1));
  return std::make_unique<Mannequin>(MannequinMotion(kind, arm_angle));
}

}  // namespace drape
