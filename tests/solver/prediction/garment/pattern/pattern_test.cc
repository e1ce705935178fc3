// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <gmock/gmock.h>

#include <numbers>
#include <string>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;
using ::testing::HasSubstr;

PatternLoop Polygon(const std::vector<Vector2d>& corners) {
  PatternLoop loop;
  for (size_t i = 0; i < corners.size(); ++i)
    loop.push_back({corners[i], corners[(i + 1) % corners.size()]});
  return loop;
}

Panel Square(const std::string& name, double side = 1) {
  return {name, Polygon({{0, 0}, {side, 0}, {side, side}, {0, side}}), {}};
}

TEST(PatternEdge, CurvesHaveTheirLengthsAndEnds) {
  const PatternEdge line{{0, 0}, {3, 4}};
  EXPECT_NEAR(line.Length(), 5, 1e-12);
  const PatternEdge quarter = MakeArc({1, 0}, {0, 1}, 1, false, true);
  EXPECT_NEAR(quarter.Length(), pi / 2, 1e-5);
  EXPECT_LT((quarter.At(.5) - Vector2d(std::sqrt(.5), std::sqrt(.5))).norm(), 1e-12);
  EXPECT_EQ(quarter.At(1), Vector2d(0, 1));
  // The other way round the circle about (1, 1), and the long way about the origin.
  EXPECT_LT((MakeArc({1, 0}, {0, 1}, 1, false, false).At(.5) -
             Vector2d(1 - std::sqrt(.5), 1 - std::sqrt(.5)))
                .norm(),
            1e-12);
  EXPECT_NEAR(MakeArc({1, 0}, {0, 1}, 1, true, false).Length(), 1.5 * pi, 1e-4);
  // A parabola: y = x (1 − x) · 2 with the control point (½, 1).
  const PatternEdge parabola{{0, 0}, {1, 0}, {{.5, 1}}};
  EXPECT_LT((parabola.At(.25) - Vector2d(.25, .375)).norm(), 1e-12);
  const PatternEdge cubic{{0, 0}, {1, 0}, {{0, 1}, {1, 1}}};
  EXPECT_LT((cubic.At(.5) - Vector2d(.5, .75)).norm(), 1e-12);
}

TEST(PatternEdge, IsDividedIntoEqualParts) {
  const PatternEdge edge{{0, 0}, {1, 0}, {{.9, .1}, {1, .8}}};
  // So many that chords are as long as the curve.
  const auto points = edge.Divided(200);
  ASSERT_EQ(points.size(), 201u);
  EXPECT_EQ(points.front(), edge.begin);
  EXPECT_EQ(points.back(), edge.end);
  const double part = edge.Length() / 200;
  for (int i = 0; i < 200; ++i) EXPECT_NEAR((points[i + 1] - points[i]).norm() / part, 1, 2e-3);
}

TEST(Panel, IsPlacedFlatOrOnACylinder) {
  Panel panel = Square("p");
  panel.placement.translate(Eigen::Vector3d(0, 0, 5));
  EXPECT_LT((panel.Place({.3, .2}) - Eigen::Vector3d(.3, .2, 5)).norm(), 1e-12);
  panel.cylinder_radius = .5;
  EXPECT_LT((panel.Place({0, .2}) - Eigen::Vector3d(0, .2, 5)).norm(), 1e-12);
  EXPECT_LT((panel.Place({pi / 4, .2}) - Eigen::Vector3d(.5, .2, 4.5)).norm(), 1e-12);
}

TEST(LoopArea, IsSigned) {
  EXPECT_NEAR(LoopArea(Square("p").outline), 1, 1e-12);
  EXPECT_NEAR(LoopArea(Polygon({{0, 1}, {1, 1}, {1, 0}, {0, 0}})), -1, 1e-12);
  const PatternLoop disc = {MakeArc({1, 0}, {-1, 0}, 1, false, true),
                            MakeArc({-1, 0}, {1, 0}, 1, false, true)};
  EXPECT_NEAR(LoopArea(disc), pi, .01);
}

TEST(FindProblem, AcceptsAGoodPattern) {
  Pattern pattern;
  pattern.panels = {Square("a"), Square("b", 1.04)};
  pattern.panels[0].holes = {Polygon({{.6, .6}, {.6, .4}, {.4, .4}})};
  pattern.stitches = {{{0, 1}, {1, 3}}};
  EXPECT_EQ(FindProblem(pattern).key, "");
}

TEST(FindProblem, NamesEdgesThatCross) {
  Pattern pattern;
  pattern.panels = {{"bow", Polygon({{0, 0}, {1, 0}, {0, .8}, {1, 1}}), {}}};
  PatternProblem problem = FindProblem(pattern);
  EXPECT_EQ(problem.key, "panels.bow");
  EXPECT_THAT(problem.found, HasSubstr("edges 1 and 3"));
  // A curve that bulges through the opposite side, and one with a loop.
  pattern.panels = {Square("bulge")};
  pattern.panels[0].outline[0].control = {{.5, 2.5}};
  EXPECT_THAT(FindProblem(pattern).found, HasSubstr("edges 0 and 2"));
  pattern.panels = {Square("loop")};
  pattern.panels[0].outline[0].control = {{3, -2}, {-2, -2}};
  EXPECT_THAT(FindProblem(pattern).found, HasSubstr("edges 0 and 0"));
  pattern.panels = {Square("hole")};
  pattern.panels[0].holes = {Polygon({{.6, .6}, {1.5, .5}, {.5, .5}})};
  EXPECT_THAT(FindProblem(pattern).found, HasSubstr("which cross"));
  pattern.panels[0].holes = {Polygon({{6, 6}, {6, 5}, {5, 5}})};
  EXPECT_THAT(FindProblem(pattern).found, HasSubstr("outside the outline"));
}

TEST(FindProblem, ComparesTheSidesOfASeam) {
  Pattern pattern;
  pattern.panels = {Square("a"), Square("b", 1.07)};
  pattern.stitches = {{{0, 1}, {1, 3}}};
  EXPECT_EQ(FindProblem(pattern).key, "stitches[0]");
  EXPECT_THAT(FindProblem(pattern).found,
              HasSubstr("edge 1 of 'a' of 1 m and edge 3 of 'b' of 1.07 m"));
  pattern.stitches[0].ease = true;
  EXPECT_EQ(FindProblem(pattern).key, "");
  pattern.stitches.push_back({{0, 0}, {1, 3}, false, true});
  EXPECT_THAT(FindProblem(pattern).found, HasSubstr("edge 3 of 'b' a second time"));
}

TEST(FindProblem, RefusesPanelsThatOverlapThemselvesOnTheirCylinder) {
  Pattern pattern;
  pattern.panels = {Square("a")};
  pattern.panels[0].cylinder_radius = .3;
  EXPECT_EQ(FindProblem(pattern).key, "panels.a.cylinder_radius");
  pattern.panels[0].cylinder_radius = .32;
  EXPECT_EQ(FindProblem(pattern).key, "");
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A bag of two panels, one with a hole.
constexpr char kBag[] = R"({
  "format": "drapefit-garment", "version": 1, "name": "bag", "arm_angle": 80,
  "panels": {
    "back": {
      "vertices": [[0, 0], [0.4, 0], [0.4, 0.3], [0, 0.3]],
      "outline": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
                  {"endpoints": [3, 0]}],
      "translation": [0, 0.1, 1], "rotation": [90, 0, 180], "cylinder_radius": 0.2
    },
    "front": {
      "vertices": [[0, 0], [0.4, 0], [0.4, 0.3], [0, 0.3], [0.1, 0.1], [0.2, 0.1]],
      "outline": [{"endpoints": [0, 1], "quadratic": [[0.2, -0.1]]}, {"endpoints": [1, 2]},
                  {"endpoints": [2, 3], "cubic": [[0.3, 0.4], [0.1, 0.4]]},
                  {"endpoints": [3, 0]}],
      "holes": [[
        {"endpoints": [4, 5], "circle": {"radius": 0.05, "counter_clockwise": false}},
        {"endpoints": [5, 4], "circle": {"radius": 0.06, "large": true,
                                         "counter_clockwise": false}}]],
      "translation": [0, -0.1, 1], "rotation": [90, 0, 0]
    }
  },
  "stitches": [{"edges": [["front", 1], ["back", 3]]},
               {"edges": [["front", 3], ["back", 1]], "same_direction": true, "ease": true}],
  "rings": [{"name": "waist", "panel": "front", "edges": [4, 5], "held_by": "pelvis"}]
})";

class PatternIoTest : public FileFixture {
 protected:
  Pattern Parse(const std::string& text) const { return ReadPattern(Write("a.json", text)); }
};

TEST_F(PatternIoTest, ReadsOurFormat) {
  const Pattern pattern = Parse(kBag);
  EXPECT_EQ(pattern.name, "bag");
  EXPECT_NEAR(pattern.arm_angle, 80 * std::numbers::pi / 180, 1e-12);
  ASSERT_EQ(pattern.panels.size(), 2u);
  const Panel &back = pattern.panels[0], &front = pattern.panels[1];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.num_edges(), 6);
  EXPECT_EQ(front.edge(0).control, (std::vector<Vector2d>{{.2, -.1}}));
  EXPECT_EQ(front.edge(2).control, (std::vector<Vector2d>{{.3, .4}, {.1, .4}}));
  EXPECT_NEAR(front.edge(4).arc_angle, -std::numbers::pi, 1e-6);
  EXPECT_LT(front.edge(5).arc_angle, -std::numbers::pi);
  // The outer side of the front faces −y, that of the back +y.
  EXPECT_LT((front.Place({.1, .2}) - Vector3d(.1, -.1, 1.2)).norm(), 1e-12);
  EXPECT_LT((front.placement.linear().col(2) + Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((back.placement.linear().col(2) - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_EQ(back.cylinder_radius, .2);
  ASSERT_EQ(pattern.stitches.size(), 2u);
  EXPECT_EQ(pattern.stitches[0].first.panel, 1);
  EXPECT_EQ(pattern.stitches[0].second.edge, 3);
  EXPECT_FALSE(pattern.stitches[0].same_direction);
  EXPECT_TRUE(pattern.stitches[1].same_direction && pattern.stitches[1].ease);
  ASSERT_EQ(pattern.rings.size(), 1u);
  EXPECT_TRUE(pattern.rings[0].held_by_pelvis);
  EXPECT_EQ(pattern.rings[0].edges, (std::vector<int>{4, 5}));
}

TEST_F(PatternIoTest, NamesThePlaceOfAnError) {
  const auto expect = [this](const std::string& from, const std::string& to,
                             const std::string& message) {
    EXPECT_INPUT_ERROR(Parse(Replaced(kBag, from, to)), "a.json: " + message);
  };
  expect("\"version\": 1", "\"version\": 2", "key 'version': found 2, expected 1");
  expect("[1, 2]}, {\"endpoints\": [2, 3]},", "[1, 2]}, {\"endpoints\": [0, 3]},",
         "key 'panels.back.outline[2].endpoints[0]': found 0, expected 2, where the edge before");
  expect("{\"endpoints\": [3, 0]}],\n      \"translation\": [0, 0.1",
         "{\"endpoints\": [3, 1]}],\n      \"translation\": [0, 0.1",
         "key 'panels.back.outline[3].endpoints[1]': found 1, expected 0, where the loop begins");
  expect(
      "[\"back\", 3]", "[\"side\", 3]",
      "key 'stitches[0].edges[1][0]': found \"side\", expected the name of a panel: back, front");
  expect("[\"back\", 3]", "[\"back\", 4]",
         "key 'stitches[0].edges[1][1]': found 4, expected a whole number from 0 to 3");
  expect("[0.4, 0.3], [0, 0.3]],", "[0.4, 0.3], [0, 0.2]],",
         "key 'stitches[0]': found edge 1 of 'front' of 0.3 m and edge 3");
  expect("\"edges\": [4, 5]", "\"edges\": [6]", "key 'rings[0].edges[0]': found 6");
  expect("\"radius\": 0.05", "\"radius\": 0.04", "key 'panels.front.holes[0][0].circle.radius'");
  expect("\"ease\"", "\"easy\"", "unknown key 'stitches[1].easy'");
  expect("\"cylinder_radius\": 0.2", "\"cylinder_radius\": 0.1",
         "key 'panels.back.cylinder_radius': found 0.1 m, expected more than");
  expect("[0.4, 0], [0.4, 0.3], [0, 0.3]],", "[0, 0.3], [0.4, 0.3], [0.4, 0]],",
         "key 'panels.back");
  EXPECT_INPUT_ERROR(Parse("{}"), "expected a garment");
}

// Two panels in centimetres with invented numbers: a skirt half with every kind of edge, and a
// square whose outline is clockwise.
constexpr char kSpecification[] = R"({
  "pattern": {
    "panels": {
      "a": {
        "vertices": [[0, 0], [40, 0], [40, 30], [0, 30]],
        "edges": [{"endpoints": [0, 1], "curvature": [0.5, -0.2]},
                  {"endpoints": [1, 2], "label": "side"},
                  {"endpoints": [2, 3],
                   "curvature": {"type": "cubic", "params": [[0.2, -0.1], [0.8, -0.1]]}},
                  {"endpoints": [3, 0],
                   "curvature": {"type": "circle", "params": [25, 0, 1]}}],
        "translation": [10, 100, 20], "rotation": [0, 90, 0]
      },
      "b": {
        "vertices": [[0, 0], [0, 30], [40, 30], [40, 0]],
        "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]},
                  {"endpoints": [3, 0],
                   "curvature": {"type": "quadratic", "params": [[0.5, 0.1]]}}],
        "translation": [0, 0, 0], "rotation": [0, 0, 0]
      }
    },
    "stitches": [[{"panel": "a", "edge": 1}, {"panel": "b", "edge": 0}],
                 [{"panel": "a", "edge": 3}, {"panel": "b", "edge": 2}, "right_wrong"]],
    "panel_order": ["a", "b"]
  },
  "parameters": {}, "parameter_order": [],
  "properties": {"curvature_coords": "relative", "units_in_meter": 100}
})";

TEST_F(PatternIoTest, ReadsGarmentCode) {
  const Pattern pattern = Parse(Replaced(kSpecification, "[25, 0, 1]", "[25, false, true]"));
  ASSERT_EQ(pattern.panels.size(), 2u);
  const Panel& a = pattern.panels[0];
  // A quarter of the way along an edge of 40 cm and −.2 of its length to the left.
  EXPECT_LT((a.edge(0).control.at(0) - Vector2d(.2, -.08)).norm(), 1e-12);
  EXPECT_TRUE(a.edge(1).control.empty());
  // Along −x, so that its left is −y.
  EXPECT_LT((a.edge(2).control.at(0) - Vector2d(.32, .34)).norm(), 1e-12);
  EXPECT_LT((a.edge(2).control.at(1) - Vector2d(.08, .34)).norm(), 1e-12);
  EXPECT_NEAR(a.edge(3).arc_angle, 2 * std::asin(.6), 1e-12);
  // In their axes, (x, y, 0) turned by 90° about y is (0, y, −x); y up becomes z up.
  EXPECT_LT((a.Place({.3, .1}) - Vector3d(.1, -.2 + .3, 1.1)).norm(), 1e-12);
  EXPECT_FALSE(pattern.stitches.at(0).same_direction);
  EXPECT_TRUE(pattern.stitches.at(1).same_direction);
  EXPECT_TRUE(pattern.stitches.at(1).ease);  // of 32 and 30 cm, which the format does not say
  EXPECT_EQ(pattern.arm_angle, 0);           // not stated
}

TEST_F(PatternIoTest, TurnsOverPanelsThatAreClockwise) {
  const Panel b = Parse(kSpecification).panels.at(1);
  EXPECT_GT(LoopArea(b.outline), 0);
  // Edge 2 is still the one from (.4, .3) to (.4, 0) in their plane, in the same place in space.
  EXPECT_LT((b.Place(b.edge(2).begin) - Vector3d(.4, 0, .3)).norm(), 1e-12);
  EXPECT_LT((b.Place(b.edge(2).end) - Vector3d(.4, 0, 0)).norm(), 1e-12);
  EXPECT_LT((b.Place(b.edge(3).control.at(0)) - Vector3d(.2, 0, -.04)).norm(), 1e-12);
  // Its outer side faces +y, away from those who saw it clockwise.
  EXPECT_LT((b.placement.linear().col(2) - Vector3d::UnitY()).norm(), 1e-12);
}

TEST_F(PatternIoTest, NamesThePlaceOfAnErrorInGarmentCode) {
  const auto expect = [this](const std::string& from, const std::string& to,
                             const std::string& message) {
    EXPECT_INPUT_ERROR(Parse(Replaced(kSpecification, from, to)), "a.json: " + message);
  };
  expect("\"cubic\"", "\"spline\"",
         "key 'pattern.panels.a.edges[2].curvature.type': found \"spline\"");
  expect("{\"panel\": \"b\", \"edge\": 2}", "{\"panel\": \"b\", \"edge\": 9}",
         "key 'pattern.stitches[1][1].edge': found 9");
  expect("{\"panel\": \"b\", \"edge\": 2}", "{\"panel\": \"c\", \"edge\": 2}",
         "key 'pattern.stitches[1][1].panel': found \"c\"");
  expect("\"relative\"", "\"absolute\"", "key 'properties.curvature_coords'");
  expect("\"panel\": \"b\", \"edge\": 0", "\"panel\": \"b\", \"edge\": 2",
         "key 'pattern.stitches[1]': found edge 2 of 'b' a second time");
  expect("[[0, 0], [0, 30], [40, 30], [40, 0]]", "[[0, 0], [40, 30], [0, 30], [40, 0]]",
         "key 'pattern.panels.b': found edges 0 and 2, which cross");
}

}  // namespace
}  // namespace drape
