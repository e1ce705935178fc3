// SPDX-License-Identifier: Apache-2.0
#include "physics/util/child_process.h"

#include <unistd.h>

#include <stdexcept>
#include <vector>

#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

class RunPrograms : public FileFixture {};

TEST_F(RunPrograms, ReturnsBothOutputs) {
  EXPECT_EQ(RunProgram({"cat"}).output, "");
  const std::string large(1 << 20, 'x');
  const ProgramResult copy = RunProgram({"cat", Write("large", large)});
  EXPECT_EQ(copy.status, 0);
  EXPECT_EQ(copy.output, large);
  EXPECT_EQ(copy.errors, "");
  const ProgramResult failed = RunProgram({"cat", "/absent `touch x`\n"});
  EXPECT_NE(failed.status, 0);
  EXPECT_THAT(failed.errors, testing::HasSubstr("/absent"));
}

TEST(RunProgram, NamesAProgramThatIsMissing) {
  EXPECT_INPUT_ERROR(RunProgram({"drape_absent"}), "drape_absent: cannot be started");
}

TEST(RunInChild, ReturnsTextAndPassesErrorsOn) {
  const ChildResult small = RunInChild([] { return std::string("result"); }, nullptr);
  EXPECT_EQ(small.output, "result");
  const ChildResult large = RunInChild(
      [] {
        const std::vector<char> bytes(100 << 20, 'x');
        const volatile char* last = &bytes.back();  // Clang leaves out what nobody reads
        return std::string(10, *last);
      },
      nullptr);
  EXPECT_GT(large.peak_bytes - small.peak_bytes, 90e6);
  EXPECT_INPUT_ERROR(
      RunInChild([]() -> std::string { throw InputError("a.json", "bad"); }, nullptr),
      "a.json: bad");
  EXPECT_IO_ERROR(RunInChild([]() -> std::string { throw IoError("out", "full"); }, nullptr),
                  "out: full");
  EXPECT_THROW(RunInChild([]() -> std::string { _exit(3); }, nullptr), std::runtime_error);
  const std::atomic<bool> cancel = true;
  EXPECT_TRUE(RunInChild(
                  []() -> std::string {
                    for (;;) pause();
                  },
                  &cancel)
                  .cancelled);
}

}  // namespace
}  // namespace drape
