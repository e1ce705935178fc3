// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/util/options/field.h"
#include "physics/util/run_control.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/garment_mesh.h"

namespace drape {

// A garment on a moving body: implicit Euler steps with contact and friction between cloth and
// body, and of the cloth with itself.
struct WearOptions {
  double h = 0.01;  // time step [s]
  int steps_per_frame = 4;
  int frames = 100;         // after that of the start
  double thickness = 4e-4;  // of the cloth [m]
  // Between the body and the vertices of the cloth [m]. Faces and edges keep off half of the
  // thickness only; a skin of more than an edge cuts off a round limb keeps them from touching.
  double skin_offset = 3e-3;
  double friction = 0.3;     // with the body
  bool self_contact = true;  // without it the cloth passes through itself
  double self_friction = 0.3;
  double start_noise = 0.0;    // standard deviation of the vertices before the first step [m]
  double pin_stiffness = 1e3;  // of a vertex that the pelvis holds [N/m]
  ImplicitEulerOptions euler = {.tolerance = 1e-5, .max_iterations = 100};
};

// Wear sets friction and contact by its own options. Threads, solver, cancel and on_accept leave
// the result as it is.
template <MutableOrConst<ImplicitEulerOptions> Options, class Visitor>
void VisitFields(Options& euler, Visitor&& visit) {
  auto& [tolerance, max_iterations, max_halvings, unused_friction, unused_self_friction,
         creep_speed, friction_rounds, friction_change, unused_self_contact, threads, linear_solver,
         cancel, on_accept] = euler;
  visit(tolerance, Field{.key = "tolerance",
                         .doc = "unbalanced force at the end of a time step, relative to the "
                                "weight of the garment",
                         .range = {.least = 1e-10, .most = 0.1}});
  visit(max_iterations, Field{.key = "max_iterations", .is_option = false});
  visit(max_halvings, Field{.key = "max_halvings", .is_option = false});
  visit(creep_speed, Field{.key = "creep_speed",
                           .doc = "relative speed below which contacts that hold creep",
                           .unit = "m/s",
                           .range = {.least = 1e-6, .most = 1}});
  visit(friction_rounds, Field{.key = "friction_rounds",
                               .doc = "at most so many solutions of a time step, each with the "
                                      "normal forces of the last",
                               .range = {.least = 1, .most = 100}});
  visit(friction_change, Field{.key = "friction_change", .is_option = false});
}

template <MutableOrConst<WearOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [h, steps_per_frame, frames, thickness, skin_offset, friction, self_contact, self_friction,
         start_noise, pin_stiffness, euler] = options;
  visit(h, Field{.key = "time_step",
                 .doc = "largest time step; a frame of .04 s has a whole number of them",
                 .unit = "s",
                 .range = {.least = 0, .most = 10, .above_least = true}});
  visit(steps_per_frame, Field{.key = "steps_per_frame", .is_option = false});
  visit(frames, Field{.key = "frames", .is_option = false, .in_key = false});
  visit(start_noise, Field{.key = "start_noise",
                           .doc = "random displacement of the cloth before the first step, its "
                                  "standard deviation",
                           .unit = "m",
                           .range = {.least = 0, .most = 0.01}});
  visit(thickness, Field{.key = "thickness",
                         .doc = "thickness of the cloth",
                         .unit = "m",
                         .range = {.least = 0, .most = 0.01}});
  visit(skin_offset, Field{.key = "skin_offset",
                           .doc = "distance of the vertices of the cloth from the body; edges and "
                                  "faces keep off less",
                           .unit = "m",
                           .range = {.least = 0, .most = 0.01}});
  visit(friction, Field{.key = "friction",
                        .doc = "coefficient of friction between cloth and body",
                        .range = {.least = 0, .most = 10}});
  visit(self_contact, Field{.key = "self_contact", .doc = "prevent self-intersection"});
  visit(self_friction, Field{.key = "self_friction",
                             .doc = "coefficient of friction of the cloth with itself",
                             .range = {.least = 0, .most = 10}});
  visit(pin_stiffness, Field{.key = "pin_stiffness", .is_option = false});
  VisitFields(euler, visit);
}

// One frame, and what the steps that led to it took.
struct WornFrame {
  int index = 0;  // 0: the start
  double time = 0.0;
  State cloth;
  Eigen::VectorXd body = {};     // [m], shape [3B]
  double smallest_gap = 0.0;     // between a vertex of the cloth and the body [m]
  double largest_stretch = 0.0;  // of a face: its largest principal stretch − 1
  // Pairs of faces that meet: of the cloth and of the body, and both of the cloth.
  int body_intersections = 0, self_intersections = 0;
  int newton_steps = 0;
  double seconds = 0.0;  // wall clock
};

enum class WearStatus { kDone, kCancelled, kFailed };
struct WearResult {
  WearStatus status = WearStatus::kDone;
  std::string reason = {};  // of a failure, with time and place
  int worst_vertex = -1;    // of a failure: of the sewn garment, at that place
  int frames = 0;           // handed to on_frame
};

// Places of a garment once its seams are drawn together without a body [m], shape [3V].
Eigen::VectorXd DrawSeams(const SewnGarment& garment);

// The garment before its first step: out of the body at t = 0, its faces as well where they come
// out by moving their vertices up to 30 mm (FindStartPiercing). It may intersect itself, which
// contact cannot undo (FindStartIntersection). seed: of the noise.
State StartToWear(const SewnGarment& garment, const Body& body, const WearOptions& options,
                  uint64_t seed = 1);

// Two faces of the garment that meet in this state, if any.
std::optional<std::pair<int, int>> FindStartIntersection(const SewnGarment& garment,
                                                         const State& state);

// A vertex at a face that meets the body in this state or is nearer to it than half of the
// thickness, if any. Contact keeps a body out of the cloth but does not take it out.
std::optional<int> FindStartPiercing(const SewnGarment& garment, const Body& body,
                                     const WearOptions& options, const State& state);

// Runs from `state` at frame `first` and hands over that frame (if it is 0) and all later ones. A
// step that does not converge is repeated in 2, 4, … 64 shorter ones; if these fail as well the run
// ends, and the last good frame is the one before.
WearResult Wear(const SewnGarment& garment, const MaterialField& material, const Body& body,
                const WearOptions& options, State state, int first, const RunControl& control,
                const std::function<void(const WornFrame&)>& on_frame);

}  // namespace drape
