// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/nested_fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include "physics/material/material_scaling.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

constexpr TableModel kChain[] = {{TableForm::kIsotropic, ParameterTying::kScales},
                                 {TableForm::kLinear, ParameterTying::kColumns},
                                 {TableForm::kGiven, ParameterTying::kColumns},
                                 {TableForm::kGiven, ParameterTying::kEntries}};

int CountNumbers(ParameterTying parameters) {
  return static_cast<int>(TyingMatrix(parameters).cols());
}

// The time of a part on a finer mesh, without a grid, by that of one that searches on a mesh of as
// many vertices: .5 by two numbers, 1.3 by 39.
constexpr double kFinerShare = 0.8;
// Candidates that continue on a finer mesh, where another branch may be the best.
constexpr int kCarried = 3;
constexpr int kCarriedSideBySide = 8;

int CountSimpler(const FitProblem& problem) {
  return static_cast<int>(problem.simpler_models.size());
}

// Whether a part continues the candidates of the one before on a mesh of more vertices.
bool IsOnFinerMesh(const FitProblem& problem, int part) { return part > CountSimpler(problem); }

Backend* MeshOfPart(const FitProblem& problem, int part) {
  const std::size_t level = std::max(0, part - CountSimpler(problem));
  return level < problem.search.size() ? problem.search[level] : problem.fine;
}

int CountVertices(const FitProblem& problem, int part) {
  return MeshOfPart(problem, part)->model().mesh.num_vertices();
}

std::string PartName(const FitProblem& problem, int part) {
  std::string name;
  if (part < CountSimpler(problem)) name = NameFor(problem.simpler_models[part]) + ", ";
  if (IsOnFinerMesh(problem, part)) name = Format("%d vertices, ", CountVertices(problem, part));
  return name;
}

// The time of each part by that of one that searches on the first mesh.
double ExpectTime(const FitProblem& problem, int part) {
  if (!IsOnFinerMesh(problem, part)) return 1.0;
  return kFinerShare * ExpectStepTime(CountVertices(problem, part), CountVertices(problem, 0));
}

// The parameters and rounds of a part. From a pool, the first part has the first round and the next
// one the others. A part before one on a finer mesh keeps a few candidates to its end, and that one
// has two rounds: of these, and of the best of them.
StagedFitOptions PartOptions(const FitProblem& problem, const StagedFitOptions& options, int part) {
  StagedFitOptions own = options;
  if (part < CountSimpler(problem)) own.parameters = problem.simpler_models[part].parameters;
  if (problem.is_pooled && CountSimpler(problem) > 0 && options.iterations.size() > 1) {
    for (std::vector<int>* rounds : {&own.candidates_per_round, &own.iterations})
      *rounds = part == 0 ? std::vector{rounds->front()}
                          : std::vector(rounds->begin() + 1, rounds->end());
  }
  if (problem.search.empty() || part < CountSimpler(problem)) return own;
  const int carried = std::min(kCarried, options.candidates_per_round.front());
  if (IsOnFinerMesh(problem, part)) {
    const std::size_t rounds = options.iterations.size();
    own.candidates_per_round = {carried, 1};
    own.iterations = {options.iterations[rounds - std::min<std::size_t>(2, rounds)],
                      options.iterations.back()};
  }
  if (part + 1 < CountParts(problem))
    for (int& count : own.candidates_per_round) count = std::max(count, carried);
  return own;
}

FitCandidate AsCarried(FitCandidate candidate) {
  candidate.is_carried = true;
  candidate.done = false;
  return candidate;
}

// A fit by one model as a start of another: without its part of the prior, which is about its own
// tables from here on.
FitCandidate AsStart(const FitCandidate& fit, const StagedFitOptions& options,
                     ParameterTying next) {
  FitCandidate start = AsCarried(fit);
  start.base = FittedMaterial(options, fit);
  start.cost -= 0.5 * (fit.theta / options.prior_sigma).squaredNorm();
  start.theta = Eigen::VectorXd::Zero(CountNumbers(next));
  return start;
}

class NestedFitter {
 public:
  NestedFitter(const FitProblem& problem, const StagedFitOptions& options,
               const StagedFitControl& control)
      : problem_(problem), options_(options), control_(control) {}

  StagedFitState Run(StagedFitState state) const {
    for (;;) {
      const int part = state.parts_done;
      state = RunStagedFit(PartProblem(problem_, part), PartOptions(problem_, options_, part),
                           std::move(state), ControlOfPart(part));
      if (control_.cancelled()) return BestSoFar(std::move(state));
      if (state.parts_done + 1 == CountParts(problem_)) return state;
      std::optional<StagedFitState> next = Continue(state);
      if (!next) return BestSoFar(std::move(state));
      state = *std::move(next);
      if (control_.save) control_.save(state);
    }
  }

 private:
  // Reports one of the parts as its share of the whole, under its name.
  StagedFitControl ControlOfPart(int part) const {
    double before = 0.0, whole = 0.0;
    for (int p = 0; p < CountParts(problem_); ++p) {
      if (p < part) before += ExpectTime(problem_, p);
      whole += ExpectTime(problem_, p);
    }
    const double own = ExpectTime(problem_, part);
    const std::string name = PartName(problem_, part);
    StagedFitControl control;
    control.cancel = control_.cancel;
    control.save = control_.save;
    control.log = [this, name](const std::string& line) { control_.Log(name + line); };
    control.progress = [=, this](double fraction, const std::string& note) {
      control_.Report((before + own * fraction) / whole, name + note);
    };
    return control;
  }

  // The state in which the next part begins; none where the fit ends because a finer mesh has no
  // drapes of it, or is cancelled.
  std::optional<StagedFitState> Continue(const StagedFitState& done) const {
    StagedFitState next = WithResults(done);
    const auto start_of = [&](const FitCandidate& fit) {
      return AsStart(fit, PartOptions(problem_, options_, done.parts_done),
                     PartOptions(problem_, options_, next.parts_done).parameters);
    };
    const bool is_finer = IsOnFinerMesh(problem_, next.parts_done);
    if (is_finer || problem_.is_pooled) {
      std::vector<FitCandidate> best = ListBest(done, next.parts_done);
      for (FitCandidate& each : best) each = is_finer ? AsCarried(each) : start_of(each);
      Begin(std::move(best), done, &next);
      if (control_.cancelled() || next.candidates.empty()) return std::nullopt;
      return next;
    }
    const FitCandidate* best = Best(done);
    if (best == nullptr && done.carried) best = &*done.carried;
    if (best != nullptr) next.carried = start_of(*best);
    return next;
  }

  // The candidates of a part that has ended which go on in part `next`: of a pool as many as it
  // fits, by cost.
  std::vector<FitCandidate> ListBest(const StagedFitState& done, int next) const {
    std::vector<FitCandidate> best = done.candidates;
    std::erase_if(best, [](const FitCandidate& each) { return !each.valid(); });
    if (!problem_.is_pooled) return best;
    std::stable_sort(best.begin(), best.end(),
                     [](const FitCandidate& a, const FitCandidate& b) { return a.cost < b.cost; });
    const int wanted = PartOptions(problem_, options_, next).candidates_per_round.front();
    if (int(best.size()) > wanted) best.resize(wanted);
    return best;
  }

  StagedFitState WithResults(const StagedFitState& done) const {
    StagedFitState next;
    next.parts_done = done.parts_done + 1;
    next.part_results = done.part_results;
    if (const std::optional<PartResult> result = FindResult(problem_, options_, done))
      next.part_results.push_back(*result);
    next.first_fits = done.first_fits;
    next.iterations = done.iterations;
    next.counts = done.counts;
    next.grid_seconds = done.grid_seconds;
    next.fit_seconds = done.fit_seconds;
    return next;
  }

  // Begins a part with candidates: with all that are stable on another mesh, or on the same mesh
  // with drapes that may be nearer to the images.
  void Begin(std::vector<FitCandidate> candidates, const StagedFitState& done,
             StagedFitState* next) const {
    const auto start = std::chrono::steady_clock::now();
    const FitProblem problem = PartProblem(problem_, next->parts_done);
    const StagedFitOptions options = PartOptions(problem_, options_, next->parts_done);
    const Mesh& from = MeshOfPart(problem_, done.parts_done)->model().mesh;
    std::vector<CandidateTask> tasks;
    for (FitCandidate& candidate : candidates)
      tasks.push_back({static_cast<int>(tasks.size()), std::move(candidate), 0, {}, {}});
    RunBatched(*problem.fine, static_cast<int>(tasks.size()), kCarriedSideBySide,
               [&](BatchingBackend& backend) {
                 const CandidateFitter fitter(problem, options, backend, control_.cancel, 0);
                 CandidateTask& task = tasks[backend.index()];
                 if (IsOnFinerMesh(problem_, next->parts_done))
                   fitter.CarryOver(from, task);
                 else
                   fitter.RetryGuesses(task);
               });
    if (control_.cancelled()) return;
    const std::string name = PartName(problem_, next->parts_done);
    for (CandidateTask& task : tasks) {
      for (const std::string& line : task.log) control_.Log(name + line);
      next->counts += task.counts;
      if (task.candidate.valid()) next->candidates.push_back(std::move(task.candidate));
    }
    next->grid_done = true;
    next->fit_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  // A cancelled state of a simpler model as one of the problem's own.
  StagedFitState BestSoFar(StagedFitState state) const {
    if (state.parts_done >= CountSimpler(problem_)) return state;
    const FitCandidate* best = Best(state);
    if (best == nullptr && state.carried) best = &*state.carried;
    StagedFitState last = WithResults(state);
    last.parts_done = CountSimpler(problem_);
    if (best != nullptr)
      last.candidates = {
          AsStart(*best, PartOptions(problem_, options_, state.parts_done), options_.parameters)};
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

int CountParts(const FitProblem& problem) {
  return CountSimpler(problem) + 1 + static_cast<int>(problem.search.size());
}

FitProblem PartProblem(const FitProblem& problem, int part) {
  FitProblem own = problem;
  own.fine = MeshOfPart(problem, part);
  own.search.clear();
  own.simpler_models.clear();
  // Strips and motions alone are fitted once, by the given model.
  if (part >= CountSimpler(problem) || problem.observations.empty()) return own;
  const TableForm form = problem.simpler_models[part].form;
  own.material = InForm(own.material, form);
  for (MaterialField& other : own.other_materials) other = InForm(other, form);
  return own;
}

std::optional<PartResult> FindResult(const FitProblem& problem, const StagedFitOptions& options,
                                     const StagedFitState& state) {
  const FitCandidate* best = Best(state);
  if (best == nullptr) return std::nullopt;
  const int part = state.parts_done;
  const MaterialField fitted = FittedMaterial(PartOptions(problem, options, part), *best);
  const Eigen::VectorXd weights =
      StiffnessWeights(MeshOfPart(problem, part)->model(), best->shapes);
  return PartResult{.part = part,
                    .began_carried = best->is_carried,
                    .cost = best->cost,
                    .profile_rms = best->profile_rms,
                    .stretch = EffectiveStretch(fitted, weights),
                    .bend = EffectiveBend(fitted, weights)};
}

std::optional<MeshError> EstimateMeshError(const FitProblem& problem,
                                           const StagedFitOptions& options,
                                           const StagedFitState& state) {
  const std::optional<PartResult> last = FindResult(problem, options, state);
  if (!last || !IsOnFinerMesh(problem, last->part)) return std::nullopt;
  // A part on a finer mesh begins with a result of the part before.
  const PartResult& before = state.part_results.back();
  const double growth =
      double(CountVertices(problem, last->part)) / CountVertices(problem, before.part);
  return MeshError{.log_stretch = std::log(last->stretch / before.stretch) / (growth - 1),
                   .log_bend = std::log(last->bend / before.bend) / (growth - 1)};
}

StagedFitState RunNestedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control) {
  return NestedFitter(problem, options, control).Run(std::move(state));
}

}  // namespace drape
