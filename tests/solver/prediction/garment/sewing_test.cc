// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "solver/prediction/garment/garment_mesh.h"
#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {
namespace {

GarmentMesh Meshed(const std::string& name) {
  return MakeGarmentMesh(
      ReadPattern(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/" + name + ".json"), 0.04);
}

TEST(Sewing, StitchedVerticesAreOne) {
  const GarmentMesh garment = Meshed("t_shirt");
  const SewnGarment sewn = Sew(garment, MakeLaw("smooth"));
  for (const auto& [a, b] : garment.stitches) EXPECT_EQ(sewn.vertex_of[a], sewn.vertex_of[b]);
  const std::set<int> numbers(sewn.vertex_of.begin(), sewn.vertex_of.end());
  const int count = sewn.model->mesh.num_vertices();
  EXPECT_EQ(static_cast<int>(numbers.size()), count);
  EXPECT_EQ(*numbers.rbegin(), count - 1);
  EXPECT_LT(count, garment.mesh.num_vertices());
  EXPECT_EQ(sewn.model->mesh.num_faces(), garment.mesh.num_faces());
}

TEST(Sewing, KeepsTheWeightOfThePanels) {
  const GarmentMesh garment = Meshed("tank_dress");
  const SewnGarment sewn = Sew(garment, MakeLaw("smooth"));
  double area = 0.0;
  for (const Face& face : garment.mesh.faces) area += face.area;
  EXPECT_NEAR(sewn.model->vertex_area.sum(), area, 1e-12);
}

TEST(Sewing, JoinedVerticesBeginBetweenThePanels) {
  const GarmentMesh garment = Meshed("tank_dress");
  const SewnGarment sewn = Sew(garment, MakeLaw("smooth"));
  const auto [a, b] = garment.stitches.front();
  const Eigen::Vector3d middle =
      0.5 * (garment.start_x.segment<3>(3 * a) + garment.start_x.segment<3>(3 * b));
  EXPECT_LT((sewn.start_x.segment<3>(3 * sewn.vertex_of[a]) - middle).norm(), 1e-12);
}

TEST(Sewing, TheWaistbandIsHeld) {
  const GarmentMesh garment = Meshed("circle_skirt");
  const SewnGarment sewn = Sew(garment, MakeLaw("smooth"));
  ASSERT_EQ(garment.rings.size(), 1u);
  EXPECT_EQ(sewn.held_by_pelvis.size(), garment.rings[0].vertices.size());
  for (const int i : sewn.held_by_pelvis)
    EXPECT_NEAR(sewn.start_x.segment<2>(3 * i).norm(), 0.11, 0.005);
}

}  // namespace
}  // namespace drape
