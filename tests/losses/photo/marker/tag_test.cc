// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "losses/photo/camera_pose.h"
#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

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
