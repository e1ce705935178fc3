// SPDX-License-Identifier: Apache-2.0
// The real programs without Python, memory, threads or room on a disk, and with signals.
#include <chrono>
#include <thread>

#include "tests/tools/hostile_fixture.h"

namespace drape::test {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class HostileSurroundings : public HostileFiles {
 protected:
  // Runs as on a server where only the programs are, without a Python that works.
  ProcessResult WithoutPython(const std::string& program,
                              const std::vector<std::string>& options) const {
    return Run(program, options,
               {.environment = {
                    {"PATH", "/nowhere"}, {"PYTHONHOME", "/nowhere"}, {"TMPDIR", "/nowhere"}}});
  }
  void ExpectNumbers(const ProcessResult& result, const std::string& file) const {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, ContainsRegex("no (tables and )?pictures: ."));
    EXPECT_TRUE(ReadJson(Path(file)).is_object()) << file;
  }
};

TEST_F(HostileSurroundings, WithoutPythonKeepTheNumbers) {
  ExpectNumbers(
      WithoutPython("stability", {"--mesh=disc:100", "--fabric=wool.json", "--start=" + kWaves,
                                  "--maps=step time_step=0.1/0.5 stretch=1/2",
                                  "--damping_time_step=0.1", "--duration=1", "--out=stability"}),
      "stability/stability.json");
  ExpectNumbers(
      WithoutPython("bench", {"--work=forward", "--start=" + kWaves, "--fabric=wool.json",
                              "--mesh=disc:100,disc:150", "--solve=hybrid", "--time_step=0.2",
                              "--relax_time=10", "--branch_mm=100", "--reference=disc:200,disc:300",
                              "--reference_relax_mesh=disc:100", "--run_seconds=0", "--repeats=1",
                              "--out=bench"}),
      "bench/bench.json");
}

TEST_F(HostileSurroundings, WithAFullStdoutOrStderrSayThatTextIsLost) {
  const std::string silhouette = AddSilhouette("s.png");
  const ProcessLimits full = {.out_file = "/dev/full"};
  const std::string lost = "stdout: cannot be written: No space left on device";
  ExpectRefused(Run("metrics", {silhouette}, full), lost);
  ExpectRefused(Run("check", {"--mesh=disc:100", "--fabric=wool.json"}, full), lost);
  ExpectRefused(Drape({}, full), lost);
  EXPECT_EQ(ReadJson(Path("out/summary.json")).at("outcome"), "done");
  ExpectRefused(Run("metrics", {"--help"}, full), lost);
  const ProcessResult mute = Run("metrics", {"none.png"}, {.err_file = "/dev/full"});
  EXPECT_EQ(mute.exit_code, 2);
  EXPECT_THAT(mute.out, HasSubstr("stderr: cannot be written"));
}

TEST_F(HostileSurroundings, WithoutMemoryNameTheLimit) {
  if (!kCanLimitMemory) GTEST_SKIP() << "sanitizers reserve more addresses";
  const ProcessResult result = Drape({"--mesh=disc:20000"}, {.address_bytes = 400'000'000});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("error: out of memory: the run reserved 0."));
  EXPECT_THAT(result.err, HasSubstr("the limit of its address space (ulimit -v) is 0.40 GB"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

// OpenMP would end the program when a thread cannot be started.
TEST_F(HostileSurroundings, WithoutRoomForTheThreadsSaySo) {
  std::vector<std::string> options = FitOptions(AddSilhouette("s.png"));
  options.push_back("--threads=64");
  if (kCanLimitMemory)
    ExpectRefused(Run("fit", options, {.address_bytes = 400'000'000}),
                  "threads: found 64, expected fewer: ");
  options.back() = "--threads=100000";
  ExpectRefused(Run("fit", options), "threads");
  if (4 * std::thread::hardware_concurrency() < 1000) {
    options.back() = "--threads=1000";
    ExpectRefused(Run("fit", options), "threads");
  }
  EXPECT_FALSE(std::filesystem::exists(Path("fit")));
}

// Seconds from the signal to the end, wherever it finds the program.
TEST_F(HostileSurroundings, AnswerASignalSoon) {
  constexpr double kSoon = 9.0;  // two seconds on a machine of its own, more beside other programs
  for (const double after : {0.3, 1.5, 4.0}) {
    const auto begin = std::chrono::steady_clock::now();
    const ProcessResult result = Drape({"--mesh=disc:20000", "--steps=2000", "--time_step=0.01"},
                                       {.interrupt_when = Path(""), .interrupt_after = after});
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_LT(seconds - after, kSoon) << result.err;
    if (std::filesystem::exists(Path("out"))) {
      for (const auto& entry : std::filesystem::directory_iterator(Path("out")))
        EXPECT_THAT(entry.path().filename().string(), Not(testing::StartsWith(".")));
    }
  }
}

}  // namespace
}  // namespace drape::test
