// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "losses/dataset/dataset.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

// Two fabrics of six samples, four captures each.
Dataset TwoFabrics() {
  Dataset dataset;
  for (int fabric : {1, 2})
    for (int sample = 1; sample <= 6; ++sample)
      for (int capture = 1; capture <= 4; ++capture)
        dataset.captures.push_back({fabric, sample, capture, ClothFace::kUp, "image", ""});
  return dataset;
}

std::set<std::pair<int, int>> ListSamples(const std::vector<Capture>& captures) {
  std::set<std::pair<int, int>> samples;
  for (const Capture& c : captures) samples.insert({c.fabric, c.sample});
  return samples;
}

class SplitFile : public FileFixture {};

TEST_F(SplitFile, KeepsSamplesTogetherAndSelectsInEachFabric) {
  const Split split = SplitBySample(TwoFabrics().captures, 2, 5);
  EXPECT_EQ(split.train.size(), 2u * 2 * 4);
  EXPECT_EQ(split.held_out.size(), 2u * 4 * 4);
  const auto train = ListSamples(split.train), held_out = ListSamples(split.held_out);
  EXPECT_EQ(train.size(), 4u);
  EXPECT_EQ(held_out.size(), 8u);
  EXPECT_EQ(std::count_if(train.begin(), train.end(), [](auto s) { return s.first == 1; }), 2);
  for (const auto& sample : train) EXPECT_FALSE(held_out.contains(sample));
}

TEST_F(SplitFile, FollowsFromTheSeedAlone) {
  const auto captures = TwoFabrics().captures;
  EXPECT_EQ(ListSamples(SplitBySample(captures, 3, 5).train),
            ListSamples(SplitBySample(captures, 3, 5).train));
  std::set<std::set<std::pair<int, int>>> selected;
  std::set<std::pair<int, int>> ever;
  for (int seed = 0; seed < 40; ++seed) {
    const auto train = ListSamples(SplitBySample(captures, 1, seed).train);
    selected.insert(train);
    ever.insert(train.begin(), train.end());
  }
  EXPECT_GT(selected.size(), 15u);  // of 36
  EXPECT_EQ(ever.size(), 12u);
  EXPECT_EQ(ListSamples(SplitBySample(captures, 2, 1).train),
            (std::set<std::pair<int, int>>{{1, 1}, {1, 2}, {2, 2}, {2, 3}}));
}

TEST_F(SplitFile, NeedsASampleToHoldOut) {
  EXPECT_INPUT_ERROR(SplitBySample(TwoFabrics().captures, 6, 1),
                     "found 6 training samples, expected fewer than the 6 of fabric 1");
}

TEST_F(SplitFile, IsReadBackAsItWasWritten) {
  const Dataset dataset = TwoFabrics();
  const Split split = SplitBySample(dataset.captures, 2, 123456789012345ull);
  WriteSplit(Path("split.json"), split);
  const Split back = ReadSplit(Path("split.json"), dataset);
  EXPECT_EQ(back.seed, split.seed);
  ASSERT_EQ(back.train.size(), split.train.size());
  for (size_t i = 0; i < split.train.size(); ++i)
    EXPECT_EQ(back.train[i].Name(), split.train[i].Name());
  EXPECT_EQ(ListSamples(back.held_out), ListSamples(split.held_out));
  EXPECT_EQ(back.train[0].image, "image");
}

TEST_F(SplitFile, MistakesAreNamed) {
  const Dataset dataset = TwoFabrics();
  const auto read = [&](const std::string& seed, const std::string& train,
                        const std::string& held_out) {
    return ReadSplit(
        Write("s.json", R"({"format": "drapefit-split", "seed": )" + seed + R"(, "train": )" +
                            train + R"(, "held_out": )" + held_out + "}"),
        dataset);
  };
  EXPECT_EQ(read("1", "[[1,1,1]]", "[[1,2,1]]").train.size(), 1u);
  EXPECT_INPUT_ERROR(read("-1", "[]", "[]"), "key 'seed': found -1");
  EXPECT_INPUT_ERROR(read("1", "[[1,1]]", "[]"), "key 'train[0]'");
  EXPECT_INPUT_ERROR(read("1", "[[3,1,1]]", "[]"), "key 'train[0]': the data set lacks");
  EXPECT_INPUT_ERROR(read("1", "[[1,1,1]]", "[[1,1,2]]"),
                     "the sample of fabric 1, sample 1, capture 2 is on both sides");
  EXPECT_INPUT_ERROR(ReadSplit(Write("t.json", R"({"format": "other"})"), dataset), "format");
}

}  // namespace
}  // namespace drape
