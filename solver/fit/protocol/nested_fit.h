// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/fit/protocol/fit_types.h"

namespace drape {

// Models of one table contain one another [METHODS, P18]: isotropic (2 numbers) ⊂ linear (7) ⊂
// nonlinear tables with a factor on each column (7) ⊂ all 39 entries. A fit by a model that starts
// also from the fit by the model that it contains cannot have a higher cost.

// The models of that chain that `model` contains, from the simplest on; none for a model that is
// not of it, such as one that leaves stretch as it is.
std::vector<TableModel> SimplerModels(const TableModel& model);

// "isotropic, 2 numbers".
std::string NameFor(const TableModel& model);

// RunStagedFit for each of problem.simpler_models in turn, then for the problem's own with
// options.parameters. The best candidate of a model is a further one of the first round of the next
// model, with its tables as base, about which the prior of that candidate is. Continues from
// `state`; returns the state of the last model, after a cancel with the best so far as its only
// candidate where that is by a simpler model.
StagedFitState RunNestedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control);

// The numbers of a candidate of the model that a state is at.
ParameterTying FittedParameters(const FitProblem& problem, const StagedFitOptions& options,
                                const StagedFitState& state);
// The start tables of that model, in its form.
std::vector<MaterialField> ListModelTables(const FitProblem& problem, const StagedFitState& state);

}  // namespace drape
