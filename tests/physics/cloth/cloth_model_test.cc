// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/cloth_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "physics/mesh/disc.h"

namespace drape {
namespace {

constexpr double kSupport = 0.09;

bool IsHeld(const Mesh& mesh, int face) {
  for (const int i : mesh.faces[face].vertex)
    if (mesh.uv.col(i).norm() > kSupport + 1e-9) return false;
  return true;
}

// [MODEL, M26]: only hinges between a held and a free face lose the area of the held one.
TEST(ClothModel, HingesAtTheClampBendOverTheFreeFaceAlone) {
  const Mesh mesh = MakeDisc({.support_radius = kSupport, .target_vertices = 300});
  const ClothModel smooth(mesh, CusickScene(), MakeLaw("smooth"));
  const ClothModel reference(mesh, CusickScene(), MakeLaw("reference"));
  double clamped_length = 0.0;
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    const Hinge& hinge = mesh.hinges[e];
    const bool first = IsHeld(mesh, hinge.face[0]), second = IsHeld(mesh, hinge.face[1]);
    double expected = hinge.rest_area;
    if (first != second) {
      expected = mesh.faces[hinge.face[first ? 1 : 0]].area;
      clamped_length += hinge.rest_length;
    }
    EXPECT_EQ(smooth.mesh.hinges[e].rest_area, expected);
    EXPECT_EQ(reference.mesh.hinges[e].rest_area, hinge.rest_area);
  }
  EXPECT_NEAR(clamped_length, 2 * M_PI * kSupport, 0.005 * kSupport * 2 * M_PI);
}

TEST(ClothModel, WithoutHandlesNothingIsClamped) {
  const Mesh mesh = MakeDisc({.target_vertices = 300});
  const ClothModel model(mesh, Scene(), MakeLaw("smooth"));
  for (int e = 0; e < mesh.num_hinges(); ++e)
    EXPECT_EQ(model.mesh.hinges[e].rest_area, mesh.hinges[e].rest_area);
}

}  // namespace
}  // namespace drape
