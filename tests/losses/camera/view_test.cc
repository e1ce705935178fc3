// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "physics/util/errors.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class ViewTest : public testing::TestWithParam<CameraKind> {
 protected:
  ViewTest() {
    camera_.kind = GetParam();
    camera_.eye_x = 0.02;
  }
  Vector2d Project(const View& view, const Vector3d& x) const {
    const Eigen::VectorXd seen = view.FromWorld(x);
    Vector2d image;
    view.camera.Project(seen.data(), image.data());
    return image;
  }
  Camera camera_;
};

TEST_P(ViewTest, ACameraLooksStraightDown) {
  const Eigen::VectorXd x = RandomVector(30, 3);
  EXPECT_EQ(View(camera_).FromWorld(x), x);
}

TEST_P(ViewTest, SideViewShowsTheTargetInTheMiddleAndUpUpwards) {
  const Vector3d position(0.1, -0.8, 0.2), target(0.02, 0.03, -0.1);
  const View view = LookAt(camera_, position, target, Vector3d::UnitZ(), "view");
  // The axis of a pinhole is seen where that of the camera above is, at its eye.
  const double offset = camera_.is_pinhole() ? camera_.pixels_per_metre() * camera_.eye_x : 0.0;
  const Vector2d middle(camera_.cx + offset, camera_.cy);
  EXPECT_LT((Project(view, target) - middle).norm(), 1e-9);
  const Vector2d above = Project(view, target + Vector3d(0, 0, 0.01));
  EXPECT_NEAR(above.x(), middle.x(), 1e-9);
  EXPECT_LT(above.y(), middle.y() - 1.0);
  // Seen from the front, along +y, x is to the right.
  EXPECT_GT(Project(view, target + Vector3d(0.01, 0, 0)).x(), middle.x() + 1.0);
  const double z = view.FromWorld(target)[2];
  EXPECT_NEAR(DepthOrigin(camera_) - z, (position - target).norm(), 1e-12);
}

TEST_P(ViewTest, DepthLeadsBackToTheWorld) {
  const View view =
      LookAt(camera_, {0.5, 0.6, 0.3}, {0.0, 0.1, 0.0}, Vector3d(0.1, 0.0, 1.0), "view");
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Vector3d x = 0.1 * RandomVector(3, seed);
    const double depth = DepthOrigin(camera_) - view.FromWorld(x)[2];
    EXPECT_LT((view.WorldFromImage(Project(view, x), depth) - x).norm(), 1e-12);
  }
}

TEST_P(ViewTest, RefusesWhatIsNoView) {
  const auto look = [&](const Vector3d& position, const Vector3d& up) {
    LookAt(camera_, position, Vector3d::Zero(), up, "side.json");
  };
  EXPECT_NO_THROW(look({0, -1, 0}, {0, 0, 1}));
  EXPECT_THROW(look({0, 0, 0}, {0, 0, 1}), InputError);
  EXPECT_THROW(look({0, 0, 1}, {0, 0, 2}), InputError);
  EXPECT_THROW(look({0, -1, std::nan("")}, {0, 0, 1}), InputError);
  View view(camera_);
  view.turn.row(0) *= -1;
  EXPECT_THROW(view.Check("side.json"), InputError);
}

INSTANTIATE_TEST_SUITE_P(Cameras, ViewTest,
                         testing::Values(CameraKind::kOrthographic, CameraKind::kPinhole));

}  // namespace
}  // namespace drape
