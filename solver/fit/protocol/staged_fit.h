// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "solver/fit/fit.h"
#include "solver/fit/observed/observation.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/fit/strips.h"
#include "solver/forward/settle.h"

namespace drape {

// A model of one table: the form of its start tables, which its free numbers keep.
struct TableModel {
  TableForm form = TableForm::kGiven;
  ParameterTying parameters = ParameterTying::kEntries;
};

// An experiment whose branch is not searched: one that moves, or one beside the first.
struct SettledExperiment {
  std::shared_ptr<const Experiment> experiment;
  std::shared_ptr<const ClothModel> model;
  State start;
  std::string backend = "cpu";  // MakeBackend
};

// What is fitted. Backends outlive the call; all have the scene and law of `fine`.
struct FitProblem {
  Backend* fine = nullptr;    // of the result
  Backend* coarse = nullptr;  // of the trials of initial guesses
  // Clothes of the same rest shape, the coarsest first: RunNestedFit fits on the first of them,
  // then goes on, from the fit before, on each of the others and on `fine`.
  std::vector<Backend*> search = {};
  MaterialField material;  // start tables
  // Further ones, of the same density: the initial guesses try all.
  std::vector<MaterialField> other_materials = {};
  // Models that the fitted one contains, which RunNestedFit fits first, from the simplest on.
  std::vector<TableModel> simpler_models = {};
  std::vector<Observation> observations;
  bool mirrors = true;  // each may be seen on the cloth's mirror image
  // The start tables are of drapes of a pool that are like the images (ListPooledTables): they are
  // settled and ranked themselves, in place of a grid; where there are parts, each has one round
  // [METHODS, P76].
  bool is_pooled = false;
  // The specimen of each observation, from 1 without gaps; empty: each shows its own.
  std::vector<int> specimens = {};
  const Strips* strips = nullptr;  // laboratory measurements, fitted jointly where given
  std::vector<SettledExperiment> further = {};  // of the same fabric, fitted jointly
  // Numbers that are fitted before the search, from those of `material` and of the starts.
  std::vector<FreeNumber> fitted = {};
};

struct StagedFitOptions {
  InitialGuessOptions grid;
  // Candidates fitted in each round, from a pool in each part.
  std::vector<int> candidates_per_round = {10, 2, 1};
  std::vector<int> iterations = {3, 8, 40};  // of Ceres for each of them
  ParameterTying parameters = ParameterTying::kEntries;
  double prior_sigma = FitOptions().prior_sigma;  // of each log factor about the initial guess
  double initial_damping = TrustRegionOptions().initial_damping;
  ResidualOptions residuals;

  void Check() const;  // programmer errors
};

template <MutableOrConst<StagedFitOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [grid, candidates_per_round, iterations, parameters, prior_sigma, initial_damping,
         residuals] = options;
  visit(candidates_per_round, Field{.key = "candidates_per_round",
                                    .doc = "candidates fitted in each round",
                                    .range = {.least = 1, .most = 1000}});
  visit(iterations, Field{.key = "iterations",
                          .doc = "iterations of Ceres for each candidate of a round",
                          .range = {.least = 0, .most = 10000}});
  visit(parameters, Field{.key = "num_parameters",
                          .doc = "free parameters: 2 scales, 7 column scales, or all 39 entries; 1 "
                                 "scale of bend or 3 of its rows, with stretch as the initial "
                                 "guess has it"});
  visit(prior_sigma, Field{.key = "prior_sigma",
                           .doc = "standard deviation of each log factor about its initial guess",
                           .range = {.least = 1e-9, .most = 1e4}});
  visit(initial_damping, Field{.key = "initial_damping",
                               .range = {.least = 0, .above_least = true},
                               .is_option = false});
  VisitFields(residuals, visit);
  VisitFields(grid, visit);
}

// How an initial guess becomes a drape.
SettleOptions MakeSettleOptions(const StagedFitOptions& options);

// One material with its drapes, each on a branch of its own: one start of the multi-start.
struct FitCandidate {
  InitialGuess guess;
  // The tables that its log factors are on, and about which its prior is: those of the guess, or of
  // a fit by a simpler model. Empty before the guess is settled.
  MaterialField base;
  bool is_carried = false;              // it began with the fit of the part before
  std::vector<bool> mirrored;           // of each observation: seen on the cloth's mirror image
  double guess_rms = 0.0;               // of the guess's settled drapes on the fine cloth [px]
  Eigen::VectorXd theta;                // log factors on `base`, shape [P]
  std::vector<Eigen::VectorXd> shapes;  // the fitted drape of each observation [m], shape [3V]
  double cost = 0.0;                    // ½ Σ residual², prior included
  double profile_rms = 0.0;             // over all observations, in MisfitUnit
  FitTermination termination = FitTermination::kFailed;
  int iterations = 0;
  bool done = false;  // in this round
  bool valid() const { return !shapes.empty(); }
};

// The start tables of a problem, the first of them first.
std::vector<MaterialField> ListStartTables(const FitProblem& problem);
// The scaled tables of a guess. tables: ListStartTables, in the form of a model.
MaterialField GuessTables(const std::vector<MaterialField>& tables, const InitialGuess& guess);

// The observations as a candidate's drapes are laid to them.
std::vector<Observation> LaidObservations(const FitProblem& problem, const FitCandidate& candidate);

// The experiment that is searched; nullptr where images are fitted.
const Experiment* FindExperiment(const FitProblem& problem);
// Whether what is fitted explains several branches about as well: images that start from a pool,
// and an experiment that is seen by its contours alone [METHODS, P78].
bool LeavesBranchOpen(const FitProblem& problem);
// Whether an experiment sees a cloth over a support, which has many drapes at rest.
bool SeesClothOverSupport(const FitProblem& problem);
// The problem for intervals: all its experiments are (ForIntervals).
FitProblem ForIntervals(FitProblem problem);
// The unit of misfits: px of outlines, sigma of experiments.
const char* MisfitUnit(const FitProblem& problem);
// Blocks beside the observations: strips, then further experiments.
std::vector<RolloutBlock> FurtherBlocks(const FitProblem& problem, const std::atomic<bool>* cancel);
// The further experiments under one table, a block each, evaluated. fitted: outlives the result.
RolloutResiduals EvaluateFurther(FitProblem problem, const TableParametrisation& fitted,
                                 const std::atomic<bool>* cancel);

// The tables of a candidate.
MaterialField FittedMaterial(const StagedFitOptions& options, const FitCandidate& candidate);

// The result of one part of a nested fit.
struct PartResult {
  int part = 0;
  bool began_carried = false;        // FitCandidate::is_carried
  double cost = 0.0;                 // ½ Σ residual², prior included
  double profile_rms = 0.0;          // over all observations [px]
  double stretch = 0.0, bend = 0.0;  // EffectiveStretch [N/m], EffectiveBend [N m]
};

// A staged fit, or a nested one, between two units of work. Saved and read back, the fit continues
// to the identical result.
struct StagedFitState {
  // A nested fit: the parts that are done, their results where they have some, and the best
  // candidate of the part before as a start of this one.
  int parts_done = 0;
  std::vector<PartResult> part_results;
  std::optional<FitCandidate> carried;
  TriedGuesses tried;  // by the grid; empty once it is done
  bool grid_done = false;
  // The candidates of this round. The first round has more than are wanted, since some guesses have
  // no stable drape or the same drape as another.
  std::vector<FitCandidate> candidates;
  // Where LeavesBranchOpen, the tables that the first round has fitted and whose misfit is at most
  // twice the least: what branches say of the fabric.
  std::vector<MaterialField> first_fits;
  int round = 0;
  int iterations = 0;
  RolloutCounts counts;
  double grid_seconds = 0.0;
  double fit_seconds = 0.0;
};

// The notes of progress are the stage and the best misfit so far: "round 1, best 1.23 px". All
// functions are called on the thread of RunStagedFit, in an order that does not depend on timing.
struct StagedFitControl : RunControl {
  std::function<void(const StagedFitState&)> save = {};  // after each unit of work
};

// The work that a staged fit is expected to take, for the progress line: in time steps of the fine
// cloth, one after the other.
struct FitWork {
  double initial_guesses = 0.0;
  std::vector<double> rounds;  // shape [rounds]

  double total() const;
};

// Rollouts that run on several threads count once; rounds count the iterations that fits usually
// take, not those that they may take.
FitWork ExpectFitWork(const FitProblem& problem, const StagedFitOptions& options);

// The time of a step of a cloth, by that of one of another number of vertices.
double ExpectStepTime(int vertices, int of_vertices);

// The share of an optimisation that its first iterations are, where it usually takes some `usual`
// of them, which is not known before: 0 … 1.
double IterationShare(int iterations, double usual);

// The protocol [METHODS, P18] for one material and its images. Many drapes are stable and the trust
// region stays in its basin. So a grid of stretch × bend factors × start shapes on a coarse cloth
// is ranked by outline, and the best guesses are settled on the fine cloth and fitted by Ceres in
// rounds: each round keeps the best candidates of the one before and spends more iterations on
// them. The second round first tries the initial guesses again with the material fitted so far, and
// takes those that come nearer to their images. The candidates of a round are fitted side by side,
// so their rollouts make batches (RunBatched); neither results nor the order of calls depend on
// that.

// Runs from `state` to the end or until it is cancelled, and returns the state then. Its best
// candidate (Best) is the fit; after a cancel it is the best so far.
StagedFitState RunStagedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control);

// The number of candidates of the present round that are done.
int DoneCandidates(const StagedFitState& state);

// The valid candidate of least cost, or nullptr.
const FitCandidate* Best(const StagedFitState& state);

}  // namespace drape
