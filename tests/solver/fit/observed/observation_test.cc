// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/observation.h"

#include <gtest/gtest.h>

#include "solver/fit/rollout_residuals.h"
#include "tests/losses/image/photograph.h"
#include "tests/losses/temp_folder.h"
#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

Observation ObserveStar(const Camera& camera) {
  Observation observation;
  observation.image = StarSilhouette(camera);
  observation.camera = camera;
  observation.radius = *observation.MeasureRadius(45);
  return observation;
}

// A photograph of any resolution gives the outline and the error of the published scale.
TEST(Observation, ComparesOutlinesAtThePublishedScale) {
  const test::FakeBackend backend;
  const MaterialField material = test::TestMaterial();
  const Eigen::VectorXd drape = backend.Shape(material);
  const Observation published = ObserveStar(Camera());
  const Observation photograph = ObserveStar(PhotographCamera());
  ASSERT_GT(photograph.camera.scale, 2 * published.camera.scale);
  EXPECT_LT((photograph.radius - published.radius).cwiseAbs().maxCoeff(), 0.25);
  const double error = *Misfit(*published.Measured(), backend.model(), material, drape);
  EXPECT_GT(error, 1);
  EXPECT_NEAR(*Misfit(*photograph.Measured(), backend.model(), material, drape), error, 0.05);
}

// Pictures that are mirror images or turns of each other have one radius where the warp is turned
// with them, and the outline of a drape is where the picture has it.
TEST(Observation, LaysTheClothToTheOutline) {
  const TempFolder folder;
  const auto backend = test::SmoothDisc(150);
  const State drape =
      test::Settled(*backend, test::TestMaterial(), test::RandomStart(backend->model(), 1));
  const GrayImage image = test::MakeObservation(backend->model().mesh, drape, 72, "drape").image;
  const auto read = [&](const GrayImage& picture, const std::string& warp) {
    WritePng(picture, folder / "a.png");
    return ReadImageObservation(folder / "a.png", {.angles = 72, .warp = warp});
  };
  const Observation up = read(image, "up");
  EXPECT_EQ(up.warp, 90);
  EXPECT_EQ(read(image, "unknown").radius, up.radius);
  for (const bool mirrored : {false, true})
    for (int quarters = 0; quarters < 4; ++quarters) {
      const Observation seen =
          read(test::QuarterTurned(image, quarters, mirrored), quarters % 2 == 0 ? "up" : "right");
      EXPECT_LT((seen.radius - up.radius).cwiseAbs().maxCoeff(), 1e-9) << quarters << mirrored;
      EXPECT_LT((seen.Mirrored().radius - up.Mirrored().radius).cwiseAbs().maxCoeff(), 1e-9);
    }
  const Observation turned = read(image, "70");
  const Mesh& mesh = backend->model().mesh;
  for (const Observation& seen : {turned, turned.Mirrored()}) {
    Outline in_cloth, in_image;
    ASSERT_TRUE(OutlineFromMesh(mesh, drape.x, seen.outline_camera(), 360, &in_cloth));
    ASSERT_TRUE(OutlineFromMesh(mesh, seen.InImage(drape.x), seen.camera, 360, &in_image));
    for (const int k : {0, 7, 200}) {
      const int there = seen.pose.degrees + (seen.pose.mirrored ? -k : k);
      EXPECT_NEAR(in_cloth.radius[k], in_image.radius[(there + 720) % 360], 1e-9);
    }
    EXPECT_EQ(seen.radius, *seen.MeasureRadius(72));
    const double along_warp = (seen.pose.degrees + (seen.pose.mirrored ? -90 : 90) + 360) % 180;
    EXPECT_EQ(along_warp, 70);
  }
}

// What a pinhole beside the axis sees of a drape does not depend on the frame of its cloth.
TEST(Observation, TurnsThePinholeWithTheCloth) {
  Observation observation;
  observation.camera.kind = CameraKind::kPinhole;
  observation.camera.eye_x = 0.2;
  observation.camera.eye_y = -0.1;
  observation.pose = {.degrees = 30, .mirrored = true};
  const Eigen::Vector3d x(0.1, 0.07, -0.06);
  const Eigen::Vector3d in_image = observation.InImage(x);
  Eigen::Vector2d there, here;
  observation.camera.Project(in_image.data(), there.data());
  observation.outline_camera().Project(x.data(), here.data());
  const Eigen::Vector2d centre(observation.camera.cx, observation.camera.cy);
  const Eigen::Vector3d offset(here.x() - centre.x(), centre.y() - here.y(), 0.0);
  const Eigen::Vector3d expected(there.x() - centre.x(), centre.y() - there.y(), 0.0);
  EXPECT_LT((Eigen::Vector3d(observation.InImage(offset)) - expected).norm(), 1e-9);
}

}  // namespace
}  // namespace drape
