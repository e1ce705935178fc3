// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <random>

#include "cuda/factor/plan/front_plan.h"

namespace drape {
namespace {

using testing::ElementsAre;

TEST(PackUpdates, FirstFit) {
  // The last takes the gap of the second, too small for the fourth.
  const UpdateSpace space = PackUpdates({{10, 0, 3}, {8, 0, 1}, {4, 0, 3}, {9, 2, 3}, {6, 2, 3}});
  EXPECT_THAT(space.offset, ElementsAre(0, 10, 18, 22, 10));
  EXPECT_EQ(space.size, 31);
}

TEST(PackUpdates, LastLevelIsStillInUse) {
  EXPECT_EQ(PackUpdates({{10, 0, 1}, {10, 1, 2}}).size, 20);
  EXPECT_EQ(PackUpdates({{10, 0, 1}, {10, 2, 2}}).size, 10);
}

TEST(PackUpdates, NoTwoInUseOverlap) {
  std::mt19937_64 random(3);
  std::vector<UpdateBlock> blocks;
  for (int i = 0; i < 300; ++i) {
    const int first = static_cast<int>(random() % 20);
    blocks.push_back(
        {static_cast<std::int64_t>(random() % 90), first, first + static_cast<int>(random() % 5)});
  }
  const UpdateSpace space = PackUpdates(blocks);
  for (std::size_t a = 0; a < blocks.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(blocks[a].last < blocks[b].first || blocks[b].last < blocks[a].first ||
                  space.offset[a] + blocks[a].size <= space.offset[b] ||
                  space.offset[b] + blocks[b].size <= space.offset[a]);
}

TEST(PackUpdates, Nothing) { EXPECT_EQ(PackUpdates({}).size, 0); }

}  // namespace
}  // namespace drape
