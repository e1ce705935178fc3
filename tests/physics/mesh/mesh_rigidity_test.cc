// SPDX-License-Identifier: Apache-2.0
// The rigidity of bent sheets by the hinge formula with B = 4·D on the built-in meshes
// [MODEL, M3, M54].
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "tests/physics/simulation/textbook/closed_forms.h"

namespace drape {
namespace {

Eigen::Matrix2d Symmetric(double uu, double uv, double vv) {
  return (Eigen::Matrix2d() << uu, uv, uv, vv).finished();
}

TEST(MeshRigidity, DiscsBendAsAPlateOfRigidityD) {
  for (const int vertices : {300, 1200, 5000}) {
    const Mesh mesh = MakeDisc({.target_vertices = vertices});
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(1, 0, 0)), 1, .02) << vertices;
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(0, 0, 1)), 1, .02) << vertices;
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(.5, .5, .5)), 1, .02) << vertices;
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(.5, -.5, .5)), 1, .02) << vertices;
    // With Poisson ratio −1/3 a dome has 2(1 + ν) = 4/3 and a saddle 2(1 − ν) = 8/3.
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(1, 0, 1)), 4. / 3, .03) << vertices;
    EXPECT_NEAR(CurvatureRigidity(mesh, Symmetric(1, 0, -1)), 8. / 3, .06) << vertices;
  }
}

TEST(MeshRigidity, StripsAreSofterByTheirFreeEdgesAsStated) {
  for (const auto& [n_along, n_across] : {std::pair(100, 4), {100, 5}, {100, 12}, {400, 12}}) {
    const double width = n_across * std::sqrt(.75) / n_along;
    const double rigidity =
        CurvatureRigidity(MakeStrip(1, width, n_along, n_across), Symmetric(1, 0, 0));
    EXPECT_NEAR(rigidity, 1 - 1. / (9 * n_across) - .648 / n_along, 2e-4) << n_across;
  }
}

// A strip that is free to curl bends as a beam of D(1 − ν²): the missing hinges of the edges would
// then carry no load, and only the two ends are softer.
TEST(MeshRigidity, StripsThatAreFreeToCurlBendAsBeams) {
  for (const auto& [n_along, n_across] : {std::pair(100, 4), {100, 12}, {400, 12}}) {
    const double width = n_across * std::sqrt(.75) / n_along;
    EXPECT_NEAR(BeamRigidity(MakeStrip(1, width, n_along, n_across)),
                (1 - kHingePoisson * kHingePoisson) * (1 - .62 / n_along), 1e-3);
  }
}

}  // namespace
}  // namespace drape
