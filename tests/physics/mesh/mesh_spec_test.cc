// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/mesh_spec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

TEST(Strip, FillsTheRectangle) {
  for (const auto& [n, m] : {std::pair(1, 1), {3, 1}, {3, 2}, {40, 7}, {10, 12}}) {
    const Mesh mesh = MakeStrip(.3, .05, n, m);
    double area = 0;
    for (const Face& face : mesh.faces) area += face.area;
    EXPECT_NEAR(area, .3 * .05, 1e-15);
    EXPECT_EQ(mesh.num_faces(), m * (2 * n + 1));
    EXPECT_EQ(mesh.num_vertices(), (m + 1) * (n + 1) + (m + 1) / 2);
    EXPECT_EQ(mesh.uv.row(0).minCoeff(), 0);
    EXPECT_EQ(mesh.uv.row(0).maxCoeff(), .3);
    EXPECT_EQ(mesh.uv.row(1).minCoeff(), -.025);
    EXPECT_EQ(mesh.uv.row(1).maxCoeff(), .025);
    EXPECT_EQ(mesh.rest_x[3 * mesh.num_vertices() - 1], 0);
    EXPECT_EQ(mesh.boundary_loops.size(), 1u);
  }
}

TEST(Strip, FavoursNoDirectionWhenEquilateral) {
  const Mesh mesh = MakeStrip(1, .5 * std::sqrt(3.), 20, 20);
  std::complex<double> second = 0, fourth = 0;
  for (const Hinge& hinge : mesh.hinges) {
    const Eigen::Vector2d d = mesh.uv.col(hinge.vertex[1]) - mesh.uv.col(hinge.vertex[0]);
    const double angle = std::atan2(d.y(), d.x());
    if (d.norm() < .049) continue;  // the half triangles at the ends
    second += std::polar(1., 2 * angle);
    fourth += std::polar(1., 4 * angle);
  }
  EXPECT_LT(std::abs(second) / mesh.num_hinges(), .03);  // there is one row of edges less along u
  EXPECT_LT(std::abs(fourth) / mesh.num_hinges(), .03);
}

TEST(Strip, IsMirroredEndToEnd) {
  const Mesh mesh = MakeStrip(1, .3, 10, 3);
  EXPECT_NEAR(mesh.uv.row(0).mean(), .5, 1e-15);
  double moment = 0;
  for (const Hinge& h : mesh.hinges) {
    const double u = (mesh.uv(0, h.vertex[0]) + mesh.uv(0, h.vertex[1])) / 2;
    moment += (u - .5) * h.rest_length;
  }
  EXPECT_NEAR(moment, 0, 1e-13);
}

TEST(StripDeathTest, RefusesEmptyStrips) {
  EXPECT_DEATH(MakeStrip(0, 1, 1, 1), "Check failed");
  EXPECT_DEATH(MakeStrip(1, 1, 1, 0), "Check failed");
}

using MeshSpec = FileFixture;

TEST_F(MeshSpec, MakesDiscs) {
  EXPECT_EQ(ParseMeshSpec("disc:300").num_vertices(), 300);
  EXPECT_NEAR(HemRadius(ParseMeshSpec("disc:300", {}, {0.12, 0.07})), 0.12, 1e-12);
  EXPECT_NEAR(HemRadius(ParseMeshSpec("disc:300,radius=0.1", {}, {0.12, 0.07})), 0.1, 1e-12);
  const Mesh mesh = ParseMeshSpec("disc:300,support=0.05,radius=0.1");
  EXPECT_NEAR(mesh.uv.colwise().norm().maxCoeff(), .1, 1e-15);
  EXPECT_LT((mesh.uv.colwise().norm().array() - .05).abs().minCoeff(), 1e-15);
}

TEST_F(MeshSpec, ReadsFiles) {
  const std::string path = Write("a.obj", "v 0 0 0\nv .1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(ParseMeshSpec(path).uv(0, 1), .1);
  EXPECT_EQ(ParseMeshSpec(path, {.round_to_float = true}).uv(0, 1), double{.1f});
  EXPECT_INPUT_ERROR(ParseMeshSpec(Path("b.obj")), "b.obj: no such file");
}

TEST_F(MeshSpec, NamesThePartThatIsWrong) {
  EXPECT_INPUT_ERROR(ParseMeshSpec("strip:0.2x0.1"), "expected strip:LENGTHxWIDTHxALONG");
  EXPECT_INPUT_ERROR(ParseMeshSpec("strip:0.2x-0.1x8"), "length or width out of range");
  EXPECT_INPUT_ERROR(ParseMeshSpec("strip:0.2x0.1x0"), "found 0 edges along");
  EXPECT_INPUT_ERROR(ParseMeshSpec("strip:0.2x0.1x99999"), "less than a million triangles");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:"),
                     "disc:: found '', expected a whole number of vertices");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:1e3"), "disc:1e3: found '1e3', expected a whole number");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:300,radius"), "found 'radius', expected radius=…");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:300,r=1"), "found 'r=1', expected radius=…");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:300,radius=1m"),
                     "found '1m', expected a number of metres");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:300,,radius=1"), "found '', expected radius=…");
  EXPECT_INPUT_ERROR(ParseMeshSpec("disc:5"), "disc: 5 vertices, expected 100..");
}

// The rigidity of bent sheets by the hinge formula with B = 4·D on the built-in meshes
// [MODEL, M3, M54].

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
