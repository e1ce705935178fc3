// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "physics/cloth/state.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

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
