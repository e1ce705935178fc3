// SPDX-License-Identifier: Apache-2.0
// What the hinge formula with B = 4·D makes of a bent sheet on the meshes that we generate
// (SPEC sections 3 and 7). The energy of a hinge is written out here, apart from the force law.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "physics/disc.h"
#include "physics/strip.h"

namespace drape {
namespace {

// Energy of the surface z = ε/2 uvᵀ·curvature·uv, summed over hinges with D = 1 (W = B
// l²θ²/(8(A0+A1))), divided by area·ε²/2: the rigidity for bending about one axis, 2(1 + ν) times
// it for curvature I.
double HingeRigidity(const Mesh& mesh, const Eigen::Matrix2d& curvature) {
  constexpr double kSmall = 1e-4;
  const auto point = [&](int i) {
    const Eigen::Vector2d u = mesh.uv.col(i);
    return Eigen::Vector3d(u.x(), u.y(), kSmall / 2 * u.dot(curvature * u));
  };
  double energy = 0, area = 0;
  for (const Face& face : mesh.faces) area += face.area;
  for (const Hinge& hinge : mesh.hinges) {
    const Eigen::Vector3d a = point(hinge.vertex[0]), b = point(hinge.vertex[1]);
    const Eigen::Vector3d n0 = (b - a).cross(point(hinge.vertex[2]) - a).normalized();
    const Eigen::Vector3d n1 = (point(hinge.vertex[3]) - a).cross(b - a).normalized();
    const double theta = std::asin(n0.cross(n1).norm());
    energy += 4 * hinge.rest_length * hinge.rest_length * theta * theta / (8 * hinge.rest_area);
  }
  return energy / (area * kSmall * kSmall / 2);
}

Eigen::Matrix2d Symmetric(double uu, double uv, double vv) {
  return (Eigen::Matrix2d() << uu, uv, uv, vv).finished();
}

TEST(MeshRigidity, DiscsBendAsAPlateOfRigidityD) {
  for (const int vertices : {300, 1200, 5000}) {
    const Mesh mesh = MakeDisc({.target_vertices = vertices});
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(1, 0, 0)), 1, .02) << vertices;
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(0, 0, 1)), 1, .02) << vertices;
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(.5, .5, .5)), 1, .02) << vertices;
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(.5, -.5, .5)), 1, .02) << vertices;
    // Poisson ratio −1/3: a dome costs 2(1 + ν) = 4/3, a saddle 2(1 − ν) = 8/3.
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(1, 0, 1)), 4. / 3, .03) << vertices;
    EXPECT_NEAR(HingeRigidity(mesh, Symmetric(1, 0, -1)), 8. / 3, .06) << vertices;
  }
}

TEST(MeshRigidity, StripsAreSofterByTheirFreeEdgesAsStated) {
  for (const auto& [n_along, n_across] : {std::pair(100, 4), {100, 5}, {100, 12}, {400, 12}}) {
    const double width = n_across * std::sqrt(.75) / n_along;
    const double rigidity =
        HingeRigidity(MakeStrip(1, width, n_along, n_across), Symmetric(1, 0, 0));
    EXPECT_NEAR(rigidity, 1 - 1. / (9 * n_across) - .648 / n_along, 2e-4) << n_across;
  }
}

}  // namespace
}  // namespace drape
