// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/fit_checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/protocol/candidate_check.h"
#include "solver/fit/protocol/nested_fit.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr int kMostCounted = 1'000'000'000;
constexpr double kMostSeconds = 1e9;

json ToJson(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

// The 39 entries.
json ToJson(const MaterialField& tables) {
  std::vector<double> entries(tables.stretch[0].entries(),
                              tables.stretch[0].entries() + kStretchEntries);
  entries.insert(entries.end(), tables.bend[0].entries(), tables.bend[0].entries() + kBendEntries);
  return entries;
}

json ToJson(const InitialGuess& guess) {
  return {{"table", guess.table},
          {"stretch", guess.stretch},
          {"bend", guess.bend},
          {"lifts", guess.lifts},
          {"coarse_rms", guess.profile_rms}};
}

json ToJson(const TriedGuesses& tried) {
  json scales = json::array();
  for (const std::vector<InitialGuess>& guesses : tried) {
    scales.push_back(json::array());
    for (const InitialGuess& guess : guesses) scales.back().push_back(ToJson(guess));
  }
  return scales;
}

json ToJson(const FitCandidate& candidate) {
  json shapes = json::array();
  for (const Eigen::VectorXd& x : candidate.shapes) shapes.push_back(ToJson(x));
  return {{"guess", ToJson(candidate.guess)},
          {"is_carried", candidate.is_carried},
          {"base", candidate.is_carried ? ToJson(candidate.base) : json::array()},
          {"guess_rms", candidate.guess_rms},
          {"theta", ToJson(candidate.theta)},
          {"shapes", shapes},
          {"cost", candidate.cost},
          {"profile_rms", candidate.profile_rms},
          {"termination", static_cast<int>(candidate.termination)},
          {"iterations", candidate.iterations},
          {"done", candidate.done}};
}

int Count(const JsonInput& input) { return input.IntegerWithin(0, kMostCounted); }

bool Contains(const std::vector<double>& values, double value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

// What a checkpoint of a fit can hold.
class StateReader {
 public:
  // References outlive the object.
  StateReader(const FitProblem& problem, const StagedFitOptions& options)
      : whole_(problem), whole_options_(options), grid_(SearchedGrid(options)) {}

  StagedFitState Read(const JsonInput& input) {
    input.ExpectKeys({"job", "parts_done", "part_results", "carried", "tried", "grid_done", "round",
                      "iterations", "counts", "seconds", "candidates"});
    StagedFitState state;
    ReadPartsBefore(input, &state);
    state.tried = ReadTried(input.At("tried"));
    state.grid_done = input.At("grid_done").Boolean();
    state.round = input.At("round").IntegerWithin(0, rounds());
    state.iterations = Count(input.At("iterations"));
    const JsonInput counts = input.At("counts").ExpectArray(5);
    state.counts = {Count(counts.At(0)), Count(counts.At(1)), Count(counts.At(2)),
                    Count(counts.At(3)), Count(counts.At(4))};
    const JsonInput seconds = input.At("seconds").ExpectArray(2);
    state.grid_seconds = seconds.At(0).NumberWithin(0.0, kMostSeconds);
    state.fit_seconds = seconds.At(1).NumberWithin(0.0, kMostSeconds);
    const JsonInput candidates = input.At("candidates").ExpectArray();
    const int most = MostCandidates(state.round) + (state.round < 2 && state.carried ? 1 : 0);
    if (candidates.Size() > most) candidates.Fail("at most " + std::to_string(most));
    for (int i = 0; i < candidates.Size(); ++i)
      state.candidates.push_back(ReadCandidate(candidates.At(i)));
    CheckProgress(state, input);
    return state;
  }

 private:
  int rounds() const { return static_cast<int>(options_.candidates_per_round.size()); }
  int num_observations() const { return static_cast<int>(problem_.observations.size()); }
  // The guesses of the grid, which the first round leaves behind; then those of the round before.
  int MostCandidates(int round) const {
    return round < 2 ? kSpareGuesses * options_.candidates_per_round.front()
                     : options_.candidates_per_round[round - 1];
  }

  int num_tables() const { return 1 + static_cast<int>(problem_.other_materials.size()); }

  // What the parts before left; problem_ and options_ are those of the present part then.
  void ReadPartsBefore(const JsonInput& input, StagedFitState* state) {
    state->parts_done = input.At("parts_done").IntegerWithin(0, CountParts(whole_) - 1);
    problem_ = PartProblem(whole_, state->parts_done);
    options_ = PartOptions(whole_, whole_options_, state->parts_done);
    tables_ = ListStartTables(problem_);
    const JsonInput results = input.At("part_results").ExpectArray();
    if (results.Size() > state->parts_done) results.Fail("at most one for each part that is done");
    for (int i = 0; i < results.Size(); ++i)
      state->part_results.push_back(ReadPartResult(results.At(i), i, state->parts_done));
    may_be_carried_ = state->parts_done > 0;
    const JsonInput carried = input.At("carried");
    if (carried.value().is_null()) return;
    state->carried = ReadCandidate(carried);
    if (state->parts_done == 0 || !state->carried->valid() || !state->carried->is_carried)
      carried.Fail("the fit of the part before, or null");
  }

  // at: its place in the list.
  static PartResult ReadPartResult(const JsonInput& input, int at, int parts_done) {
    input.ExpectKeys({"part", "began_carried", "cost", "profile_rms", "stretch", "bend"});
    return {.part = input.At("part").IntegerWithin(at, parts_done - 1),
            .began_carried = input.At("began_carried").Boolean(),
            .cost = input.At("cost").NotNegative(),
            .profile_rms = input.At("profile_rms").NotNegative(),
            .stretch = input.At("stretch").NotNegative(),
            .bend = input.At("bend").NotNegative()};
  }

  TriedGuesses ReadTried(const JsonInput& input) const {
    if (input.ExpectArray().Size() > num_tables() * grid_.num_scales())
      input.Fail("at most " + std::to_string(num_tables() * grid_.num_scales()) +
                 ", the scales of the grid");
    TriedGuesses tried(input.Size());
    for (int i = 0; i < input.Size(); ++i) {
      const JsonInput guesses = input.At(i).ExpectArray();
      if (guesses.Size() > static_cast<int>(grid_.lifts.size())) guesses.Fail("one for each lift");
      for (int j = 0; j < guesses.Size(); ++j) {
        tried[i].push_back(ReadGuess(guesses.At(j)));
        const int scale = i % grid_.num_scales();
        if (tried[i][j].table != i / grid_.num_scales() ||
            tried[i][j].stretch != grid_.stretch[scale / grid_.bend.size()] ||
            tried[i][j].bend != grid_.bend[scale % grid_.bend.size()])
          guesses.At(j).Fail("a guess of scale " + std::to_string(i) + " of the grid");
      }
    }
    return tried;
  }

  InitialGuess ReadGuess(const JsonInput& input) const {
    input.ExpectKeys({"table", "stretch", "bend", "lifts", "coarse_rms"});
    const auto of_grid = [&](const JsonInput& number, const std::vector<double>& values) {
      if (!Contains(values, number.Number())) number.Fail("one of the initial guesses of this fit");
      return number.Number();
    };
    InitialGuess guess;
    guess.table = input.At("table").IntegerWithin(0, num_tables() - 1);
    guess.stretch = of_grid(input.At("stretch"), grid_.stretch);
    guess.bend = of_grid(input.At("bend"), grid_.bend);
    const JsonInput lifts = input.At("lifts").ExpectArray(num_observations());
    for (int i = 0; i < lifts.Size(); ++i) guess.lifts.push_back(of_grid(lifts.At(i), grid_.lifts));
    guess.profile_rms = input.At("coarse_rms").NotNegative();
    return guess;
  }

  MaterialField ReadBase(const JsonInput& input) const {
    const Eigen::VectorXd entries = input.Vector(kMaterialEntries);
    MaterialField base{problem_.material.density, {StretchTable()}, {BendTable()}};
    std::copy_n(entries.data(), kStretchEntries, base.stretch[0].entries());
    std::copy_n(entries.data() + kStretchEntries, kBendEntries, base.bend[0].entries());
    return base;
  }

  FitCandidate ReadCandidate(const JsonInput& input) const {
    input.ExpectKeys({"guess", "is_carried", "base", "guess_rms", "theta", "shapes", "cost",
                      "profile_rms", "termination", "iterations", "done"});
    FitCandidate candidate;
    candidate.guess = ReadGuess(input.At("guess"));
    candidate.guess_rms = input.At("guess_rms").NotNegative();
    const JsonInput shapes = input.At("shapes");
    if (shapes.ExpectArray().Size() > 0) shapes.ExpectArray(num_observations());
    for (int i = 0; i < shapes.Size(); ++i)
      candidate.shapes.push_back(shapes.At(i).Vector(problem_.fine->model().num_dofs()));
    const JsonInput theta = input.At("theta");
    if (candidate.valid() || theta.ExpectArray().Size() > 0)
      candidate.theta = theta.Vector(static_cast<int>(TyingMatrix(options_.parameters).cols()));
    candidate.is_carried = input.At("is_carried").Boolean();
    if (candidate.is_carried && !may_be_carried_)
      input.At("is_carried").Fail("false, since there is no part before");
    if (candidate.is_carried) {
      candidate.base = ReadBase(input.At("base"));
    } else {
      input.At("base").ExpectArray(0);
      if (candidate.theta.size() > 0)  // it has been settled
        candidate.base = GuessTables(tables_, candidate.guess);
    }
    candidate.cost = input.At("cost").NotNegative();
    candidate.profile_rms = input.At("profile_rms").NotNegative();
    candidate.termination = ReadTermination(input.At("termination"), candidate.valid());
    candidate.iterations = Count(input.At("iterations"));
    candidate.done = input.At("done").Boolean();
    if (candidate.valid()) {
      CheckCandidate(problem_, options_, candidate, input.Name());
    } else if (!candidate.theta.isZero(0.0) || candidate.cost != 0 || candidate.profile_rms != 0) {
      shapes.Fail("the drapes that cost, profile_rms and theta are of");
    }
    return candidate;
  }

  // A candidate that was cancelled is not saved.
  static FitTermination ReadTermination(const JsonInput& input, bool valid) {
    const auto last = static_cast<int>(FitTermination::kFailed);
    const auto termination = static_cast<FitTermination>(input.IntegerWithin(0, last));
    if (termination == FitTermination::kCancelled ||
        (termination == FitTermination::kFailed) == valid)
      input.Fail(valid ? "how a fit ended that has shapes" : "a failed fit, without shapes");
    return termination;
  }

  // A part on a finer mesh has candidates of the mesh before, and a result of it, alone.
  static void CheckCarried(const StagedFitState& state, const JsonInput& input) {
    if (!state.grid_done) input.At("grid_done").Fail("true on a finer mesh");
    if (state.carried) input.At("carried").Fail("null on a finer mesh");
    if (state.part_results.empty() || state.part_results.back().part != state.parts_done - 1)
      input.At("part_results").Fail("the result on the mesh before");
    for (std::size_t i = 0; i < state.candidates.size(); ++i)
      if (!state.candidates[i].is_carried)
        input.At("candidates").At(int(i)).At("is_carried").Fail("true on a finer mesh");
  }

  // Whether a fit can be there, so that going on ends.
  void CheckProgress(const StagedFitState& state, const JsonInput& input) const {
    if (IsOnFinerMesh(whole_, state.parts_done)) CheckCarried(state, input);
    const int count = static_cast<int>(state.candidates.size()), done = DoneCandidates(state);
    if (!state.grid_done && (state.round > 0 || count > 0))
      input.At("grid_done").Fail("true, since there are candidates or a round has ended");
    if (state.grid_done && !state.tried.empty())
      input.At("tried").Fail("no guesses, since the grid is done");
    if (state.round > 0 && count == 0) input.At("candidates").Fail("those of the round before");
    if (done == 0) return;
    if (state.round == rounds() || done == count ||
        SucceededCandidates(state) >= CountWanted(options_, state))
      input.At("candidates").Fail("candidates of which some of this round are still to be fitted");
    for (int i = 0; i < count; ++i) {
      const FitCandidate& candidate = state.candidates[i];
      const JsonInput shapes = input.At("candidates").At(i).At("shapes");
      if (state.round > 0 && !candidate.valid()) shapes.Fail("a drape of each image");
      if (state.round == 0 && !candidate.done && candidate.valid() && !candidate.is_carried)
        shapes.Fail("no drapes, since its first fit is not done");
    }
  }

  const FitProblem& whole_;
  const StagedFitOptions& whole_options_;
  const InitialGuessOptions grid_;
  FitProblem problem_;  // of the present part, as what follows
  StagedFitOptions options_;
  std::vector<MaterialField> tables_;  // of the guesses
  bool may_be_carried_ = false;        // there is a part before
};

// The first name in which two keys differ; empty when they are the same.
std::string FirstDifference(const std::string& saved, const std::string& present) {
  if (saved == present) return "";
  const json a = json::parse(saved, nullptr, false), b = json::parse(present, nullptr, false);
  if (a.is_object() && b.is_object()) {
    for (const auto& [key, value] : b.items())
      if (!a.contains(key) || a[key] != value) return key;
    for (const auto& [key, value] : a.items())
      if (!b.contains(key)) return key;
  }
  return "job";
}

}  // namespace

void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state) {
  json candidates = json::array();
  for (const FitCandidate& candidate : state.candidates) candidates.push_back(ToJson(candidate));
  json results = json::array();
  for (const PartResult& result : state.part_results)
    results.push_back({{"part", result.part},
                       {"began_carried", result.began_carried},
                       {"cost", result.cost},
                       {"profile_rms", result.profile_rms},
                       {"stretch", result.stretch},
                       {"bend", result.bend}});
  WriteStoredJson(path, kCheckpointFormat,
                  {{"job", key},
                   {"parts_done", state.parts_done},
                   {"part_results", results},
                   {"carried", state.carried ? ToJson(*state.carried) : json()},
                   {"tried", ToJson(state.tried)},
                   {"grid_done", state.grid_done},
                   {"round", state.round},
                   {"iterations", state.iterations},
                   {"counts",
                    {state.counts.rollouts, state.counts.tangents, state.counts.failed,
                     state.counts.jumps, state.counts.capped}},
                   {"seconds", {state.grid_seconds, state.fit_seconds}},
                   {"candidates", candidates}});
}

std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key,
                                             const FitProblem& problem,
                                             const StagedFitOptions& options) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json document = ReadStoredJson(path, kCheckpointFormat);
  const JsonInput input(document, path);
  if (const std::string name = FirstDifference(input.At("job").String(), key); !name.empty())
    throw InputError(path, "found another '" + name +
                               "', expected the present one: run without --resume, or undo the "
                               "change");
  return StateReader(problem, options).Read(input);
}

}  // namespace drape
