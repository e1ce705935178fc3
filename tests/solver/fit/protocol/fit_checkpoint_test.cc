// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/fit_checkpoint.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "physics/util/errors.h"
#include "tests/losses/temp_folder.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// A number in each field that no other has, among them ones that few digits would spoil.
StagedFitState SomeState() {
  std::mt19937_64 random(8);
  StagedFitState state;
  state.grid_done = true;
  state.round = 1;
  state.iterations = 23;
  state.counts = {101, 57, 13, 7};
  state.grid_seconds = 1.0 / 3.0;
  state.fit_seconds = 1e-17;
  for (int i = 0; i < 2; ++i) {
    FitCandidate& candidate = state.candidates.emplace_back();
    candidate.guess = {0.1 + i, std::nextafter(1.0, 2.0), {0.3, 0.6 + 0.1 * i}, M_PI * (1 + i)};
    candidate.guess_rms = std::exp(1.0 + i);
    candidate.theta = test::RandomMatrix(39, 1, random);
    candidate.shapes = {test::RandomMatrix(12, 1, random),
                        1e-9 * test::RandomMatrix(12, 1, random)};
    candidate.cost = 1e5 / 7.0;
    candidate.profile_rms = std::sqrt(2.0 + i);
    candidate.termination = FitTermination::kStalled;
    candidate.iterations = 4 + i;
    candidate.done = i == 1;
  }
  state.candidates[1].shapes.clear();  // a candidate without a drape
  state.candidates[0].shapes[0][3] = -0.0;
  state.candidates[0].shapes[0][4] = std::numeric_limits<double>::denorm_min();
  return state;
}

void ExpectSame(const FitCandidate& a, const FitCandidate& b) {
  EXPECT_EQ(a.guess.stretch, b.guess.stretch);
  EXPECT_EQ(a.guess.bend, b.guess.bend);
  EXPECT_EQ(a.guess.lifts, b.guess.lifts);
  EXPECT_EQ(a.guess.profile_rms, b.guess.profile_rms);
  EXPECT_EQ(a.guess_rms, b.guess_rms);
  EXPECT_EQ(a.theta, b.theta);
  EXPECT_EQ(a.shapes, b.shapes);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.profile_rms, b.profile_rms);
  EXPECT_EQ(a.termination, b.termination);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.done, b.done);
}

class CheckpointTest : public testing::Test {
 protected:
  // The error's text; empty when the file is read.
  std::string ComputeError(const std::string& job = "job") const {
    try {
      ReadCheckpoint(path_, job);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::string Text() const {
    const auto bytes = ReadAll(path_);
    return {bytes.begin(), bytes.end()};
  }
  void Replace(const std::string& from, const std::string& to) const {
    std::string text = Text();
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    WriteAll(path_, {text.begin(), text.end()});
  }
  const TempFolder folder_;
  const std::string path_ = folder_ / "checkpoint.json";
};

TEST_F(CheckpointTest, ReadsBackBitForBit) {
  const StagedFitState state = SomeState();
  WriteCheckpoint(path_, "job", state);
  const auto read = ReadCheckpoint(path_, "job");
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->grid_done, state.grid_done);
  EXPECT_EQ(read->round, state.round);
  EXPECT_EQ(read->iterations, state.iterations);
  EXPECT_EQ(read->counts.rollouts, state.counts.rollouts);
  EXPECT_EQ(read->counts.tangents, state.counts.tangents);
  EXPECT_EQ(read->counts.failed, state.counts.failed);
  EXPECT_EQ(read->counts.jumps, state.counts.jumps);
  EXPECT_EQ(read->grid_seconds, state.grid_seconds);
  EXPECT_EQ(read->fit_seconds, state.fit_seconds);
  ASSERT_EQ(read->candidates.size(), 2);
  for (int i = 0; i < 2; ++i) ExpectSame(read->candidates[i], state.candidates[i]);
  EXPECT_TRUE(std::signbit(read->candidates[0].shapes[0][3]));
  EXPECT_FALSE(read->candidates[1].valid());
}

TEST_F(CheckpointTest, AbsentIsNothing) { EXPECT_EQ(ReadCheckpoint(path_, "job"), std::nullopt); }

TEST_F(CheckpointTest, AnotherJobIsRefused) {
  WriteCheckpoint(path_, "job", SomeState());
  EXPECT_THAT(ComputeError("another"), testing::AllOf(testing::HasSubstr(path_),
                                                      testing::HasSubstr("run without --resume")));
}

TEST_F(CheckpointTest, ADamagedFileIsRefused) {
  WriteCheckpoint(path_, "job", SomeState());
  const std::string whole = Text();
  for (const double share : {0.0, 0.1, 0.5, 0.99}) {
    WriteAll(path_,
             {whole.begin(), whole.begin() + static_cast<int>(share * double(whole.size()))});
    EXPECT_THAT(ComputeError(), testing::HasSubstr(path_)) << share;
  }
}

TEST_F(CheckpointTest, AWrongValueIsNamed) {
  const std::pair<std::string, std::string> changes[] = {
      {"\"grid_done\":true", "\"grid_done\":1"},
      {"\"round\":1", "\"round\":\"one\""},
      {"\"round\":1", "\"round\":-1"},
      {"\"done\":true", "\"done\":2"},
      {"\"termination\":3", "\"termination\":77"}};
  for (const auto& [from, to] : changes) {
    WriteCheckpoint(path_, "job", SomeState());
    Replace(from, to);
    EXPECT_THAT(ComputeError(), testing::HasSubstr(path_)) << to;
  }
}

TEST_F(CheckpointTest, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(WriteCheckpoint(folder_ / "no/checkpoint.json", "job", SomeState()), InputError);
}

}  // namespace
}  // namespace drape
