// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "solver/studies/stability/cases/stability_case.h"

namespace drape {

inline constexpr double kContactGravity = 9.8;  // [m/s²]
inline constexpr double kSlopeTangent = 0.5;
inline constexpr double kPlateThickness = 2e-3;  // [m]
inline constexpr double kClosingFrom = 0.01;     // distance of two balls at first [m]

// What a case of a scenario of contact runs: squares of cloth of .1 m.
struct ContactScene {
  std::shared_ptr<const ClothModel> model;  // without contact
  MaterialField material;
  State start;
  double duration = 0.0;  // simulated [s]
  // What is around the cloth at a time [s].
  std::function<Contact(double time)> contact_at;
  bool is_self_contact = false;
  int sheets = 1;  // with as many vertices each
};

// ball, plate, rod: thrown down from 2 mm above, under gravity, until the sheet would be far below.
// rod: the cloth is draped over it, until .25 s.
// sheets: two squares, one turned by .4, that meet at `speed`; no gravity.
// slope: from rest, .4 s. skid: thrown at a floor at 45° with `speed` each way, no gravity.
// pinch: `layers` squares between balls that close to `distance` at `speed`, then stay .02 s.
// `material` is scaled as the case asks. CHECKs that the scenario is of contact.
ContactScene MakeContactScene(const StabilityCase& run, MaterialField material);

// The height of a lying sheet's midsurface over a floor that bears `pressure` [Pa]: [m].
double LyingHeight(const Contact& contact, double pressure);

}  // namespace drape
