// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "physics/simulation/backend.h"
#include "solver/fit/fit.h"
#include "solver/fit/observation.h"
#include "solver/fit/protocol/initial_guess_grid.h"
#include "solver/forward/settle.h"

namespace drape {

// The protocol [METHODS, P18] for one material and its images. Many drapes are stable and the
// trust region stays in its basin, so a grid of stretch × bend factors × seed shapes on a coarse
// cloth is ranked by outline, and the best seeds are settled on the fine cloth and fitted by Ceres
// in rounds: each round keeps the best branches of the one before and spends more iterations. The
// second round begins by seeding the drapes anew with the material fitted so far, where that comes
// nearer to the image. The branches of a round are fitted side by side, so that their rollouts make
// batches (RunBatched); results and the order of all callbacks do not depend on that.
struct StagedFitOptions {
  InitialGuessOptions grid;
  // Branches fitted in each round. A first number above the grid's count of stretch × bend factors
  // refines the grid (Refined): branches of one material and other lifts often are the same.
  std::vector<int> keep = {5, 2, 1};
  std::vector<int> iterations = {5, 8, 40};  // of Ceres for each of them
  ParameterTying parameters = ParameterTying::kEntries;
  double prior_sigma = 1.0;         // of each log factor about the branch's grid point
  double sigma_px = 0.5;            // standard deviation of r(θ) [px]
  double initial_damping = 4.0;     // of Levenberg–Marquardt: a bold first step mostly
                                    // leaves the branch
  double max_outline_change = 4.0;  // of a trial, predicted; more is refused [px]
  double max_jump = 0.03;           // of a trial's shape from its prediction [m]
  bool warm_restart = true;         // kDynamic: trials start from the last accepted drape
  int newton_iterations = 30;       // of a trial: more are spent only near a bifurcation
  int angles = 90;                  // K of r(θ)
  double settle_h = 0.1;            // steps that calm a seed before Newton [s]
  int settle_steps = 40;
  SolveMode integrator = SolveMode::kStatic;

  void Check() const;  // programmer errors
};

// How a seed becomes a drape.
SettleOptions MakeSettleOptions(const StagedFitOptions& options);

// What is fitted. Backends outlive the call; `coarse` has the scene and law of `fine`.
struct FitProblem {
  Backend* fine = nullptr;
  Backend* coarse = nullptr;
  MaterialField material;                 // start tables
  std::vector<Observation> targets;       // their `start` is not used
  const StripResiduals* tests = nullptr;  // fitted jointly where given; each branch has a clone
};

// One material with its drapes, on its own branch.
struct FitCandidate {
  InitialGuess seed;
  double seed_rms = 0.0;                // of the seeds' settled drapes on the fine cloth [px]
  Eigen::VectorXd theta;                // log factors on the seed's tables, shape [P]
  std::vector<Eigen::VectorXd> shapes;  // the fitted drape of each target [m], shape [3V]
  double cost = 0.0;                    // ½ Σ residual², prior included
  double profile_rms = 0.0;             // over all targets [px]
  FitTermination termination = FitTermination::kFailed;
  int iterations = 0;
  bool done = false;  // in this round
  bool valid() const { return !shapes.empty(); }
};

// A staged fit between two units of work; saved and read back, the fit goes on to the same answer.
struct StagedFitState {
  bool grid_done = false;
  std::vector<FitCandidate> branches;  // of this round; in the first more than are wanted, since
                                       // some seeds have no stable drape or one that another has
  int round = 0;
  int iterations = 0;
  RolloutCounts counts;
  double grid_seconds = 0.0;
  double fit_seconds = 0.0;
};

// All are called on the thread of RunStagedFit, in an order that does not depend on timing.
struct StagedFitCallbacks {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(const StagedFitState&)> save;  // after each unit
  std::function<void(const std::string& stage, double fraction, double profile_rms)> progress;
  std::function<void(const std::string&)> log;  // one line
};

// Runs from `state` to the end or to a cancel and returns the state then. Its best branch (Best) is
// the fit; on a cancel that is the best so far.
StagedFitState RunStagedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitCallbacks& callbacks);

// Branches of the present round that are done.
int DoneCandidates(const StagedFitState& state);

// The valid branch of least cost, or nullptr.
const FitCandidate* Best(const StagedFitState& state);

// The tables of a branch.
MaterialField FittedMaterial(const FitProblem& problem, const StagedFitOptions& options,
                             const FitCandidate& branch);

// ∂residual/∂θ of all targets, then of all points of tests, at a branch, shape [ΣK + N, P]; empty
// when its drapes or strips are not stable.
Eigen::MatrixXd FitJacobian(const FitProblem& problem, const StagedFitOptions& options,
                            const FitCandidate& branch);

}  // namespace drape
