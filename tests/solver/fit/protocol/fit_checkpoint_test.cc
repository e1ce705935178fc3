// SPDX-License-Identifier: Apache-2.0
// A checkpoint is read back to the last bit, or refused.
#include "solver/job/fit_checkpoint.h"

#include <algorithm>
#include <limits>

#include "physics/util/atomic_file.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/job/fit_job.h"
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
  ASSERT_EQ(a.first_fits.size(), b.first_fits.size());
  for (std::size_t i = 0; i < a.first_fits.size(); ++i)
    ExpectSame(a.first_fits[i], b.first_fits[i]);
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
    return ReadCheckpoint(path_, job);
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
    state.first_fits.assign(2, test::TestMaterial(1.0 / 3.0));
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
  EXPECT_TRUE(std::any_of(saved_.begin(), saved_.end(),
                          [](const StagedFitState& state) { return state.carried.has_value(); }));
}

TEST_F(CheckpointTest, AbsentIsNothing) { EXPECT_FALSE(ReadBack().has_value()); }

TEST_F(CheckpointTest, AnotherJobIsRefused) {
  WriteCheckpoint(path_, "job", saved_[0]);
  EXPECT_INPUT_ERROR(ReadBack("another"), "run without --resume");
}

TEST_F(CheckpointTest, AFileOfAnEarlierVersionIsRefused) {
  Write("checkpoint.json", R"({"format": "drapefit-checkpoint", "job": "job", "round": 0})");
  EXPECT_INPUT_ERROR(ReadBack(), "is of another version of the program, expected version 7");
}

// A key says what differs, such as a mesh whose file was changed.
TEST_F(CheckpointTest, TheFirstDifferenceOfTheKeysIsNamed) {
  WriteCheckpoint(path_, R"({"law": "smooth", "mesh_files": ["12"]})", saved_[0]);
  EXPECT_INPUT_ERROR(ReadBack(R"({"law": "smooth", "mesh_files": ["34"]})"),
                     "found another 'mesh_files'");
  EXPECT_INPUT_ERROR(ReadBack(R"({"law": "smooth"})"), "found another 'mesh_files'");
}

TEST_F(CheckpointTest, MembersOfAnotherTypeAreRefusedInOneLine) {
  WriteCheckpoint(path_, "job", saved_[0]);
  json members = ReadStoredJson(path_, kCheckpointFormat);
  members["round"] = "one";
  test::WriteQuickly(path_, StoredJsonText(kCheckpointFormat, members));
  EXPECT_INPUT_ERROR(ReadBack(), "is damaged or was altered");
}

TEST_F(CheckpointTest, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(WriteCheckpoint(Path("no/checkpoint.json"), "job", saved_[0]), IoError);
}

// The checksum shows random damage.
TEST_F(CheckpointTest, AMutantIsTheSameStateOrAnError) {
  const StagedFitState state = InRoundTwo();
  WriteCheckpoint(path_, "job", state);
  const std::string text = ReadOwnFile(path_);
  std::mt19937_64 random(18);
  int same = 0;
  for (int i = 0; i < test::NumMutants(1000); ++i) {
    test::WriteQuickly(path_, test::Mutant(text, random));
    try {
      ExpectSame(*ReadBack(), state);
      ++same;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(path_));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
    }
  }
  RecordProperty("read_the_same", same);
}

}  // namespace
}  // namespace drape
