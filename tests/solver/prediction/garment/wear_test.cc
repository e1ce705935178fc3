// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/wear.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "physics/simulation/textbook.h"
#include "physics/util/math/random.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {
namespace {

class WearTest : public testing::Test {
 protected:
  // The frames of a garment with edges of 4 cm on the mannequin.
  std::vector<WornFrame> Wear(const std::string& name, const WearOptions& options) {
    const Pattern pattern =
        ReadPattern(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/" + name + ".json");
    const SewnGarment sewn = Sew(MakeGarmentMesh(pattern, 0.04), MakeLaw("smooth"));
    const Mannequin body(MotionKind::kStand, pattern.arm_angle);
    std::vector<WornFrame> frames;
    const WearResult result = drape::Wear(sewn, LinearMaterial(300.0, 1e-5, 0.2), body, options,
                                          StartToWear(sewn, body, options), 0, {},
                                          [&](const WornFrame& frame) { frames.push_back(frame); });
    EXPECT_EQ(result.status, WearStatus::kDone) << result.reason;
    held_ = sewn.held_by_pelvis;
    start_ = sewn.start_x;
    return frames;
  }

  std::vector<int> held_;
  Eigen::VectorXd start_;
};

// Its panels begin up to 27 cm apart: joined in the middle they would be stretched fivefold.
TEST_F(WearTest, PanelsAreDrawnTogether) {
  const std::vector<WornFrame> frames = Wear("t_shirt", {.frames = 0});
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_LT(frames[0].largest_stretch, 0.3);
  EXPECT_GT(frames[0].smallest_gap, 0.0);
}

// Edges of 4 cm around an armhole cut the shoulder, although no vertex is in it.
TEST_F(WearTest, NoFaceBeginsInTheBody) {
  for (const char* name : {"tank_dress", "t_shirt", "circle_skirt"}) {
    const std::vector<WornFrame> frames = Wear(name, {.frames = 0});
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].body_intersections, 0) << name;
    EXPECT_EQ(frames[0].self_intersections, 0) << name;
  }
}

TEST_F(WearTest, ASkirtFallsAndItsWaistbandStays) {
  const std::vector<WornFrame> frames = Wear("circle_skirt", {.frames = 4});
  ASSERT_EQ(frames.size(), 5u);
  const Eigen::VectorXd& x = frames.back().cloth.x;
  ASSERT_FALSE(held_.empty());
  for (const int i : held_)
    EXPECT_LT((x.segment<3>(3 * i) - start_.segment<3>(3 * i)).norm(), 0.01);
  EXPECT_LT(x(Eigen::seq(2, Eigen::last, 3)).minCoeff(), 1.1 - 0.05);
  for (const WornFrame& frame : frames) {
    EXPECT_GT(frame.smallest_gap, 0.0) << frame.index;
    EXPECT_EQ(frame.body_intersections, 0) << frame.index;
  }
}

// A garment of which every face is somewhere in the chest meets itself thousands of times.
TEST_F(WearTest, AllIntersectionsWithTheBodyAreCounted) {
  const Pattern pattern =
      ReadPattern(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/circle_skirt.json");
  const SewnGarment sewn = Sew(MakeGarmentMesh(pattern, 0.08), MakeLaw("smooth"));
  const Mannequin body(MotionKind::kStand, pattern.arm_angle);
  State state = StartToWear(sewn, body, {});
  std::mt19937_64 random(1);
  for (Eigen::Index i = 0; i < state.x.size(); ++i)
    state.x[i] = 0.1 * SampleNormal(random) + (i % 3 == 2 ? 1.2 : 0.0);
  const WearResult result =
      drape::Wear(sewn, LinearMaterial(300.0, 1e-5, 0.2), body, {.frames = 0}, state, 0, {},
                  [](const WornFrame& frame) { EXPECT_GT(frame.body_intersections, 3000); });
  EXPECT_EQ(result.frames, 1);
}

TEST_F(WearTest, ACancelledRunEndsWithItsFrames) {
  const Pattern pattern =
      ReadPattern(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/circle_skirt.json");
  const SewnGarment sewn = Sew(MakeGarmentMesh(pattern, 0.08), MakeLaw("smooth"));
  const Mannequin body(MotionKind::kStand, pattern.arm_angle);
  std::atomic<bool> cancel = false;
  int frames = 0;
  const WearResult result =
      drape::Wear(sewn, LinearMaterial(300.0, 1e-5, 0.2), body, {.frames = 50},
                  StartToWear(sewn, body, {}), 0, {.cancel = &cancel}, [&](const WornFrame&) {
                    ++frames;
                    cancel = frames == 2;
                  });
  EXPECT_EQ(result.status, WearStatus::kCancelled);
  EXPECT_EQ(result.frames, 2);
  EXPECT_EQ(frames, 2);
}

}  // namespace
}  // namespace drape
