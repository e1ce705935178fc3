// SPDX-License-Identifier: Apache-2.0
#include "cuda/make_backend.h"

#include <gmock/gmock.h>

#include "cuda/engine/cuda_backend.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/util/errors.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

std::shared_ptr<const ClothModel> DiscAmong(const std::vector<Obstacle>& obstacles) {
  Scene scene = CusickScene();
  scene.contact = Contact{.obstacles = obstacles};
  return std::make_shared<const ClothModel>(MakeDisc({.target_vertices = 100}), scene,
                                            MakeLaw("smooth"));
}

std::string WhyNot(const std::shared_ptr<const ClothModel>& model) {
  try {
    MakeBackend("cuda", model, 1);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(MakeBackend, ContactOfTheClothWithItselfIsForTheCpuAlone) {
  const auto model = std::make_shared<const ClothModel>(
      MakeDisc({.target_vertices = 100}), CusickScene({ContactModel::kSelf}), MakeLaw("smooth"));
  EXPECT_THAT(WhyNot(model), testing::HasSubstr("expected cpu for contact of the cloth"));
  std::string device;
  EXPECT_EQ(MakeBackend("auto", model, 1, &device)->name(), "cpu");
  EXPECT_EQ(device, "1 CPU thread, on which alone contact of the cloth with itself runs");
}

TEST(MakeBackend, ObstaclesAreForAnyDevice) {
  const test::ClosedMesh ball = test::MakeBall(0.05, 2);
  const auto model = DiscAmong({PlaneObstacle{.offset = -1.0}, SphereObstacle{}, CapsuleObstacle{},
                                PlateObstacle{.top = {0.0, 0.0, -0.001}},
                                std::make_shared<SurfaceObstacle>(ball.x, ball.triangles)});
  const CudaSurvey survey = SurveyCuda();
  if (survey.usable) {
    EXPECT_EQ(WhyNot(model), "");
  } else {
    EXPECT_THAT(WhyNot(model), testing::HasSubstr(survey.text));
  }
  EXPECT_EQ(MakeBackend("auto", model, 1)->name(), survey.usable ? "cuda" : "cpu");
}

}  // namespace
}  // namespace drape
