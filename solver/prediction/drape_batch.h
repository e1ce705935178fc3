// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "cuda/make_backend.h"
#include "losses/readout/readouts.h"
#include "physics/cloth/state.h"
#include "physics/simulation/backend.h"
#include "solver/fit/parametrisation.h"
#include "solver/forward/settle.h"

namespace drape {

// A batch of B drapes as differentiable functions of factors on the entries of their tables and of
// where they start: what a program of a user's own differentiates, an optimiser or a network.
// MakeBackend simulates them, a start shape (start_shape.h) says where they start, and a readout
// (readouts.h) is what is read of them.

// One row for each drape: the inputs themselves, a change of them, or derivatives by them.
struct DrapeInputs {
  // Logarithms of factors on P numbers of the tables, shape [B, P]. P is 1 (bend), 2 (stretch,
  // bend), 3 (rows of bend), 7 (columns of stretch, rows of bend) or 39 (all entries).
  RowMatrix log_factors;
  RowMatrix start = {};     // positions [m], shape [B, 3V]; empty: the flat cloth
  RowMatrix velocity = {};  // [m/s], shape [B, 3V]; empty: 0
  // Damping, drag and wind: the numbers of DynamicsEntry from kByMassDamping on, shape [B, 6].
  // Empty: those of the materials; of a change 0. They act in time steps, not at an equilibrium.
  RowMatrix dynamics = {};
};

// States of each drape at T frames, changes of them, or derivatives by them.
struct DrapeFrames {
  RowMatrix x, v;  // [m] and [m/s], shape [B, T·3V]
};

struct DrapeBatchOptions {
  double h = 0.05;                             // time step [s], > 0
  int steps = 100;                             // ≥ 0
  SolveMode solve_mode = SolveMode::kDynamic;  // kStatic: Newton's method after the steps
  bool record = false;           // keep what Vjp needs of the steps, which saves it a simulation
  std::vector<int> frames = {};  // RolloutOptions::frames; of kDynamic
};

// All numbers of a drape that failed, of one that cannot be read, and of derivatives that do not
// exist are NaN. Shapes of other sizes and numbers that are not finite are InputErrors. When
// *cancel turns true, the rest is NaN.
class DrapeBatch {
 public:
  // materials: one for all drapes or one for each. The backend outlives the object.
  DrapeBatch(Backend& backend, const std::vector<MaterialField>& materials, DrapeInputs inputs,
             const DrapeBatchOptions& options = {});
  // Simulates; before all others.
  void Run(const std::atomic<bool>* cancel = nullptr);

  int size() const { return static_cast<int>(starts_.size()); }
  const std::vector<std::string>& status() const { return status_; }  // "ok", "stable" or why not
  std::vector<bool> IsFound() const;
  RowMatrix Positions() const;        // [m], shape [B, 3V]
  RowMatrix Velocities() const;       // [m/s], shape [B, 3V]; 0 of equilibria
  Eigen::VectorXd Residuals() const;  // ForceResidual, shape [B]
  DrapeFrames Frames() const;

  RowMatrix Read(const Readout& readout) const;  // shape [B, K]
  // ∂r/∂inputs·change, shape [B, K], on the threads of the host. An empty part of `change` is 0.
  RowMatrix Jvp(const Readout& readout, DrapeInputs change,
                const std::atomic<bool>* cancel = nullptr) const;
  // ∂L/∂inputs of scalars L, from dL_dr, shape [B, K].
  DrapeInputs Vjp(const Readout& readout, const RowMatrix& dL_dr,
                  const std::atomic<bool>* cancel = nullptr) const;
  // The same of the frames.
  DrapeFrames FrameJvp(DrapeInputs change, const std::atomic<bool>* cancel = nullptr) const;
  DrapeInputs FrameVjp(DrapeFrames dL, const std::atomic<bool>* cancel = nullptr) const;

 private:
  void FillAndCheck(Eigen::Index count, Eigen::Index factors, DrapeInputs* inputs) const;
  std::vector<RolloutInput> ListInputs() const;
  RolloutOptions Steps(const std::atomic<bool>* cancel) const;
  std::vector<int> ListFound() const;
  RowMatrix NotANumber(Eigen::Index columns) const;
  DrapeFrames StackFrames(const std::vector<std::vector<State>>& frames) const;
  Eigen::Index frame_columns() const;
  // Calls use(i, solver) for each drape that was found.
  void ForEachFound(const std::function<void(int i, StepSolver& solver)>& use,
                    const std::atomic<bool>* cancel) const;
  // How drape i moves, shape [3V]; empty where that has no derivative.
  Eigen::VectorXd Move(int i, const DrapeInputs& change, StepSolver& solver,
                       const std::atomic<bool>* cancel) const;
  JvpResult MoveInSteps(int i, const DrapeInputs& change, StepSolver& solver,
                        const std::atomic<bool>* cancel) const;
  DrapeInputs NoGradient() const;
  // Adds the adjoints of the drapes `members`, from ∂L/∂x of each of the B drapes, shape [3V, 1],
  // and from those by frames, none or one for each drape.
  void AddAdjoints(const std::vector<int>& members, const std::vector<RowMatrix>& dL_dx,
                   std::vector<AdjointOptions> by_frames, const std::atomic<bool>* cancel,
                   DrapeInputs* gradient) const;
  void AddEquilibriumAdjoints(const std::vector<int>& members, const std::vector<RowMatrix>& dL_dx,
                              DrapeInputs* gradient) const;

  Backend& backend_;
  DrapeBatchOptions options_;
  std::vector<TableParametrisation> maps_;  // of each drape
  std::vector<MaterialField> materials_;
  std::vector<State> starts_, ends_;  // an end without positions: not found
  std::vector<std::vector<State>> frames_;
  std::vector<std::string> status_;
  std::vector<Recording> recordings_;
};

}  // namespace drape
