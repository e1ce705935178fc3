// SPDX-License-Identifier: Apache-2.0
#include "physics/blas.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace drape {
namespace {

// The output of one test of this executable, run again in another environment.
std::string RunAgain(const std::string& environment, const std::string& test) {
  std::array<char, 4096> self{};  // the shell's own /proc/self is another program
  if (realpath("/proc/self/exe", self.data()) == nullptr) return {};
  const std::string command = environment + " '" + self.data() +
                              "' --gtest_also_run_disabled_tests --gtest_filter=" + test;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string output;
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) output += static_cast<char>(c);
  pclose(pipe);
  return output;
}

TEST(BlasTest, BetterCoreIsNamedOnlyForASlowOne) {
  const std::string core = BlasCore(), better = BetterBlasCore();
  EXPECT_TRUE(better.empty() || better == "Haswell" || better == "SkylakeX") << better;
  if (core == "Zen" || core == "Haswell" || core == "SkylakeX" || core.empty()) {
    EXPECT_EQ(better, "") << core;
  }
}

// Run by the tests below in another environment.
TEST(BlasTest, DISABLED_PrintCore) {
  std::printf("core <%s> better <%s>\n", BlasCore().c_str(), BetterBlasCore().c_str());
}
TEST(BlasTest, DISABLED_EnsureThenPrintCore) {
  std::array argv = {const_cast<char*>("physics_test"),
                     const_cast<char*>("--gtest_also_run_disabled_tests"),
                     const_cast<char*>("--gtest_filter=BlasTest.DISABLED_PrintCore"),
                     static_cast<char*>(nullptr)};
  EnsureFastBlas(argv.data());
  std::printf("not started again\n");
}

TEST(BlasTest, RecognisesSlowKernels) {
  const std::string core = BlasCore();
  if (core.empty()) GTEST_SKIP() << "the BLAS is not OpenBLAS";
  const std::string output = RunAgain("OPENBLAS_CORETYPE=Prescott", "BlasTest.DISABLED_PrintCore");
  EXPECT_NE(output.find("core <Prescott>"), std::string::npos) << output;
  if (__builtin_cpu_supports("avx2")) {
    EXPECT_EQ(output.find("better <>"), std::string::npos) << output;
  }
}

TEST(BlasTest, UsersChoiceOfKernelsStands) {
  if (BlasCore().empty()) GTEST_SKIP() << "the BLAS is not OpenBLAS";
  const std::string output =
      RunAgain("OPENBLAS_CORETYPE=Prescott", "BlasTest.DISABLED_EnsureThenPrintCore");
  EXPECT_NE(output.find("not started again"), std::string::npos) << output;
}

}  // namespace
}  // namespace drape
