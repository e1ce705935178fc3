// SPDX-License-Identifier: Apache-2.0
// A checkpoint is read back to the last bit, or refused.
#include "solver/fit/protocol/fit_checkpoint.h"

#include <algorithm>
#include <limits>

#include "physics/util/atomic_file.h"
#include "solver/fit/protocol/nested_fit.h"
#include "tests/losses/temp_folder.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/util/stored/tampering.h"
#include "tests/solver/fake_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

using nlohmann::json;

void ExpectSame(const InitialGuess& a, const InitialGuess& b) {
  EXPECT_EQ(a.table, b.table);
  EXPECT_EQ(a.stretch, b.stretch);
  EXPECT_EQ(a.bend, b.bend);
  EXPECT_EQ(a.lifts, b.lifts);
  EXPECT_EQ(a.profile_rms, b.profile_rms);
}

void ExpectSame(const MaterialField& a, const MaterialField& b) {
  ASSERT_EQ(a.stretch.size(), b.stretch.size());
  ASSERT_EQ(a.bend.size(), b.bend.size());
  if (a.stretch.empty()) return;
  EXPECT_EQ(a.density, b.density);
  for (int k = 0; k < kStretchEntries; ++k)
    EXPECT_EQ(a.stretch[0].entries()[k], b.stretch[0].entries()[k]);
  for (int k = 0; k < kBendEntries; ++k) EXPECT_EQ(a.bend[0].entries()[k], b.bend[0].entries()[k]);
}

void ExpectSame(const FitCandidate& a, const FitCandidate& b) {
  ExpectSame(a.guess, b.guess);
  ExpectSame(a.base, b.base);
  EXPECT_EQ(a.is_carried, b.is_carried);
  EXPECT_EQ(a.guess_rms, b.guess_rms);
  EXPECT_EQ(a.theta, b.theta);
  EXPECT_EQ(a.shapes, b.shapes);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.profile_rms, b.profile_rms);
  EXPECT_EQ(a.termination, b.termination);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.done, b.done);
}

void ExpectSame(const StagedFitState& a, const StagedFitState& b) {
  EXPECT_EQ(a.parts_done, b.parts_done);
  ASSERT_EQ(a.part_results.size(), b.part_results.size());
  for (std::size_t i = 0; i < a.part_results.size(); ++i) {
    EXPECT_EQ(a.part_results[i].part, b.part_results[i].part);
    EXPECT_EQ(a.part_results[i].began_carried, b.part_results[i].began_carried);
    EXPECT_EQ(a.part_results[i].cost, b.part_results[i].cost);
    EXPECT_EQ(a.part_results[i].profile_rms, b.part_results[i].profile_rms);
    EXPECT_EQ(a.part_results[i].stretch, b.part_results[i].stretch);
    EXPECT_EQ(a.part_results[i].bend, b.part_results[i].bend);
  }
  ASSERT_EQ(a.carried.has_value(), b.carried.has_value());
  if (a.carried) ExpectSame(*a.carried, *b.carried);
  EXPECT_EQ(a.grid_done, b.grid_done);
  EXPECT_EQ(a.round, b.round);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.counts.rollouts, b.counts.rollouts);
  EXPECT_EQ(a.counts.tangents, b.counts.tangents);
  EXPECT_EQ(a.counts.failed, b.counts.failed);
  EXPECT_EQ(a.counts.jumps, b.counts.jumps);
  EXPECT_EQ(a.counts.capped, b.counts.capped);
  EXPECT_EQ(a.grid_seconds, b.grid_seconds);
  EXPECT_EQ(a.fit_seconds, b.fit_seconds);
  ASSERT_EQ(a.tried.size(), b.tried.size());
  for (std::size_t i = 0; i < a.tried.size(); ++i) {
    ASSERT_EQ(a.tried[i].size(), b.tried[i].size());
    for (std::size_t j = 0; j < a.tried[i].size(); ++j) ExpectSame(a.tried[i][j], b.tried[i][j]);
  }
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  for (std::size_t i = 0; i < a.candidates.size(); ++i)
    ExpectSame(a.candidates[i], b.candidates[i]);
}

// Without physics, so that fits and resumed fits cost little.
class CheckpointTest : public FileFixture {
 protected:
  CheckpointTest() {
    control_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
    whole_ = RunStagedFit(fit_.problem, fit_.options, {}, control_);
  }
  std::optional<StagedFitState> ReadBack(const std::string& job = "job") const {
    return ReadCheckpoint(path_, job, fit_.problem, fit_.options);
  }
  // The members of a saved state's file.
  json Members(const StagedFitState& state) const {
    WriteCheckpoint(path_, "job", state);
    return ReadStoredJson(path_, kCheckpointFormat);
  }
  // Where a fit is that has both kinds of candidates: the first that `holds`.
  StagedFitState Saved(const std::function<bool(const StagedFitState&)>& holds) const {
    const auto found = std::find_if(saved_.begin(), saved_.end(), holds);
    EXPECT_NE(found, saved_.end());
    return *found;
  }
  StagedFitState InRoundTwo() const {
    return Saved([](const StagedFitState& s) { return s.round == 1 && DoneCandidates(s) == 1; });
  }
  // What is said of changed members by one who knows the checksum; empty: they are read.
  std::string ComputeError(const json& members) const {
    test::WriteQuickly(path_, StoredJsonText(kCheckpointFormat, members));
    try {
      ReadBack();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(path_));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
      return error.what();
    }
    return "";
  }

  test::FakeFit fit_;
  StagedFitControl control_;
  std::vector<StagedFitState> saved_;
  StagedFitState whole_;
  const std::string path_ = Path("checkpoint.json");
};

TEST_F(CheckpointTest, EachSavedStateIsReadBackBitForBit) {
  ASSERT_GT(saved_.size(), 7u);  // part of the grid, the grid, the candidates
  EXPECT_FALSE(saved_[0].grid_done);
  EXPECT_EQ(saved_[0].tried.size(), 16u);
  for (StagedFitState state : saved_) {
    state.fit_seconds = 1e-17;
    WriteCheckpoint(path_, "job", state);
    ExpectSame(*ReadBack(), state);
  }
  EXPECT_EQ(saved_.back().round, 3);
}

// A fit by several models, from several start tables.
TEST_F(CheckpointTest, StatesOfNestedFitsAreReadBackBitForBit) {
  fit_.problem.other_materials = {Scaled(fit_.problem.material, 2.0, 1.0)};
  fit_.problem.simpler_models =
      SimplerModels({TableForm::kGiven, fit_.options.parameters = ParameterTying::kColumns});
  saved_.clear();
  test::FakeBackend finer(200);
  fit_.problem.search = {fit_.problem.fine};
  fit_.problem.fine = &finer;
  RunNestedFit(fit_.problem, fit_.options, {}, control_);
  ASSERT_EQ(saved_.back().parts_done, 3);
  for (const StagedFitState& state : saved_) {
    WriteCheckpoint(path_, "job", state);
    ExpectSame(*ReadBack(), state);
  }
  const auto last_of_part = [&](int part) {
    return *std::find_if(saved_.rbegin(), saved_.rend(),
                         [&](const StagedFitState& state) { return state.parts_done == part; });
  };
  ASSERT_TRUE(last_of_part(2).carried);
  const auto expect_errors = [&](const json& members,
                                 const std::vector<std::pair<const char*, json>>& changes) {
    for (const auto& [at, value] : changes) {
      json changed = members;
      changed[json::json_pointer(at)] = value;
      EXPECT_THAT(ComputeError(changed), testing::HasSubstr("key '")) << at;
    }
  };
  expect_errors(Members(last_of_part(2)), {{"/carried/is_carried", false},
                                           {"/carried/base", json::array()},
                                           {"/parts_done", 0},
                                           {"/part_results/0/part", 2},
                                           {"/part_results/0/bend", -1}});
  expect_errors(Members(last_of_part(3)), {{"/candidates/0/base", json::array()},
                                           {"/candidates/0/is_carried", false},
                                           {"/grid_done", false},
                                           {"/part_results", json::array()},
                                           {"/parts_done", 2},
                                           {"/parts_done", 4}});
}

TEST_F(CheckpointTest, AbsentIsNothing) { EXPECT_FALSE(ReadBack().has_value()); }

TEST_F(CheckpointTest, AnotherJobIsRefused) {
  WriteCheckpoint(path_, "job", saved_[0]);
  EXPECT_INPUT_ERROR(ReadBack("another"), "run without --resume");
}

TEST_F(CheckpointTest, AFileOfAnEarlierVersionIsRefused) {
  Write("checkpoint.json", R"({"format": "drapefit-checkpoint", "job": "job", "round": 0})");
  EXPECT_INPUT_ERROR(ReadBack(), "is of another version of the program, expected version 4");
}

TEST_F(CheckpointTest, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(WriteCheckpoint(Path("no/checkpoint.json"), "job", saved_[0]), IoError);
}

TEST_F(CheckpointTest, EveryMemberIsChecked) {
  int tried = 0;
  const auto expect_error = [&](const std::string& what, const json& tampered) {
    ++tried;
    // Earlier in the grid or the round, or a scale without a drape: a state, too.
    if (what.starts_with("/tried") && what.find("= [") != std::string::npos) return;
    if (what.starts_with("/candidates = [{")) return;
    EXPECT_NE(ComputeError(tampered), "") << what;
  };
  for (const StagedFitState& state : {saved_[0], InRoundTwo()})
    const test::Tampering tampering(Members(state), expect_error);
  EXPECT_GT(tried, 600);
}

TEST_F(CheckpointTest, WhatAFitCannotHaveSavedIsRefused) {
  struct Change {
    const char* at;
    json value;
    const char* error;
  };
  const int n = fit_.backend.model().num_dofs();
  const json members = Members(InRoundTwo());
  const json nothing(std::vector<double>(n, 0.0)), far(std::vector<double>(n, 1e300));
  json flat = members["candidates"][0]["shapes"][0];
  for (int i = 0; i < n; i += 3) flat[i] = 0.5 * flat[i].get<double>();
  json all = members["candidates"], many = members["candidates"];
  for (json& candidate : all) candidate["done"] = true;
  many.push_back(many.back());
  for (int i = 0; i < 12; ++i) many.push_back(many.back());
  const std::vector<Change> changes = {
      {"/round", 4, "key 'round': found 4, expected a whole number from 0 to 3"},
      {"/round", 2147483647, "key 'round'"},
      {"/round", 0, "no drapes, since its first fit is not done"},
      {"/round", 3, "key 'candidates'"},
      {"/grid_done", false, "key 'grid_done'"},
      {"/counts/2", 2e9, "key 'counts[2]'"},
      {"/seconds/0", 1e300, "key 'seconds[0]'"},
      {"/candidates", json::array(), "key 'candidates'"},
      {"/candidates", all, "still to be fitted"},
      {"/candidates", many, "expected at most 12"},
      {"/candidates/0/guess/stretch", 3.0, "one of the initial guesses of this fit"},
      {"/candidates/0/guess/lifts/0", 1.7, "key 'candidates[0].guess.lifts[0]'"},
      {"/candidates/0/theta", json::array(), "expected an array of 2"},
      {"/candidates/0/theta", {1e3, 0.0}, "tables are not finite"},
      {"/candidates/0/theta", {0.0, 0.1}, "a cost of"},
      {"/candidates/0/shapes", json::array(), "key 'candidates[0].termination'"},
      {"/candidates/0/shapes/0", {0, 0, 0}, "key 'candidates[0].shapes[0]'"},
      {"/candidates/0/shapes/0", nothing, "key 'candidates[0]', drape 1: found a torn or crushed"},
      {"/candidates/0/shapes/0", far, "found a torn or crushed cloth"},
      {"/candidates/0/shapes/0", flat, "an outline error [px] of"},
      {"/candidates/0/profile_rms", 0.0, "found an outline error [px] of 0, expected"},
      {"/candidates/0/cost", 0.0, "found a cost of 0, expected"},
      {"/candidates/0/termination", 4, "key 'candidates[0].termination'"},
      {"/candidates/0/termination", 5, "how a fit ended that has shapes"}};
  EXPECT_EQ(ComputeError(members), "");
  for (const Change& change : changes) {
    json changed = members;
    changed[json::json_pointer(change.at)] = change.value;
    EXPECT_THAT(ComputeError(changed), testing::HasSubstr(change.error)) << change.at;
  }
}

// Random damage by one who does not know the checksum, and by one who does. From what is read, a
// fit can continue to its end.
TEST_F(CheckpointTest, NoMutantIsMoreThanAStateOrAnError) {
  StagedFitState state = InRoundTwo();
  control_.save = {};
  const std::string text = StoredJsonText(kCheckpointFormat, Members(state));
  const std::string members = Members(state).dump();
  std::mt19937_64 random(18);
  int same = 0, other = 0;
  for (int i = 0; i < test::NumMutants(1000); ++i) {
    test::WriteQuickly(path_, test::Mutant(text, random));
    try {
      ExpectSame(*ReadBack(), state);
      ++same;
    } catch (const InputError&) {
    }
    const json mutant = json::parse(test::Mutant(members, random), nullptr, false);
    if (!mutant.is_object()) continue;
    test::WriteQuickly(path_, StoredJsonText(kCheckpointFormat, mutant));
    try {
      const StagedFitState read = *ReadBack();
      EXPECT_EQ(RunStagedFit(fit_.problem, fit_.options, read, control_).round, 3);
      ++other;
    } catch (const InputError&) {
    }
  }
  RecordProperty("read_the_same", same);
  RecordProperty("read_with_checksum", other);
}

// With physics: a drape must also be at rest under its tables.
TEST(CheckpointOfDrapes, ADrapeThatIsNotAtRestIsRefused) {
  const TempFolder folder;
  const auto backend = test::SmoothDisc(100);
  FitProblem problem;
  problem.fine = problem.coarse = backend.get();
  problem.material = test::TestMaterial();
  const State drape = test::Settled(*backend, Scaled(test::TestMaterial(), 1.0, 5.0),
                                    test::RandomStart(backend->model(), 1));
  problem.observations = {test::MakeObservation(backend->model().mesh, drape, 72, "reference")};
  StagedFitOptions options;
  options.grid.stretch = {1.0};
  options.grid.bend = {5.0, 7.0};
  options.grid.lifts = {1.0};
  options.grid.steps = 30;
  options.parameters = ParameterTying::kBendScale;
  options.candidates_per_round = {1};
  options.iterations = {2};
  const StagedFitState state = RunStagedFit(problem, options, {}, {});
  ASSERT_NE(Best(state), nullptr);
  const std::string path = folder / "checkpoint.json";
  WriteCheckpoint(path, "job", state);
  ExpectSame(*ReadCheckpoint(path, "job", problem, options), state);
  StagedFitState altered = state;
  for (int i = 2; i < drape.x.size(); i += 3) altered.candidates[0].shapes[0][i] *= 0.99;
  WriteCheckpoint(path, "job", altered);  // the outline is the same
  EXPECT_INPUT_ERROR(ReadCheckpoint(path, "job", problem, options),
                     "found a drape that is not at rest under its tables");
  altered = state;
  altered.candidates[0].guess.bend = 7.0;
  WriteCheckpoint(path, "job", altered);
  EXPECT_INPUT_ERROR(ReadCheckpoint(path, "job", problem, options), "is not at rest");
  const double theta = state.candidates[0].theta[0];
  altered = state;
  altered.candidates[0].theta[0] = -theta;  // the cost is the same
  WriteCheckpoint(path, "job", altered);
  EXPECT_INPUT_ERROR(ReadCheckpoint(path, "job", problem, options), "is not at rest");
}

}  // namespace
}  // namespace drape
