// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/state.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/util/atomic_file.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

using std::numbers::pi;

// The height of the hem of a start shape at θ.
double Height(const StartShape& shape, double theta) {
  double z = 0;
  for (const auto& m : shape.modes) z += m.amplitude_m * std::cos(m.k * theta - m.phase);
  return z;
}

class StartShapes : public FileFixture {
 protected:
  const Mesh mesh_ = MakeDisc({.target_vertices = 300});
  const StartShape shape_ = {{{3, .004, .5}, {7, .002, -1}}};
};

TEST_F(StartShapes, LiftOnlyTheClothOutsideTheSupport) {
  const Eigen::VectorXd x = ApplyStartShape(mesh_, .09, shape_);
  int inside = 0, hem = 0;
  for (int i = 0; i < mesh_.num_vertices(); ++i) {
    const Eigen::Vector3d rest = mesh_.rest_x.segment<3>(3 * i), p = x.segment<3>(3 * i);
    const double r = rest.norm(), theta = std::atan2(rest.y(), rest.x());
    EXPECT_EQ(p.head<2>(), rest.head<2>());
    if (r < .09 - 1e-9) {
      EXPECT_EQ(p.z(), 0);
      ++inside;
    } else if (r > .15 - 1e-9) {
      EXPECT_NEAR(p.z(), Height(shape_, theta), 1e-15);
      ++hem;
    }
    const double s = std::max(0., (r - .09) / .06);
    EXPECT_NEAR(p.z(), s * s * (3 - 2 * s) * Height(shape_, theta), 1e-15);
  }
  EXPECT_GT(inside, 50);
  EXPECT_GT(hem, 30);
}

TEST_F(StartShapes, NeedClothOutsideTheSupport) {
  EXPECT_INPUT_ERROR(ApplyStartShape(mesh_, .2, shape_), "start shape: the mesh reaches to 0.15");
}

TEST_F(StartShapes, RandomOnesFollowFromTheSeed) {
  const StartShape a = RandomStartShape(7, 1e-3), b = RandomStartShape(7, 1e-3),
                   c = RandomStartShape(8, 1e-3);
  ASSERT_EQ(a.modes.size(), 11u);
  for (size_t i = 0; i < a.modes.size(); ++i) {
    EXPECT_EQ(a.modes[i].k, static_cast<int>(i) + 2);
    EXPECT_EQ(a.modes[i].amplitude_m, b.modes[i].amplitude_m);
    EXPECT_EQ(a.modes[i].phase, b.modes[i].phase);
    EXPECT_NE(a.modes[i].phase, c.modes[i].phase);
  }
}

TEST_F(StartShapes, RandomOnesHaveTheRequestedHemRms) {
  constexpr int kDraws = 2000;
  double sum = 0;
  for (int seed = 0; seed < kDraws; ++seed) {
    const double rms = HemRms(RandomStartShape(seed, 3e-3, {3, 6}));
    sum += rms * rms / kDraws;
  }
  // This is the mean of 8 · 2000 squared normal numbers: relative deviation √(2/16000) = .011.
  EXPECT_NEAR(std::sqrt(sum), 3e-3, .02 * 3e-3);
}

TEST(Random, UniformNumbersAreTheSameOnEachPlatform) {
  std::mt19937_64 random(5489);  // its first output is fixed by the C++ standard's algorithm
  EXPECT_EQ(SampleUniform(random), static_cast<double>(14514284786278117030ull >> 11) * 0x1p-53);
}

TEST(Random, NormalNumbersHaveTheMomentsOfANormal) {
  std::mt19937_64 random(3);
  constexpr int kDraws = 100000;
  double moments[4] = {};
  for (int i = 0; i < kDraws; ++i) {
    const double x = SampleNormal(random);
    for (int k = 0; k < 4; ++k) moments[k] += std::pow(x, k + 1) / kDraws;
  }
  EXPECT_NEAR(moments[0], 0, .015);  // four standard errors each
  EXPECT_NEAR(moments[1], 1, .018);
  EXPECT_NEAR(moments[2], 0, .05);
  EXPECT_NEAR(moments[3], 3, .13);
}

// Numbers read back bit for bit.
void WriteStartShape(const std::string& path, const StartShape& shape) {
  std::string text = "{\n  \"format\": \"" + std::string("drapefit-start-shape") +
                     "\",\n  \"version\": 1,\n  \"modes\": [";
  for (size_t i = 0; i < shape.modes.size(); ++i) {
    const StartShape::Mode& mode = shape.modes[i];
    text += i == 0 ? "\n" : ",\n";
    text += "    {\"k\": " + std::to_string(mode.k);
    AppendNumber(text += ", \"amplitude_m\": ", mode.amplitude_m);
    AppendNumber(text += ", \"phase\": ", mode.phase);
    text += '}';
  }
  WriteFileAtomically(path, text += "\n  ]\n}\n");
}

TEST_F(StartShapes, ReadBackAsWritten) {
  WriteStartShape(Path("a.json"), shape_);
  const StartShape again = ReadStartShape(Path("a.json"));
  ASSERT_EQ(again.modes.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(again.modes[i].k, shape_.modes[i].k);
    EXPECT_EQ(again.modes[i].amplitude_m, shape_.modes[i].amplitude_m);
    EXPECT_EQ(again.modes[i].phase, shape_.modes[i].phase);
  }
  WriteStartShape(Path("a.json"), {});
  EXPECT_EQ(ReadStartShape(Path("a.json")).modes.size(), 0u);
}

TEST_F(StartShapes, StartFromEitherKindOfFile) {
  WriteStartShape(Path("shape.json"), shape_);
  const State from_shape = ReadStart(Path("shape.json"), mesh_, .09);
  EXPECT_EQ(from_shape.x, ApplyStartShape(mesh_, .09, shape_));
  EXPECT_EQ(from_shape.v, Eigen::VectorXd::Zero(900));
  const State state{from_shape.x * 2, from_shape.x * 3};
  WriteState(Path("state.json"), state);
  EXPECT_EQ(ReadStart(Path("state.json"), mesh_, .09).x, state.x);
  EXPECT_EQ(ReadStart(Path("state.json"), mesh_, .09).v, state.v);
  WriteState(Path("state.json"), {Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(3)});
  EXPECT_INPUT_ERROR(ReadStart(Path("state.json"), mesh_, .09),
                     "state.json: key 'x': found an array of 1, expected an array of 300");
  EXPECT_INPUT_ERROR(ReadStart(Write("other.json", "{\"a\":1}"), mesh_, .09),
                     "other.json: found an object, expected a start shape (keys format, version, "
                     "modes) or a state (keys x, v)");
}

TEST_F(StartShapes, NameTheKeyThatIsWrong) {
  const auto expect_error = [&](const std::string& rest, const std::string& message) {
    EXPECT_INPUT_ERROR(
        ReadStartShape(Write("a.json", "{\"format\":\"drapefit-start-shape\"," + rest)), message);
  };
  expect_error("\"version\":2,\"modes\":[]}", "a.json: key 'version': found 2, expected 1");
  expect_error("\"version\":1}", "a.json: key 'modes' is missing");
  expect_error("\"version\":1,\"modes\":3}", "a.json: key 'modes': found 3, expected an array");
  expect_error("\"version\":1,\"modes\":[],\"a\":0}", "a.json: unknown key 'a', allowed: format");
  const std::string head = "\"version\":1,\"modes\":[{\"k\":2,\"amplitude_m\":0,\"phase\":0},";
  expect_error(head + "{\"k\":2,\"amplitude_m\":0}]}", "a.json: key 'modes[1].phase' is missing");
  expect_error(head + "{\"k\":-1,\"amplitude_m\":0,\"phase\":0}]}",
               "a.json: key 'modes[1].k': found -1, expected 0..1000");
  expect_error(head + "{\"k\":2.5,\"amplitude_m\":0,\"phase\":0}]}",
               "a.json: key 'modes[1].k': found 2.5, expected a whole number");
  expect_error(head + "{\"k\":2,\"amplitude_m\":\"x\",\"phase\":0}]}",
               "a.json: key 'modes[1].amplitude_m': found \"x\", expected a finite number");
  expect_error(head + "{\"k\":2,\"amplitude\":1,\"phase\":0}]}",
               "a.json: unknown key 'modes[1].amplitude', allowed: k amplitude_m phase");
  EXPECT_INPUT_ERROR(ReadStartShape(Write("a.json", R"({"format":"x","version":1,"modes":[]})")),
                     "a.json: key 'format': found \"x\", expected \"drapefit-start-shape\"");
}

TEST(StartShapeDeathTest, RefusesImpossibleArguments) {
  EXPECT_DEATH(RandomStartShape(1, -1), "Check failed");
}

TEST_F(StartShapes, FlapsHangAtTheOutlineAndKeepTheirLength) {
  const int n = 720;
  const Eigen::VectorXd outline = Eigen::VectorXd::NullaryExpr(
      n, [](Eigen::Index i) { return .12 + .01 * std::cos(6 * 2 * pi * double(i) / n); });
  const Eigen::VectorXd hanging = FlapsFromOutline(mesh_, .09, outline, 1.0);
  const Eigen::VectorXd lifted = FlapsFromOutline(mesh_, .09, outline, 0.5);
  for (int i = 0; i < mesh_.num_vertices(); ++i) {
    const Eigen::Vector3d rest = mesh_.rest_x.segment<3>(3 * i), p = hanging.segment<3>(3 * i);
    const double r = rest.norm(), theta = std::atan2(rest.y(), rest.x());
    if (r <= .09) {
      EXPECT_EQ(p, rest);
      continue;
    }
    const Eigen::Vector3d foot = .09 * rest.normalized();
    EXPECT_NEAR((p - foot).norm(), r - .09, 1e-15);
    if (r > .15 - 1e-9) {
      EXPECT_NEAR(p.head<2>().norm(), .12 + .01 * std::cos(6 * theta), 1e-5);
    }
    EXPECT_LT(p.z(), lifted[3 * i + 2]);
  }
}

TEST_F(StartShapes, AFlapCannotExceedItsLength) {
  const Eigen::VectorXd x = FlapsFromOutline(mesh_, .09, Eigen::VectorXd::Constant(90, .2), 1.0);
  EXPECT_LT((x - mesh_.rest_x).cwiseAbs().maxCoeff(), 1e-12);
}

class StateIo : public FileFixture {
 protected:
  void ExpectError(const std::string& text, const std::string& message) const {
    EXPECT_INPUT_ERROR(ReadState(Write("s.json", text), 2), message);
  }
};

TEST_F(StateIo, ReadsBackWhatItWroteBitForBit) {
  State state;
  state.x = Eigen::VectorXd::LinSpaced(12, -1, 1) / 3;
  state.v = Eigen::VectorXd::LinSpaced(12, 1e-300, 1e-17);
  WriteState(Path("s.json"), state);
  const State again = ReadState(Path("s.json"), 4);
  EXPECT_EQ(again.x, state.x);
  EXPECT_EQ(again.v, state.v);
}

TEST_F(StateIo, RejectsAnotherMesh) {
  ExpectError(R"({"x":[[0,0,0]],"v":[[0,0,0],[0,0,0]]})",
              "s.json: key 'x': found an array of 1, expected an array of 2, the vertices");
  ExpectError(R"({"x":[[0,0,0],[0,0,0]],"v":[]})", "s.json: key 'v': found an array of 0");
  ExpectError(R"({"x":{},"v":[]})", "s.json: key 'x': found an object, expected an array of 2");
}

TEST_F(StateIo, NamesTheValueThatIsWrong) {
  ExpectError(R"({"x":[[0,0,0],[0,0]],"v":[]})",
              "s.json: key 'x[1]': found an array of 2, expected an array of 3");
  ExpectError(R"({"x":[[0,0,0],[0,0,0]],"v":[[0,0,0],[0,null,0]]})",
              "s.json: key 'v[1][1]': found null, expected a finite number");
  ExpectError(R"({"x":[[0,0,0],[0,0,1e400]],"v":[]})", "s.json: number overflow");
  ExpectError(R"({"x":[[0,0,0],[0,0,0]]})", "s.json: key 'v' is missing");
  ExpectError(R"({"x":[],"v":[],"a":1})", "s.json: unknown key 'a', allowed: x v");
  ExpectError("[1,2]", "s.json: found an array of 2, expected an object");
  ExpectError("{\"x\": [[0,", "s.json: parse error at line 1");
  EXPECT_INPUT_ERROR(ReadState(Path("absent.json"), 2), "absent.json: no such file");
}

TEST_F(StateIo, KeepsTheOldFileWhenItCannotWrite) {
  const State state{Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(3)};
  EXPECT_IO_ERROR(WriteState(Path("absent/s.json"), state), "s.json: cannot create");
}

using StateIoDeathTest = StateIo;

TEST_F(StateIoDeathTest, RefusesStatesThatAreNone) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(3);
  const Eigen::VectorXd nan = zero.array() + std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(WriteState(Path("s.json"), {zero, nan}), std::domain_error);
  EXPECT_DEATH(WriteState(Path("s.json"), {zero, Eigen::VectorXd::Zero(6)}), "Check failed");
}

}  // namespace
}  // namespace drape
