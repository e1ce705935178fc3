// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/scene.h"

#include <gtest/gtest.h>

#include "physics/cloth/assembly/assembly.h"
#include "physics/mesh/mesh_spec.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

TEST(Region, IncludesItsBounds) {
  EXPECT_TRUE(Contains(DiscRegion{0.09}, {0.0, 0.09 * (1 + 1e-14), 0.0}));
  EXPECT_FALSE(Contains(DiscRegion{0.09}, {0.0, 0.09001, 0.0}));
  const RingRegion ring{.inner = 0.1, .outer = 0.2};
  EXPECT_TRUE(Contains(ring, {0.1, 0.0, 0.0}));
  EXPECT_TRUE(Contains(ring, {0.0, -0.2, 0.0}));
  EXPECT_FALSE(Contains(ring, {0.05, 0.0, 0.0}));
  EXPECT_FALSE(Contains(ring, {0.25, 0.0, 0.0}));
  const Eigen::Vector3d centre(0.2, -0.1, 0.0);
  EXPECT_TRUE(Contains(DiscRegion{0.01, centre}, {0.209, -0.1, 0.0}));
  EXPECT_FALSE(Contains(DiscRegion{0.01, centre}, {0.0, 0.0, 0.0}));
  const RingRegion there{.inner = 0.1, .outer = 0.2, .centre = centre};
  EXPECT_TRUE(Contains(there, {0.2, 0.05, 0.0}));
  EXPECT_FALSE(Contains(there, centre));
  const HalfPlaneRegion plane{.normal = -Eigen::Vector3d::UnitX(), .offset = -0.3};
  EXPECT_TRUE(Contains(plane, {0.3, 5.0, 0.0}));
  EXPECT_FALSE(Contains(plane, {0.29, 5.0, 0.0}));
}

TEST(Scene, OnlyADiscIsASupport) {
  EXPECT_EQ(SupportRadius(CusickScene()), 0.09);
  EXPECT_FALSE(SupportRadius(CantileverScene(0.01, 9.81)));
  EXPECT_FALSE(SupportRadius(Scene()));
  Scene scene = CusickScene();
  scene.handles->vertices = {7};
  EXPECT_FALSE(SupportRadius(scene));
  scene.handles->vertices.clear();
  scene.handles->regions.push_back(HalfPlaneRegion());
  EXPECT_FALSE(SupportRadius(scene));
  scene.handles->regions = {DiscRegion{0.09, {0.01, 0.0, 0.0}}};
  EXPECT_FALSE(SupportRadius(scene));
}

// A vertex that is in two regions, or in one and in the list, is held once.
TEST(Scene, HoldsTheUnionOfRegionsAndVertices) {
  Scene scene;
  const Mesh mesh = MakeStrip(0.2, 0.04, 10, 4);
  scene.handles = Handles{.regions = {HalfPlaneRegion{.offset = 0.0}, DiscRegion{0.001},
                                      DiscRegion{0.001, {0.2, 0.02, 0.0}}},
                          .vertices = {3, 0, 3}};
  const ClothModel model(mesh, scene, MakeLaw("smooth"));
  std::vector<int> expected;
  for (int i = 0; i < mesh.num_vertices(); ++i)
    if (mesh.uv(0, i) == 0.0 || (mesh.uv.col(i) - Eigen::Vector2d(0.2, 0.02)).norm() < 1e-9 ||
        i == 3 || i == 0)
      expected.push_back(i);
  EXPECT_EQ(model.held, expected);
  EXPECT_GE(model.held.size(), 7u);
  scene.handles->vertices = {mesh.num_vertices()};
  EXPECT_INPUT_ERROR(ClothModel(mesh, scene, MakeLaw("smooth")), "found the handle of vertex");
}

// The load is even by length: a vertex between two loaded edges carries twice as much as one at the
// corner.
TEST(Scene, LoadsTheEndOfAStripEvenly) {
  const ClothModel model(MakeStrip(0.2, 0.04, 10, 4), UniaxialScene(0.2, 8.0), MakeLaw("smooth"));
  ASSERT_EQ(model.loads.size(), 5u);
  double sum = 0.0;
  for (const VertexLoad& load : model.loads) {
    const bool corner = std::abs(model.mesh.uv(1, load.vertex)) > 0.0199;
    EXPECT_NEAR(load.force.x(), corner ? 1.0 : 2.0, 1e-12);
    EXPECT_EQ(model.mesh.uv(0, load.vertex), 0.2);
    sum += load.force.x();
  }
  EXPECT_NEAR(sum, 8.0, 1e-12);
  EXPECT_EQ(model.held.size(), 5u);
}

TEST(Scene, LoadIsTheGradientOfItsEnergy) {
  const ClothModel model(MakeStrip(0.2, 0.04, 10, 4), UniaxialScene(0.2, 8.0), MakeLaw("smooth"));
  Scene unloaded_scene = model.scene;
  unloaded_scene.load.reset();
  const ClothModel unloaded(model.mesh, unloaded_scene, model.law);
  const MaterialField material = test::TestMaterial();
  const Eigen::VectorXd x = 1.01 * model.mesh.rest_x;
  Eigen::VectorXd force, without;
  AssembleForce(model, material, x, force);
  AssembleForce(unloaded, material, x, without);
  EXPECT_NEAR((force - without).dot(x), Energy(unloaded, material, x) - Energy(model, material, x),
              1e-12);
}

TEST(SceneTerm, ALoadNeedsAHem) {
  EXPECT_INPUT_ERROR(
      ClothModel(MakeStrip(0.2, 0.04, 10, 4), UniaxialScene(0.3, 8.0), MakeLaw("smooth")),
      "found no edge of the hem");
}

TEST(SceneTerm, ASceneWithoutHandlesAndLoadHoldsNothing) {
  const ClothModel model(MakeStrip(0.2, 0.04, 10, 4), Scene(), MakeLaw("smooth"));
  EXPECT_TRUE(model.held.empty());
  EXPECT_TRUE(model.loads.empty());
}

}  // namespace
}  // namespace drape
