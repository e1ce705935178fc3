// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "physics/cloth/assembly/dynamics.h"
#include "physics/cloth/assembly/step_solver.h"

namespace drape {

// The dynamic step [MODEL, M30]: (M + h²H)·v' = M·v + h·f, x' = x + h·v', and its
// discrete-exact derivatives through the matrix too:
//   A·dv' = M·dv + ∂g/∂x·dx + ∂g/∂p·dp at w = v', dx' = dx + h·dv'.
// MaterialField::dynamics adds damping and air [MODEL, M64, M65].

struct RolloutOptions {
  double h = 0.05;  // time step [s], > 0
  int steps = 100;  // ≥ 0
  // Memory for factors kept for the adjoints, of a batch together; steps that do not fit are
  // factored again on the way back. The default keeps 320 steps of 1,420 vertices.
  std::size_t factor_memory = std::size_t{2} << 30;  // [bytes]
  const std::atomic<bool>* cancel = nullptr;         // ends the rollout early when it turns true
  // Frames: the numbers of done steps after which the state is seen, ascending, 0 (the start) to
  // `steps`. They change no bit of the rest.
  std::vector<int> frames = {};

  bool operator==(const RolloutOptions&) const = default;
  void Check() const;  // programmer errors
};

enum class RolloutStatus {
  kOk,
  kNotPositiveDefinite,  // a factorisation failed
  kNotFinite,            // positions overflowed
  kCancelled,
  kBlocked,  // an obstacle shortened a move or the cloth touches itself, and this has no
             // derivative; not of a rollout without any
  kOverlaps  // the start is no shape of a cloth that touches itself (FindSelfOverlap)
};
const char* ToString(RolloutStatus status);

// What a backend keeps of a rollout in a place of its own.
struct BackendRecording {
  virtual ~BackendRecording() = default;
};

// States of a rollout, kept for the adjoint: x[k], k = 0..steps, v[k + 1] solved at x[k].
struct Recording {
  std::vector<Eigen::VectorXd> x, v;
  std::vector<std::vector<double>> factor;  // of step k; empty where it is to be factored again
  std::shared_ptr<const BackendRecording> backend;  // instead of all these; for that backend only
};

struct RolloutResult {
  RolloutStatus status = RolloutStatus::kOk;
  State end;
  int steps = 0;                   // done
  std::vector<State> frames = {};  // the states at RolloutOptions::frames that were reached
};

// The first columns of a tangent, shape [3V, n], without a copy.
using TangentView = Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>;

// What a tangent has beside the 39 columns of the material at the end.
struct TangentOptions {
  // Seven more columns: by the numbers of DynamicsEntry themselves, unweighted.
  bool dynamics = false;
  // Further columns, ∂x_start/∂q and ∂v_start/∂q, shape [3V, q] each, of the start once it is out
  // of all obstacles; both may be empty. A common initial velocity: start_dv =
  // Eigen::Matrix3d::Identity().replicate(V, 1), start_dx zero.
  RowMatrix start_dx = {}, start_dv = {};
  // Takes the tangents at each frame, which are then not kept: a reader of a few numbers reduces
  // them at once. frame: index in RolloutOptions::frames. In a batch it is called from the threads
  // of the backend, for one rollout in the order of its frames; a rollout that is begun again,
  // which CUDA does where a system is not positive definite, calls it from the first frame on
  // again.
  std::function<void(int frame, const State& state, const TangentView& dx, const TangentView& dv)>
      on_frame = {};
};

struct FrameTangent {
  RowMatrix dx, dv;  // as those of TangentResult
};

struct TangentResult {
  RolloutResult rollout;
  // ∂x_end/∂p, ∂v_end/∂p, shape [3V, n]: by the 39 entries, then as TangentOptions say.
  RowMatrix dx, dv;
  std::vector<FrameTangent> frames = {};  // of the frames that were reached, unless on_frame is set
};

// ∂L/∂x and ∂L/∂v at a frame of m scalars, shape [3V, m] each; an empty one is zero.
struct FrameSeeds {
  RowMatrix x = {}, v = {};
};

// What an adjoint takes and gives beside seeds at the end and the gradient by the material.
struct AdjointOptions {
  bool dynamics = false;  // AdjointResult::dynamics
  // One for each of RolloutOptions::frames, or none. A frame that the rollout did not reach has no
  // effect.
  std::vector<FrameSeeds> frames = {};
};

struct AdjointResult {
  RolloutStatus status = RolloutStatus::kOk;
  MaterialGradient material;
  RowMatrix x0, v0;         // ∂L/∂x_start, ∂L/∂v_start, shape [3V, m]
  RowMatrix dynamics = {};  // by the numbers of DynamicsEntry, shape [7, m], where wanted
};

// The step of all rollouts, the only implementation of [MODEL, M30]: v' at state.x, then
// x' = x + h·v'. mass: LumpedMass(material.density), shape [3V]. The factor stays in the solver.
// Positions are unchanged after another status than kOk. Where a vertex would enter an obstacle,
// its move ends before and v' is what is left of it (ShortenMoves), and so with cloth that would
// pass through itself; *blocked, if given, tells so, and whether the cloth touches itself.
RolloutStatus AdvanceOneStep(StepSolver& solver, const MaterialField& material,
                             const Eigen::VectorXd& mass, double h, State& state,
                             bool* blocked = nullptr);

// Steps from `start`, once it is out of all obstacles (PushOut). `recording`, when given, keeps
// what RolloutAdjoint needs; a rollout that is blocked has none and ends there.
RolloutResult Rollout(StepSolver& solver, const MaterialField& material, const State& start,
                      const RolloutOptions& options, Recording* recording = nullptr);

// Rollout with ∂(end)/∂p for the 39 entries, each weighted as in AddMaterialColumns, and for what
// `more` adds. CHECKs its shapes.
TangentResult RolloutTangent(StepSolver& solver, const MaterialField& material,
                             const MaterialField& weight, const State& start,
                             const RolloutOptions& options, const TangentOptions& more = {});

// The end of a rollout and its change to first order, ∂(end)/∂p·dp + ∂(end)/∂start·dstart: a
// Jacobian-vector product, by one solve a step.
struct JvpResult {
  RolloutResult rollout;
  State change;                    // [m] and [m/s] for each unit of the direction, shape [3V] each
  std::vector<State> frames = {};  // the changes at the frames that were reached
};
// change: dp, that of each table entry; start_change: dstart, that of the start once it is out of
// all obstacles; dynamics_change: that of each number of DynamicsEntry, or none.
JvpResult RolloutJvp(StepSolver& solver, const MaterialField& material, const MaterialField& change,
                     const State& start, const State& start_change, const RolloutOptions& options,
                     std::span<const double> dynamics_change = {});

// Gradients of m scalars L with seeds ∂L/∂x_end, shape [3V, m], back through a recorded rollout,
// and with seeds at its frames, all in one pass.
AdjointResult RolloutAdjoint(StepSolver& solver, const MaterialField& material,
                             const RolloutOptions& options, const Recording& recording,
                             const RowMatrix& seeds, const AdjointOptions& more = {});

}  // namespace drape
