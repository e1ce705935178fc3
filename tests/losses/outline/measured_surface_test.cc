// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/measured_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A cloth whose overhang falls by a slope of one half.
ObjSurface Cone(double slope = 0.5) {
  const Mesh mesh = MakeDisc();
  ObjSurface cone{mesh.rest_x, {}};
  for (const Face& face : mesh.faces)
    cone.triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
  for (auto p : cone.x.reshaped(3, mesh.num_vertices()).colwise()) {
    const double r = p.norm(), overhang = std::max(0.0, r - DrapeDiscs().support);
    p.head<2>() *= 1.0 - overhang * (1.0 - std::sqrt(1.0 - slope * slope)) / std::max(r, 1e-9);
    p.z() = -slope * overhang;
  }
  return cone;
}

ObjSurface Moved(ObjSurface surface, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by) {
  auto x = surface.x.reshaped(3, surface.x.size() / 3);
  x = ((turn * x).colwise() + by).eval();
  return surface;
}

Eigen::Matrix3d Inclined(double degrees) {
  return Eigen::AngleAxisd(degrees * M_PI / 180.0, Eigen::Vector3d(1, 2, 0).normalized())
      .toRotationMatrix();
}

TEST(CheckSurface, LeavesALevelDrapeAsItIs) {
  for (const double degrees : {0.0, 1.5}) {
    const ObjSurface drape = Moved(Cone(), Inclined(degrees), {0, 0, 0.7});
    ObjSurface found = drape;
    EXPECT_THAT(CheckSurface(&found, {}, "a.obj"), IsEmpty());
    EXPECT_EQ(found.x, drape.x);
  }
}

TEST(CheckSurface, TurnsAnInclinedDrapeLevel) {
  for (const double height : {0.0, 0.7}) {
    const ObjSurface level = Moved(Cone(), Inclined(0.0), {0, 0, height});
    ObjSurface found = Moved(Cone(), Inclined(20.0), {0, 0, height});
    EXPECT_THAT(CheckSurface(&found, {}, "a.obj"),
                ElementsAre(HasSubstr("was inclined by 20.0 degrees: the mesh is turned level")));
    EXPECT_LT((found.x - level.x).cwiseAbs().maxCoeff(), 1e-4);
  }
}

// A shadow of a drape, without heights.
TEST(CheckSurface, SaysThatClothIsMissing) {
  ObjSurface flat = Cone(0.95);
  for (auto p : flat.x.reshaped(3, flat.x.size() / 3).colwise()) p.z() = 0.0;
  EXPECT_THAT(CheckSurface(&flat, {}, "a.obj"),
              ElementsAre(HasSubstr("cm2 and the flat specimen 707: part of the cloth is not in")));
}

TEST(CheckSurface, RefusesWhatIsNoDrape) {
  ObjSurface wide = Moved(Cone(), 100.0 * Eigen::Matrix3d::Identity(), {0, 0, 0});
  EXPECT_INPUT_ERROR(CheckSurface(&wide, {}, "a.obj"), "a.obj: the mesh is 28.39 m wide");
  ObjSurface upright = Moved(Cone(), Inclined(90.0), {0, 0, 0});
  EXPECT_INPUT_ERROR(CheckSurface(&upright, {}, "a.obj"), "is another axis up?");
}

}  // namespace
}  // namespace drape
