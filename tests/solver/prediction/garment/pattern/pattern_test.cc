// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <gmock/gmock.h>

#include <numbers>

namespace drape {
namespace {

using Eigen::Vector2d;
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

}  // namespace
}  // namespace drape
