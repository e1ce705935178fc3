// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"

namespace drape {

// How a drape is found from its start.
enum class SolveMode {
  kDynamic,  // the shape after time steps
  kStatic    // the equilibrium near the start
};
constexpr auto EnumNames(SolveMode) {
  return MakeNames<SolveMode>({{SolveMode::kStatic, "static"}, {SolveMode::kDynamic, "dynamic"}});
}

// A drape is at rest when the forces that remain are at most this share of its weight
// (ForceResidual; Newton's tolerance is a thousandth of it) and, nudged (Nudge), it returns to
// within this distance of each vertex.
inline constexpr double kAtRestResidual = 1e-6;
inline constexpr double kAtRestDrift = 1e-3;  // [m]

// How a drape is found from a start shape: time steps relax it, then Newton finds the equilibrium.
struct SettleOptions {
  RolloutOptions steps = {};
  SolveMode solve_mode = SolveMode::kStatic;  // kDynamic: without Newton
  EquilibriumOptions equilibrium = {};
};

struct SettledDrape {
  RolloutStatus steps = RolloutStatus::kOk;
  // The result of Newton's method, whose x is the drape. Without Newton, or where the steps failed,
  // only x is set: the end of the steps, or empty.
  EquilibriumResult rest;

  // Whether there is a drape: a stable equilibrium, or the end of the steps where Newton is not
  // used.
  bool IsUsable(SolveMode solve_mode) const;
};

// The starts under one material as inputs of a backend; both outlive the inputs.
std::vector<RolloutInput> MakeInputs(const MaterialField& material, std::span<const State> starts);

// Settles the starts under one material, in their order.
std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options);
// Settles states of several materials, in the order of the inputs.
std::vector<SettledDrape> Settle(Backend& backend, std::span<const RolloutInput> inputs,
                                 const SettleOptions& options);

// Where a drape that was nudged or released comes to rest.
struct NudgedDrape {
  EquilibriumStatus status = EquilibriumStatus::kStable;  // the first that is not, of all nudges
  Eigen::VectorXd x;   // the shape furthest from the drape that was nudged [m], shape [3V], or that
                       // drape itself unless all nudges come to rest; the end of a release that
                       // keeps it
  double drift = 0.0;  // largest distance of a vertex between them [m]
};

// Whether the shape x, shape [3V], over the support of the Cusick test is at rest. A few random
// waves of 0.1 mm rms, which is how far a real drape moves between two photographs, lift and lower
// its hem, and Newton's method takes each to rest. A drape at rest returns within kAtRestDrift, one
// close to snapping to another does not. That one has a second chance: 30 s of time steps that keep
// it there.
NudgedDrape Nudge(Backend& backend, const MaterialField& material, const Eigen::VectorXd& x,
                  const EquilibriumOptions& options);

// A drape to settle.
struct DrapeTask {
  MaterialField material;
  State start;
};

// The number of starts in one batch that keeps a backend busy: few keep a device waiting for the
// host.
int SettleBatchSize(const Backend& backend, int threads);

// Settles the tasks 0 … count − 1, `batch` of them at a time. task(i) is called when its batch
// begins; done receives the drapes in order. The batch size does not change a bit of the drapes
// (Backend). When *options.steps.cancel turns true it ends, and the batch in work is dropped.
void SettleInBatches(Backend& backend, int count, int batch,
                     const std::function<DrapeTask(int)>& task, const SettleOptions& options,
                     const std::function<void(int, SettledDrape)>& done);

}  // namespace drape
