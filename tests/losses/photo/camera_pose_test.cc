// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/camera_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "losses/image/photo_planes.h"
#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

// What a tilted camera sees of a disc and of a round drape.
struct Seen {
  PhotoPose pose;
  PoseInput input;
};
Seen See(double rim_height) {
  constexpr int kPoints = 360;
  constexpr double kHemRadius = 0.12;
  Seen seen;
  seen.pose.focal = 1200;
  seen.pose.principal = {799.5, 599.5};
  seen.pose.tilt = {0.09, -0.06};
  seen.pose.eye = {-0.04, -0.11, 1.05};
  seen.input = {.focal = seen.pose.focal,
                .principal = seen.pose.principal,
                .rim = {},
                .rim_radius = 0.09,
                .rim_height = rim_height,
                .tag = {},
                .outline = {},
                .discs = {}};
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * M_PI * i / kPoints;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    seen.input.rim.push_back(
        seen.pose.ImageFromWorld({0.09 * ray.x(), 0.09 * ray.y(), rim_height}));
    if (i % 3 == 0)
      seen.input.outline.push_back(seen.pose.ImageFromWorld(
          {kHemRadius * ray.x(), kHemRadius * ray.y(), EstimatedHemHeight(kHemRadius, {})}));
  }
  return seen;
}

TEST(CameraPose, FollowsFromTheRimAndTheHem) {
  for (const double height : {0.0, 0.004}) {
    const Seen seen = See(height);
    const auto found = FindPose(seen.input);
    ASSERT_TRUE(found);
    EXPECT_LT((found->pose.eye - seen.pose.eye).norm(), 1e-4);
    EXPECT_LT((found->pose.tilt - seen.pose.tilt).norm(), 1e-4);
    EXPECT_LT(found->rms, 1e-3);
  }
}

TEST(CameraPose, LeavesOutWhatIsNotOnTheRim) {
  Seen seen = See(0);
  for (int i = 40; i < 75; ++i) seen.input.rim[size_t(i)].y() += 1.5;  // a finger
  const auto found = FindPose(seen.input);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pose.eye.z(), seen.pose.eye.z(), 2e-4);
  EXPECT_LT((found->pose.tilt - seen.pose.tilt).norm(), 2e-3);
}

// A tag that lies beside the cloth, below the support.
TEST(CameraPose, FollowsFromATagOfKnownHeight) {
  constexpr double kHeight = -0.15, kHalf = 0.05, kTurn = 0.3;
  constexpr int kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  Seen seen = See(0);
  seen.input.rim.clear();
  seen.input.tag_side = 2 * kHalf;
  seen.input.tag_height = kHeight;
  seen.input.tag.emplace();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d corner =
        Eigen::Vector2d(0.25, 0.05) +
        Eigen::Rotation2Dd(kTurn) * Eigen::Vector2d(kHalf * kSigns[i][0], kHalf * kSigns[i][1]);
    (*seen.input.tag)[size_t(i)] = seen.pose.ImageFromWorld({corner.x(), corner.y(), kHeight});
  }
  const auto found = FindPose(seen.input);
  ASSERT_TRUE(found);
  EXPECT_LT((found->pose.eye - seen.pose.eye).norm(), 1e-3);
  EXPECT_LT((found->pose.tilt - seen.pose.tilt).norm(), 1e-3);
  EXPECT_LT(found->rms, 0.01);
}

// A disc of another height above the cloth is nearer to the camera.
TEST(CameraPose, NeedsTheHeightOfTheDisc) {
  Seen seen = See(0.004);
  seen.input.rim_height = 0;
  const auto found = FindPose(seen.input);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pose.eye.z(), seen.pose.eye.z() - 0.004, 5e-4);
}

// The tag says where the camera is by its place and its size.
TEST(Tag, IsWhereAndAsLargeAsTheCameraSeesIt) {
  PhotoScene scene = SmallScene();
  scene.has_disc = false;
  scene.tag_side = 0.1;
  scene.tilt = {0.05, 0.03};
  const auto found = FindTag(MakePlanes(RenderPhoto(scene, {{&Wool().mesh, Wool().x}})));
  ASSERT_TRUE(found);
  const PhotoPose camera{scene.focal_35mm * std::hypot(scene.width, scene.height) / 43.2666,
                         {0.5 * (scene.width - 1), 0.5 * (scene.height - 1)},
                         scene.tilt,
                         scene.eye};
  constexpr int kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double side = 0.0, found_side = 0.0;
  Eigen::Vector2d seen[4];
  for (int i = 0; i < 4; ++i)
    seen[i] = camera.ImageFromWorld(scene.tag_place +
                                    0.05 * Eigen::Vector3d(kSigns[i][0], kSigns[i][1], 0.0));
  for (int i = 0; i < 4; ++i) {
    shift += ((*found)[size_t(i)] - seen[i]) / 4;
    side += (seen[(i + 1) % 4] - seen[i]).norm() / 4;
    found_side += ((*found)[size_t(i + 1) % 4] - (*found)[size_t(i)]).norm() / 4;
  }
  EXPECT_LT(shift.norm(), 0.3);
  EXPECT_NEAR(found_side / side, 1, 2.5e-3);
}

}  // namespace
}  // namespace drape
