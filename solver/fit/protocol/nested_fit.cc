// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/nested_fit.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {
namespace {

constexpr TableModel kChain[] = {{TableForm::kIsotropic, ParameterTying::kScales},
                                 {TableForm::kLinear, ParameterTying::kColumns},
                                 {TableForm::kGiven, ParameterTying::kColumns},
                                 {TableForm::kGiven, ParameterTying::kEntries}};

int CountNumbers(ParameterTying parameters) {
  return static_cast<int>(TyingMatrix(parameters).cols());
}

// A fit by one model as a start of another: without its part of the prior, which is about its own
// tables from here on.
FitCandidate AsStart(const FitCandidate& fit, const StagedFitOptions& options,
                     ParameterTying next) {
  FitCandidate start = fit;
  start.base = FittedMaterial(options, fit);
  start.cost -= 0.5 * (fit.theta / options.prior_sigma).squaredNorm();
  start.theta = Eigen::VectorXd::Zero(CountNumbers(next));
  start.from_simpler = true;
  start.done = false;
  return start;
}

class NestedFitter {
 public:
  NestedFitter(const FitProblem& problem, const StagedFitOptions& options,
               const StagedFitControl& control)
      : problem_(problem), options_(options), control_(control) {}

  StagedFitState Run(StagedFitState state) const {
    while (state.models_done < num_simpler()) {
      state = RunModel(std::move(state));
      if (control_.cancelled()) return BestSoFar(std::move(state));
      state = Continue(std::move(state));
      if (control_.save) control_.save(state);
    }
    return RunStagedFit(problem_, options_, std::move(state), Part(num_simpler(), ""));
  }

 private:
  int num_simpler() const { return static_cast<int>(problem_.simpler_models.size()); }

  StagedFitOptions OptionsFor(const StagedFitState& state) const {
    StagedFitOptions options = options_;
    options.parameters = FittedParameters(problem_, options_, state);
    return options;
  }

  StagedFitState RunModel(StagedFitState state) const {
    FitProblem problem = problem_;
    problem.other_materials = ListModelTables(problem_, state);
    problem.material = problem.other_materials.front();
    problem.other_materials.erase(problem.other_materials.begin());
    const StagedFitOptions options = OptionsFor(state);
    const std::string name = NameFor(problem_.simpler_models[state.models_done]);
    const StagedFitControl part = Part(state.models_done, name + ", ");
    return RunStagedFit(problem, options, std::move(state), part);
  }

  // Reports one of the models as its share of the whole, under its name.
  StagedFitControl Part(int number, const std::string& name) const {
    StagedFitControl part;
    part.cancel = control_.cancel;
    part.save = control_.save;
    part.log = [this, name](const std::string& line) { control_.Log(name + line); };
    part.progress = [this, number, name](double fraction, const std::string& note) {
      control_.Report((number + fraction) / (num_simpler() + 1), name + note);
    };
    return part;
  }

  // The state in which the next model begins.
  StagedFitState Continue(StagedFitState done) const {
    const StagedFitOptions options = OptionsFor(done);
    const FitCandidate* best = Best(done);
    StagedFitState next;
    next.models_done = done.models_done + 1;
    next.simpler_results = std::move(done.simpler_results);
    const ParameterTying parameters = FittedParameters(problem_, options_, next);
    if (best != nullptr) {
      next.simpler_results.push_back({done.models_done, best->cost, best->profile_rms});
      next.simpler = AsStart(*best, options, parameters);
    } else if (done.simpler) {
      next.simpler = AsStart(*done.simpler, options, parameters);
    }
    next.iterations = done.iterations;
    next.counts = done.counts;
    next.grid_seconds = done.grid_seconds;
    next.fit_seconds = done.fit_seconds;
    return next;
  }

  // The candidates of a state whose simpler model was cancelled are of that model.
  StagedFitState BestSoFar(StagedFitState state) const {
    StagedFitState last = Continue(std::move(state));
    if (last.simpler) {
      last.simpler->theta = Eigen::VectorXd::Zero(CountNumbers(options_.parameters));
      last.candidates = {*last.simpler};
    }
    return last;
  }

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  const StagedFitControl& control_;
};

}  // namespace

std::vector<TableModel> SimplerModels(const TableModel& model) {
  const auto* const own =
      std::find_if(std::begin(kChain), std::end(kChain), [&](const TableModel& each) {
        return each.form == model.form && each.parameters == model.parameters;
      });
  if (own == std::end(kChain)) return {};
  return {std::begin(kChain), own};
}

std::string NameFor(const TableModel& model) {
  const std::string form =
      model.form == TableForm::kGiven ? "nonlinear" : std::string(ToString(model.form));
  return form + Format(", %d numbers", CountNumbers(model.parameters));
}

ParameterTying FittedParameters(const FitProblem& problem, const StagedFitOptions& options,
                                const StagedFitState& state) {
  const auto model = static_cast<std::size_t>(state.models_done);
  return model < problem.simpler_models.size() ? problem.simpler_models[model].parameters
                                               : options.parameters;
}

std::vector<MaterialField> ListModelTables(const FitProblem& problem, const StagedFitState& state) {
  std::vector<MaterialField> tables = ListStartTables(problem);
  const auto model = static_cast<std::size_t>(state.models_done);
  if (model < problem.simpler_models.size())
    for (MaterialField& table : tables)
      table = InForm(std::move(table), problem.simpler_models[model].form);
  return tables;
}

StagedFitState RunNestedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control) {
  return NestedFitter(problem, options, control).Run(std::move(state));
}

}  // namespace drape
