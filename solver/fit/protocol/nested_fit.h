// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A fit in parts, each a staged fit that starts also from the best of the part before.
//
// First by models of one table that contain one another [METHODS, P18]: isotropic (2 numbers) ⊂
// linear (7) ⊂ nonlinear tables with a factor on each column (7) ⊂ all 39 entries. A fit that
// starts also from the fit by the model that it contains cannot have a higher cost.
// Then, by the last of them, on finer and finer meshes [METHODS, P18]: the branch is found on a
// coarse mesh, where that is cheap, and the numbers on a fine one.

// The models of that chain that `model` contains, from the simplest on; none for a model that is
// not of it, such as one that leaves stretch as it is.
std::vector<TableModel> SimplerModels(const TableModel& model);

// "isotropic, 2 numbers".
std::string NameFor(const TableModel& model);

// The parts of a problem: its simpler_models on the first of its meshes (`search`, then `fine`),
// its own model on that mesh, then on each of the others.
int CountParts(const FitProblem& problem);
// One of them: its mesh is `fine`, its start tables have the form of its model.
FitProblem PartProblem(const FitProblem& problem, int part);
// Runs all parts from `state` on; returns the state of the last of them. A part begins with the
// best candidate of the part before: a simpler model's tables become its base, about which its
// prior is; on a finer mesh the same candidate continues, its drapes settled there. Where they
// are not stable there, the fit ends with the part before. After a cancel, the best so far is the
// only candidate where that is by a simpler model.
StagedFitState RunNestedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control);

// The result of the best candidate of the part that a state is at; nothing without a candidate.
std::optional<PartResult> FindResult(const FitProblem& problem, const StagedFitOptions& options,
                                     const StagedFitState& state);

// How far the fitted stiffness is from that on an infinitely fine mesh, ln(limit/fitted), by the
// last two meshes: the error is in proportion to 1/V [METHODS, P18]. It contains what else changed
// between the two fits too.
struct MeshError {
  double log_stretch = 0.0, log_bend = 0.0;
};
// Returns nothing for a fit on one mesh, or without a result.
std::optional<MeshError> EstimateMeshError(const FitProblem& problem,
                                           const StagedFitOptions& options,
                                           const StagedFitState& state);

}  // namespace drape
