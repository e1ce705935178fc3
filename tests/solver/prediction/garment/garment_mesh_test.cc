// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/garment_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/pattern/pattern.h"
#include "solver/prediction/garment/tubes.h"
#include "solver/prediction/garment/wear.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::IsEmpty;

Vector3d At(const Eigen::VectorXd& x, int i) { return x.segment<3>(3 * i); }

// Two panels of 20 × 10 cm with a seam along their short sides, the second turned by 180°.
Pattern TwoPanels(bool same_direction) {
  const PatternLoop outline = {
      {{0, 0}, {.2, 0}}, {{.2, 0}, {.2, .1}}, {{.2, .1}, {0, .1}}, {{0, .1}, {0, 0}}};
  Pattern pattern;
  pattern.panels = {{"a", outline, {}}, {"b", outline, {}}};
  pattern.panels[1].placement.translate(Vector3d(.21, 0, 0));
  pattern.stitches = {{{0, 1}, {1, 3}, same_direction}};
  return pattern;
}

// The largest distance between two vertices that are sewn together [m].
double WidestSeam(const GarmentMesh& garment) {
  double widest = 0;
  for (const auto& [a, b] : garment.stitches)
    widest = std::max(widest, (At(garment.start_x, a) - At(garment.start_x, b)).norm());
  return widest;
}

TEST(GarmentMesh, PairsTheVerticesOfASeam) {
  const GarmentMesh garment = MakeGarmentMesh(TwoPanels(false), .01);
  ASSERT_EQ(garment.stitches.size(), 11u);
  for (const auto& [a, b] : garment.stitches) {
    EXPECT_LT((At(garment.start_x, b) - At(garment.start_x, a) - Vector3d(.01, 0, 0)).norm(), 1e-9);
    EXPECT_LT(a, garment.panel_begin[1]);
    EXPECT_GE(b, garment.panel_begin[1]);
  }
  EXPECT_NEAR(WidestSeam(garment), .01, 1e-9);
  // Begin to begin: the seam is twisted.
  EXPECT_GT(WidestSeam(MakeGarmentMesh(TwoPanels(true), .01)), .1);
}

TEST(GarmentMesh, GivesBothSidesOfAnUnequalSeamAsManyVertices) {
  Pattern pattern = TwoPanels(false);
  pattern.stitches = {{{0, 0}, {1, 1}, false, true}};  // 20 cm and 10 cm
  EXPECT_EQ(MakeGarmentMesh(pattern, .01).stitches.size(), 16u);
}

TEST(GarmentMesh, KeepsPanelsApartInTheClothWithTheirShape) {
  const GarmentMesh garment = MakeGarmentMesh(TwoPanels(false), .01);
  const Mesh& mesh = garment.mesh;
  EXPECT_EQ(mesh.boundary_loops.size(), 2u);
  double area = 0;
  for (const Face& face : mesh.faces) area += face.area;
  EXPECT_NEAR(area, 2 * .2 * .1, 1e-12);
  const int second = garment.panel_begin[1];
  const double right = mesh.uv.row(0).head(second).maxCoeff();
  EXPECT_NEAR(mesh.uv.row(0).tail(mesh.num_vertices() - second).minCoeff(), right + .05, 1e-12);
  for (int i = 0; i < mesh.num_vertices(); ++i)
    EXPECT_EQ(At(mesh.rest_x, i), Vector3d(mesh.uv(0, i), mesh.uv(1, i), 0));
  EXPECT_EQ(MakeGarmentMesh(TwoPanels(false), .01).mesh.uv, mesh.uv);  // the same on every run
}

TEST(GarmentMesh, ClosesATubeOfOnePanelAndSewsCornersOnce) {
  Pattern pattern = TwoPanels(false);
  pattern.panels.pop_back();
  pattern.stitches = {{{0, 1}, {0, 3}}};
  pattern.panels[0].cylinder_radius = .2 / (2 * std::numbers::pi) + .001;
  const GarmentMesh garment = MakeGarmentMesh(pattern, .01);
  EXPECT_EQ(garment.stitches.size(), 11u);
  // Two edges that share a corner: the corner is not sewn to itself.
  pattern.stitches = {{{0, 0}, {0, 1}, false, true}};
  for (const auto& [a, b] : MakeGarmentMesh(pattern, .01).stitches) EXPECT_LT(a, b);
}

TEST(GarmentMesh, RefusesSizesThatDoNotFit) {
  EXPECT_INPUT_ERROR(MakeGarmentMesh(TwoPanels(false), .001), "expected 0.002 … 0.1 m");
  Pattern large = TwoPanels(false);
  for (PatternEdge& edge : large.panels[0].outline) {
    edge.begin *= 20;
    edge.end *= 20;
  }
  EXPECT_INPUT_ERROR(MakeGarmentMesh(large, .002), "expected at most 1000000");
  // A notch that is too narrow at its end.
  Pattern narrow = TwoPanels(false);
  narrow.panels[0].outline = {{{0, 0}, {.2, 0}},
                              {{.2, 0}, {.2, .1}},
                              {{.2, .1}, {1e-12, 1e-12}},
                              {{1e-12, 1e-12}, {0, .1}},
                              {{0, .1}, {0, 0}}};
  EXPECT_INPUT_ERROR(MakeGarmentMesh(narrow, .05, "shirt.json"), "shirt.json: found panel 'a'");
}

// Two triangles that are sewn together all around are one face of a coarse mesh, twice.
TEST(GarmentMesh, RefusesFacesOnOneAnother) {
  Pattern bag = TwoPanels(false);
  for (Panel& panel : bag.panels)
    panel.outline = {{{0, 0}, {.1, 0}}, {{.1, 0}, {.1, .1}}, {{.1, .1}, {0, 0}}};
  bag.stitches = {{{0, 0}, {1, 0}, true}, {{0, 1}, {1, 1}, true}, {{0, 2}, {1, 2}, true}};
  EXPECT_INPUT_ERROR(CheckSeams(MakeGarmentMesh(bag, .1), bag, "bag.json"),
                     "bag.json: found seams that lay a face of panel 'b' on another one");
  EXPECT_NO_THROW(CheckSeams(MakeGarmentMesh(TwoPanels(false), .03), TwoPanels(false), "two"));
}

// The T-shirt has two tubes, from the cuffs of its sleeves; the skirt has none.
TEST(Tubes, BeginAtCuffsOfOneSide) {
  const auto tubes = [](const std::string& name) {
    const SewnGarment sewn =
        Sew(MakeGarmentMesh(
                ReadPattern(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/" + name), .03),
            MakeLaw("smooth"));
    return FindTubes(sewn, DrawSeams(sewn));
  };
  const std::vector<ClothTube> found = tubes("t_shirt.json");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_LT(found[0][0].middle.x() * found[1][0].middle.x(), 0);
  for (const ClothTube& tube : found) {
    ASSERT_GT(tube.size(), 4u);
    EXPECT_GT(std::abs(tube[0].middle.x()), std::abs(tube[3].middle.x()) + .08);
    for (size_t k = 1; k < tube.size(); ++k) EXPECT_GT(tube[k - 1].inner, tube[k].inner);
  }
  EXPECT_THAT(tubes("circle_skirt.json"), IsEmpty());
}

class ShippedGarment : public ::testing::TestWithParam<const char*> {
 protected:
  static Pattern Read() {
    return ReadPattern(std::string(DRAPE_SOURCE_DIR "/configs/garments/") + GetParam() + ".json");
  }
};

TEST_P(ShippedGarment, HasGoodTriangles) {
  const Pattern pattern = Read();
  const GarmentMesh garment = MakeGarmentMesh(pattern, .02);
  double least = 180, mean = 0, area = 0, drawn = 0;
  for (const Face& face : garment.mesh.faces) {
    double smallest = 180;
    for (int k = 0; k < 3; ++k) {
      const Vector2d a = garment.mesh.uv.col(face.vertex[k]);
      const Vector2d u = garment.mesh.uv.col(face.vertex[(k + 1) % 3]) - a;
      const Vector2d v = garment.mesh.uv.col(face.vertex[(k + 2) % 3]) - a;
      smallest =
          std::min(smallest, std::acos(u.dot(v) / (u.norm() * v.norm())) * 180 / std::numbers::pi);
    }
    least = std::min(least, smallest);
    mean += smallest / garment.mesh.num_faces();
    area += face.area;
  }
  for (const Panel& panel : pattern.panels) {
    drawn += LoopArea(panel.outline);
    for (const PatternLoop& hole : panel.holes) drawn += LoopArea(hole);
  }
  EXPECT_GT(least, 18);
  EXPECT_GT(mean, 48);
  EXPECT_NEAR(area / drawn, 1, .01);
  EXPECT_NEAR(std::sqrt(area / garment.mesh.num_faces() * 4 / std::sqrt(3)), .02, .0015);
  EXPECT_EQ(garment.mesh.boundary_loops.size(),
            pattern.panels.size() + (pattern.rings.empty() ? 0 : 1));
}

// No face of the garment, before sewing, meets the body with half its radii, or another face.
TEST_P(ShippedGarment, SurroundsTheShrunkMannequinWithoutTouchingIt) {
  const Pattern pattern = Read();
  const GarmentMesh garment = MakeGarmentMesh(pattern, .02);
  const Mannequin body(MotionKind::kStand, pattern.arm_angle);
  const Eigen::VectorXd body_x = body.Positions(0);
  std::vector<std::array<int, 3>> triangles = body.triangles();
  for (std::array<int, 3> triangle : ListTriangles(garment.mesh)) {
    for (int& i : triangle) i += body.num_vertices();
    triangles.push_back(triangle);
  }
  Eigen::VectorXd x(body_x.size() + garment.start_x.size());
  x << body_x, garment.start_x;
  EXPECT_THAT(FindSelfIntersections(triangles, x), IsEmpty());
  double nearest = 1;
  for (int i = 0; i < garment.mesh.num_vertices(); ++i)
    for (int j = 0; j < body.num_vertices(); ++j)
      nearest = std::min(nearest, (At(garment.start_x, i) - At(body_x, j)).norm());
  EXPECT_GT(nearest, .008);
  EXPECT_LT(WidestSeam(garment), .4);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedGarment,
                         ::testing::Values("circle_skirt", "tank_dress", "t_shirt"));

class GarmentFile : public FileFixture {};

TEST_F(GarmentFile, IsAnObjWithThePatternAsUv) {
  const GarmentMesh garment =
      MakeGarmentMesh(ReadPattern(DRAPE_SOURCE_DIR "/configs/garments/t_shirt.json"), .03);
  WriteObj(Path("garment.obj"), garment.mesh, garment.start_x);
  const Mesh read = ReadObj(Path("garment.obj"));
  EXPECT_EQ(read.rest_x, garment.start_x);
  EXPECT_EQ(read.uv, garment.mesh.uv);
  EXPECT_EQ(read.num_faces(), garment.mesh.num_faces());
}

TEST(CircleSkirt, TheGrownBodyFitsIntoTheWaistband) {
  const GarmentMesh skirt =
      MakeGarmentMesh(ReadPattern(DRAPE_SOURCE_DIR "/configs/garments/circle_skirt.json"), .02);
  ASSERT_EQ(skirt.rings.size(), 1u);
  EXPECT_EQ(skirt.rings[0].name, "waist");
  EXPECT_TRUE(skirt.rings[0].held_by_pelvis);
  EXPECT_EQ(skirt.rings[0].vertices.size(), 36u);  // 4 · round(.1728 / .02)
  const Mannequin mannequin(MotionKind::kStand);
  const Eigen::VectorXd grown = mannequin.PositionsInPose({}, 1);
  const Contact body{.thickness = 0,
                     .obstacles = {std::make_shared<const SurfaceObstacle>(
                         grown.reshaped(3, mannequin.num_vertices()), mannequin.triangles())}};
  for (const int i : skirt.rings[0].vertices) {
    EXPECT_NEAR(At(skirt.start_x, i).head<2>().norm(), .11, 1e-9);
    EXPECT_GT(SmallestGap(body, At(skirt.start_x, i)), .005);
  }
}

TEST(CircleSkirt, TheWaistbandKeepsClearOfTheMovingBody) {
  const Pattern pattern = ReadPattern(DRAPE_SOURCE_DIR "/configs/garments/circle_skirt.json");
  const GarmentMesh skirt = MakeGarmentMesh(pattern, .03);
  for (const auto& [kind, name] : EnumNames(MotionKind())) {
    const Mannequin body(kind, pattern.arm_angle);
    double nearest = 1;
    for (int k = 0; k < 20; ++k) {
      const double t = 1.25 + .131 * k;
      const Eigen::VectorXd x = body.Positions(t);
      const Eigen::Isometry3d motion = body.PelvisMotion(t);
      for (const int i : skirt.rings.at(0).vertices) {
        const Vector3d held = motion * At(skirt.start_x, i);
        for (int j = 0; j < body.num_vertices(); ++j)
          nearest = std::min(nearest, (held - At(x, j)).norm());
      }
    }
    EXPECT_GT(nearest, .006) << name;
  }
}

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
