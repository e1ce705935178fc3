// SPDX-License-Identifier: Apache-2.0
// Bodies of other programs, made of our mannequin: other axes, units and places, quads, and
// surfaces that are open or meet themselves.
#include "solver/prediction/garment/body/stance.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/body/wrap.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const ObjSurface& Person() {
  static const ObjSurface person = [] {
    const Mannequin body(MotionKind::kStand);
    return ObjSurface{body.PositionsInPose({}, 1), body.triangles()};
  }();
  return person;
}

ObjSurface Surface(const test::ClosedMesh& mesh, const Vector3d& middle = Vector3d::Zero()) {
  return {Eigen::VectorXd((mesh.x.colwise() + middle).reshaped()), mesh.triangles};
}

void Append(const ObjSurface& more, ObjSurface* all) {
  const int begin = static_cast<int>(all->x.size() / 3);
  Eigen::VectorXd x(all->x.size() + more.x.size());
  x << all->x, more.x;
  all->x = x;
  for (const auto& t : more.triangles)
    all->triangles.push_back({t[0] + begin, t[1] + begin, t[2] + begin});
}

double Volume(const ObjSurface& surface) {
  double volume = 0;
  const auto at = [&](int i) -> Vector3d { return surface.x.segment<3>(3 * i); };
  for (const auto& t : surface.triangles) volume += at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6;
  return volume;
}

// Axes, unit and place in which another program has the person.
struct Other {
  std::string up, front;
  double unit;
  Vector3d place;
};
ObjSurface InOtherAxes(const ObjSurface& person, const Other& other) {
  const auto axis = [](const std::string& name) -> Vector3d {
    return (name[0] == '-' ? -1 : 1) * Vector3d::Unit(name.back() - 'x');
  };
  const Vector3d up = axis(other.up), front = axis(other.front), left = up.cross(front);
  ObjSurface moved = person;
  for (Eigen::Index i = 0; i < moved.x.size(); i += 3) {
    const Vector3d p = person.x.segment<3>(i);
    moved.x.segment<3>(i) = (p.x() * left - p.y() * front + p.z() * up) / other.unit + other.place;
  }
  return moved;
}

TEST(FindStance, FindsAxesUnitAndPlaceOfAPerson) {
  for (const Other& other : std::vector<Other>{{"z", "-y", 1, {0, 0, 0}},
                                               {"z", "y", 1, {0, 0, 0}},
                                               {"y", "z", 1, {0, -1.2, 0}},
                                               {"y", "-z", .01, {0, 0, 0}},
                                               {"-y", "-z", 1, {0, 0, 3}},
                                               {"x", "y", .0254, {5, 40, -30}},
                                               {"z", "-x", .3048, {2, 0, 0}},
                                               {"-z", "x", .001, {0, 0, 0}}}) {
    ObjSurface body = InOtherAxes(Person(), other);
    const BodyFiles found = FindStance(body, {}, "body.obj");
    EXPECT_EQ(found.up, other.up);
    EXPECT_EQ(found.front, other.front) << other.up;
    EXPECT_EQ(found.scale, other.unit);
    Stand(found, body);
    EXPECT_LT((body.x - Person().x).cwiseAbs().maxCoeff(), .05) << other.up << other.front;
    BodyFiles stated = found;  // what is found is taken as it is
    stated.offset = {1, 2, 3};
    EXPECT_EQ(FindStance(InOtherAxes(Person(), other), stated, "b").offset, stated.offset);
  }
}

TEST(FindStance, FindsAPersonWithLevelArms) {
  const Mannequin level(MotionKind::kStand, std::numbers::pi / 2);
  Pose pose;
  pose.arm_lift = {65 * std::numbers::pi / 180, 65 * std::numbers::pi / 180};
  const ObjSurface body{level.PositionsInPose(pose, 1), level.triangles()};
  const BodyFiles found = FindStance(InOtherAxes(body, {"y", "z", .01, {0, 0, 0}}), {}, "b");
  EXPECT_EQ(found.up + found.front, "yz");
  EXPECT_EQ(found.scale, .01);
}

TEST(FindStance, RefusesWhatIsNoPersonAndUnitsOfNone) {
  const auto scaled = [](const Vector3d& axes) {
    return InOtherAxes(
        Surface({axes.asDiagonal() * test::MakeBall(1, 3).x, test::MakeBall(1, 3).triangles}),
        {"y", "z", 1, {0, 0, 0}});
  };
  for (const Vector3d& axes : {Vector3d(1, 1, 1), {.3, .15, .9}, {.05, .05, .9}, {.8, .8, .1}})
    EXPECT_INPUT_ERROR(FindStance(scaled(axes), {}, "ball.obj"),
                       "are not those of a standing person");
  ObjSurface cone = scaled({.3, .15, .9});
  for (Eigen::Index i = 0; i < cone.x.size(); i += 3) cone.x[i] *= .9 - cone.x[i + 1];
  EXPECT_INPUT_ERROR(FindStance(cone, {}, "cone.obj"), "are not those of a standing person");
  EXPECT_INPUT_ERROR(FindStance(InOtherAxes(Person(), {"z", "-y", .14, {0, 0, 0}}), {}, "b.obj"),
                     "b.obj: found a body 12.28 units tall, which no unit makes a person: give "
                     "--body_scale, 0.138 makes it 1.7 m tall");
  EXPECT_INPUT_ERROR(FindStance(Person(), {.offset = {1, 2}}, "b"), "found 2 numbers");
}

// Two balls whose middles are one radius apart: their union has 27/16 of the volume of one.
TEST(Wrap, IsTheUnionOfWhatMeets) {
  constexpr double kRadius = .2;
  ObjSurface balls = Surface(test::MakeBall(kRadius, 4));
  Append(Surface(test::MakeBall(kRadius, 4), {kRadius, 0, 0}), &balls);
  const ObjSurface wrap = Wrap(balls);
  EXPECT_NO_THROW(RequireClosed(wrap, "wrap"));
  EXPECT_NO_THROW(RequireSolid(wrap, "wrap"));
  const double ball = 4 * std::numbers::pi / 3 * std::pow(kRadius, 3);
  EXPECT_NEAR(Volume(wrap) / (27 * ball / 16), 1 + 3 * kWrapOffset / kRadius, .02);
}

TEST(Wrap, ClosesHoles) {
  ObjSurface ball = Surface(test::MakeBall(.2, 4));
  std::erase_if(ball.triangles, [&](const auto& t) { return ball.x[3 * t[0] + 2] > .15; });
  const ObjSurface wrap = Wrap(ball);
  EXPECT_NO_THROW(RequireSolid(wrap, "wrap"));
  // A cap of the height .05 is missing, to the size of a facet.
  const double whole = 4 * std::numbers::pi / 3 * std::pow(.2, 3);
  const double cap = std::numbers::pi * .05 * .05 * (.2 - .05 / 3);
  EXPECT_NEAR(Volume(wrap), (whole - cap) * 1.03, .02 * whole);
}

TEST(Follower, MovesRigidlyWithTheSurface) {
  const ObjSurface ball = Surface(test::MakeBall(.2, 2));
  const Eigen::VectorXd points = 1.1 * Surface(test::MakeBall(.2, 3)).x;
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(.7, Vector3d(1, 2, 3).normalized());
  const auto moved = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const Eigen::Matrix3Xd places = x.reshaped(3, x.size() / 3);
    return (motion * places).reshaped();
  };
  EXPECT_LT((Follower(ball, points).At(moved(ball.x)) - moved(points)).norm(), 1e-9);
}

// The coordinates of a sphere are eigenfunctions of the flow, with the eigenvalue −2/r².
TEST(Contract, DrawsASphereTogether) {
  constexpr double kRadius = .3, kLength = .17;
  const ObjSurface ball = Surface(test::MakeBall(kRadius, 4));
  const double expected = 1 / (1 + 2 * std::pow(kLength / kRadius, 2));
  EXPECT_LT((Contract(ball, kLength) - expected * ball.x).cwiseAbs().maxCoeff(), .01 * kRadius);
}

// Two balls of 20 cm, apart by `gap`, or of 2 cm, as fingers.
struct Pair {
  explicit Pair(double gap, double radius = .1) {
    for (const int side : {1, -1})
      Append(Surface(test::MakeBall(radius, 4), {side * (radius + gap / 2), 0, 1}), &surface);
    before = surface;
    most = PressIn(surface);
  }
  // Between the balls, where they were nearest [m].
  double Gap() const {
    const auto x = surface.x.reshaped(3, surface.x.size() / 3).row(0);
    const Eigen::Index half = x.size() / 2;
    return x.head(half).minCoeff() - x.tail(half).maxCoeff();
  }
  ObjSurface surface = {}, before;
  double most;
};

TEST(PressIn, MakesRoomForClothBetweenParts) {
  const Pair near(.004), touching(0), meeting(-.003), apart(kPartGap + 1e-4), thin(.004, .01);
  EXPECT_NEAR(near.most, .004, 1e-4);
  for (const Pair& pair : {near, touching, meeting}) {
    EXPECT_GT(pair.Gap(), .8 * kPartGap);
    EXPECT_LT(pair.Gap(), kPartGap + 1e-4);
  }
  EXPECT_THAT(FindSelfIntersections(meeting.surface.triangles, meeting.surface.x), IsEmpty());
  for (const Pair& pair : {apart, thin}) {
    EXPECT_EQ(pair.most, 0);
    EXPECT_EQ(pair.surface.x, pair.before.x);
  }
}

class ForeignBodyTest : public FileFixture {
 protected:
  std::unique_ptr<Body> Read(const ObjSurface& surface, double arm_angle = 0) const {
    WriteObj(Path("body.obj"), surface);
    testing::internal::CaptureStderr();
    auto body = ReadBodySequence(Path("body.obj"), {}, arm_angle);
    note_ = testing::internal::GetCapturedStderr();
    return body;
  }
  mutable std::string note_;
};

TEST_F(ForeignBodyTest, GrowsToItsSize) {
  const auto body = Read(InOtherAxes(Person(), {"y", "z", .001, {0, 0, 0}}));
  EXPECT_THAT(note_, HasSubstr("--body_up=y --body_front=z --body_scale=0.001"));
  EXPECT_LT((body->Positions(kGrowSeconds) - Person().x).cwiseAbs().maxCoeff(), 1e-4);
  const Eigen::VectorXd start = body->Positions(0);
  EXPECT_THAT(FindSelfIntersections(body->triangles(), start), IsEmpty());
  // Our mannequin has .25 by the halves of its radii.
  EXPECT_NEAR(Volume({start, body->triangles()}) / Volume(Person()), .25, .1);
  EXPECT_TRUE(body->PelvisMotion(.2).isApprox(Eigen::Isometry3d::Identity()));
}

// Ours in another pose has its arms where a mannequin that lifts them has them.
TEST_F(ForeignBodyTest, TurnsItsArms) {
  const double level = std::numbers::pi / 2;
  const auto body = Read(Person(), level);
  const auto farthest = [](const Eigen::VectorXd& x) {
    Eigen::Index hand = 0;
    x.reshaped(3, x.size() / 3).row(0).maxCoeff(&hand);
    return Vector3d(x.segment<3>(3 * hand));
  };
  const Vector3d hand = farthest(body->Positions(kGrowSeconds));
  Pose pose;
  pose.arm_lift = {level - kRestArmAngle, level - kRestArmAngle};
  const Vector3d expected = farthest(Mannequin(MotionKind::kStand).PositionsInPose(pose, 1));
  EXPECT_LT((hand - expected).norm(), .05) << hand.transpose() << " for " << expected.transpose();
  EXPECT_THAT(FindSelfIntersections(body->triangles(), body->Positions(kGrowSeconds)), IsEmpty());
  EXPECT_LT((body->Positions(1.25) - Person().x).cwiseAbs().maxCoeff(), 1e-4);
}

// A tube of rings along a line, from its cuff to the body.
ClothTube Tube(const Vector3d& cuff, const Vector3d& top) {
  ClothTube tube;
  for (double s = 0; s <= 1; s += .1)
    tube.push_back({.middle = cuff + s * (top - cuff), .inner = std::abs(top.x())});
  return tube;
}

// The middle of what a body has at a height or, with a side, so far from the middle [m].
Vector3d MiddleAt(const Eigen::VectorXd& x, const Vector3d& place, int axis) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    if (std::abs(x[i + axis] - place[axis]) < .02 && (x.segment<3>(i) - place).norm() < .2 &&
        ++count)
      sum += x.segment<3>(i);
  return sum / count;
}

// Arms and legs begin along tubes at another angle, beside the joints, and go back.
TEST_F(ForeignBodyTest, ReachesIntoTubes) {
  const auto body = Read(Person());
  const Eigen::VectorXd before = body->Positions(0);
  const ClothTube sleeve = Tube({.62, -.05, 1.02}, {.24, -.02, 1.26}),
                  leg = Tube({-.21, -.02, .12}, {-.12, -.01, .62}),
                  short_sleeve = Tube({-.36, 0, 1.37}, {-.24, 0, 1.37});
  testing::internal::CaptureStderr();
  body->ReachInto({sleeve, leg, short_sleeve, {}});
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("left arm turned by "), HasSubstr("right leg turned by "),
                    HasSubstr("right arm turned by "), Not(HasSubstr("left leg")),
                    HasSubstr("back in their place after 1.25 s")));
  const Eigen::VectorXd x = body->Positions(0);
  for (const double s : {.2, .5, .8}) {
    const Vector3d in_sleeve = sleeve[0].middle + s * (sleeve[10].middle - sleeve[0].middle),
                   in_leg = leg[0].middle + s * (leg[10].middle - leg[0].middle);
    EXPECT_FALSE((MiddleAt(before, in_sleeve, 0) - in_sleeve).norm() < .04) << s;  // or none near
    EXPECT_LT((MiddleAt(x, in_sleeve, 0) - in_sleeve).norm(), .02) << s;
    EXPECT_LT((MiddleAt(x, in_leg, 2) - in_leg).norm(), .02) << s;
  }
  const Vector3d in_short(-.33, 0, 1.37);
  EXPECT_LT((MiddleAt(x, in_short, 0) - in_short).norm(), .02);
  EXPECT_THAT(FindSelfIntersections(body->triangles(), body->Positions(kGrowSeconds)), IsEmpty());
  EXPECT_LT((body->Positions(1.25) - Person().x).cwiseAbs().maxCoeff(), 1e-4);
}

// Lips: two balls at the mouth that meet one another and the face.
TEST_F(ForeignBodyTest, MayMeetItself) {
  ObjSurface person = Person();
  for (const double z : {1.57, 1.585})
    Append(Surface(test::MakeBall(.012, 2), {0, -.1, z}), &person);
  for (auto& t : person.triangles) std::swap(t[1], t[2]);  // and is inside out
  const auto body = Read(person);
  EXPECT_THAT(note_, HasSubstr("pairs of faces meet, one of them near ("));
  const ObjSurface grown{body->Positions(kGrowSeconds), body->triangles()};
  EXPECT_NEAR(Volume(grown) / Volume(Person()), 1, .001);
}

TEST_F(ForeignBodyTest, IsWrappedWhereItIsOpen) {
  ObjSurface person = Person();
  std::erase_if(person.triangles, [&](const auto& t) { return person.x[3 * t[0] + 2] > 1.66; });
  const auto body = Read(person);
  EXPECT_THAT(note_, HasSubstr("is open or has faces without an area: the cloth meets a wrap"));
  const ObjSurface grown{body->Positions(kGrowSeconds), body->triangles()};
  EXPECT_NO_THROW(RequireSolid(grown, "wrap"));
  EXPECT_NEAR(Volume(grown) / Volume(Person()), 1.065, .02);  // 2 mm of 1.7 m²
}

// Pairs of triangles with a common edge as quads, and colours at the vertices.
TEST_F(ForeignBodyTest, HasQuadsAndColours) {
  const ObjSurface& person = Person();
  std::string text = "o person\ns 1\n";
  for (Eigen::Index i = 0; i < person.x.size(); i += 3)
    text += Format("v %.9g %.9g %.9g 0.5 0.4 0.3\n", person.x[i], person.x[i + 1], person.x[i + 2]);
  std::map<std::pair<int, int>, std::size_t> of_edge;
  for (std::size_t f = 0; f < person.triangles.size(); ++f)
    for (int k = 0; k < 3; ++k)
      of_edge[{person.triangles[f][k], person.triangles[f][(k + 1) % 3]}] = f;
  std::set<std::size_t> done;
  int quads = 0;
  for (std::size_t f = 0; f < person.triangles.size(); ++f) {
    const auto& [a, b, c] = person.triangles[f];
    const std::size_t other = of_edge.at({a, c});
    if (!done.insert(f).second) continue;
    if (done.insert(other).second) {
      for (const int d : person.triangles[other])
        if (d != a && d != c) text += Format("f %d %d %d %d\n", a + 1, b + 1, c + 1, d + 1);
      ++quads;
    } else {
      text += Format("f %d %d %d\n", a + 1, b + 1, c + 1);
    }
  }
  ASSERT_GT(quads, 1000);
  const auto body = ReadBodySequence(Write("quads.obj", text), {});
  EXPECT_NEAR(Volume({body->Positions(1), body->triangles()}) / Volume(person), 1, .01);
}

}  // namespace
}  // namespace drape
