// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <random>
#include <utility>
#include <vector>

#include "physics/cloth/contact/pairs/candidates.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

class BoxTreeTest : public testing::TestWithParam<int> {
 protected:
  SpaceBox RandomBox(double size) {
    SpaceBox box;
    for (int k = 0; k < 3; ++k) {
      box.min()[k] = SampleUniform(random_);
      box.max()[k] = box.min()[k] + size * SampleUniform(random_);
    }
    return box;
  }
  std::vector<SpaceBox> RandomBoxes(double size) {
    std::vector<SpaceBox> boxes;
    for (int i = 0; i < GetParam(); ++i) boxes.push_back(RandomBox(size));
    return boxes;
  }
  // No two of these boxes are nearer than single precision can tell.
  static void ExpectFinds(const BoxTree& tree, const std::vector<SpaceBox>& boxes,
                          const SpaceBox& box) {
    std::vector<int> found(boxes.size(), 0);
    tree.ForEachMeeting(box, [&](int k) { ++found[k]; });
    for (std::size_t k = 0; k < boxes.size(); ++k)
      EXPECT_EQ(found[k], boxes[k].intersects(box)) << k;
  }

  std::mt19937_64 random_{4};
};

TEST_P(BoxTreeTest, FindsAllThatMeetAndNoOthersAlsoAfterTheyHaveMoved) {
  BoxTree tree;
  for (int round = 0; round < 3; ++round) {
    const std::vector<SpaceBox> boxes = RandomBoxes(0.2);
    tree.Enclose(boxes);
    for (int k = 0; k < 20; ++k) ExpectFinds(tree, boxes, RandomBox(0.4));
  }
}

TEST_P(BoxTreeTest, VisitsEachPairOnce) {
  const std::vector<SpaceBox> boxes = RandomBoxes(0.2);
  BoxTree tree;
  tree.Enclose(boxes);
  ASSERT_EQ(tree.order().size(), boxes.size());
  std::vector<std::pair<int, int>> found, expected;
  for (int place = 0; place < GetParam(); ++place) {
    const int one = tree.order()[place];
    tree.ForEachLaterMeeting(
        place, [&](int other) { found.emplace_back(std::min(one, other), std::max(one, other)); });
  }
  for (int i = 0; i < GetParam(); ++i)
    for (int j = i + 1; j < GetParam(); ++j)
      if (boxes[i].intersects(boxes[j])) expected.emplace_back(i, j);
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(expected));
}

INSTANTIATE_TEST_SUITE_P(Numbers, BoxTreeTest, testing::Values(0, 1, 2, 7, 8, 9, 63, 64, 65, 700));

// Rounded outwards: boxes that only just meet are found, wherever they are.
TEST(BoxTreeRoundingTest, LosesNoneThatTouch) {
  for (const double at : {0.1, -3.0, 1e4}) {
    const SpaceBox left(Eigen::Vector3d(at - 1.0, 0.0, 0.0), Eigen::Vector3d(at, 1.0, 1.0));
    const SpaceBox right(Eigen::Vector3d(at, 0.0, 0.0), Eigen::Vector3d(at + 1.0, 1.0, 1.0));
    BoxTree tree;
    tree.Enclose({left});
    int found = 0;
    tree.ForEachMeeting(right, [&](int) { ++found; });
    EXPECT_EQ(found, 1) << at;
  }
}

}  // namespace
}  // namespace drape
