// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "solver/studies/stability/cases/stability_case.h"
#include "solver/studies/stability/contact/contact_scene.h"

namespace drape {

struct ContactLimits {
  int max_steps = 600;
  double max_seconds = 60.0;  // a run that takes longer has not converged
};

// How a run of contact ended; the first that applies:
// - pinched: the method fails, and a vertex that PushOut moves out of one obstacle is in another,
//   or the method says so; the end is that of the last good step;
// - diverged, factor failed, not converged: what the method reports otherwise;
// - passed through: a vertex moves straight in a step, and its way is deeper in an obstacle than
// half of
//   its inradius, or a part of a face at the end is; two sheets meet, or have changed places;
// - cuts in: a vertex or a part of a face is in an obstacle, by more than a tenth of the thickness;
// - off the law (slope, skid): slides or creeps as the law of friction [MODEL, M61] does not, by
//   more than 5 %;
// - holds.
struct ContactRun {
  StabilityOutcome outcome = StabilityOutcome::kHolds;
  int steps = 0;
  std::optional<double> speed = {};  // rms over the vertices at the end [m/s]
  std::optional<double> distance =
      {};  // by which the cloth has been deepest in an obstacle [m], or 0
};

// None when `cancel` turned true on the way.
std::optional<ContactRun> RunContact(const StabilityCase& run, const MaterialField& material,
                                     const ContactLimits& limits, const std::atomic<bool>& cancel);

// The mean speed along the slope or floor that the law asks for at the end of a run of `duration`
// [m/s]. normal_gain: by how much the run has changed the mean speed along the normal [m/s], of a
// skid.
double SpeedByLaw(const StabilityCase& run, double duration, double normal_gain);

}  // namespace drape
