// SPDX-License-Identifier: Apache-2.0
// --backend of the programs: what auto chooses, what is refused, what the files say.
#include "cuda/engine/cuda_backend.h"
#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "tests/tools/tool_fixture.h"
#include "tools/inputs/common_options.h"

namespace drape::test {
namespace {

const std::string kEquilibria = std::string(DRAPE_BIN_DIR) + "/drape_equilibria";

#define DRAPE_NEEDS_NO_GPU() \
  if (SurveyCuda().usable) GTEST_SKIP() << "there is a GPU here: auto takes it"

class BackendTool : public ToolFixture {
 protected:
  std::string Name(const std::string& summary) const {
    return ReadJson(Path(summary)).at("backend");
  }
  ProcessResult Branches(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {kEquilibria,           "--mesh=disc:120",     "--samples=2",
                                        "--steps=20",          "--fabric=" + kFabric, "--threads=1",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
  // A silhouette of the start material: a fit of few rollouts.
  void MakeImage() const {
    ASSERT_EQ(
        Simulate({"--mesh=disc:150", "--steps=60", "--time_step=0.1", "--backend=cpu"}).exit_code,
        0);
    std::filesystem::copy(Path("out/silhouette.png"), Path("drape.png"));
    std::filesystem::remove_all(Path("out"));
  }
  ProcessResult Fit(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {kFit,
                                        "--images=" + Path("drape.png"),
                                        "--fabric=" + kFabric,
                                        "--mesh=disc:150",
                                        "--coarse_mesh=disc:100",
                                        "--initial_stretch=1",
                                        "--initial_bend=0.5,1",
                                        "--initial_lifts=1",
                                        "--candidates_per_round=2,1",
                                        "--iterations=3,5",
                                        "--num_parameters=2",
                                        "--centre=nominal",
                                        "--threads=1",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(BackendTool, AutoFallsBackToTheCpu) {
  DRAPE_NEEDS_NO_GPU();
  ASSERT_EQ(Simulate({"--dump_steps=3"}).exit_code, 0);
  EXPECT_EQ(Name("out/summary.json"), "cpu");
  ASSERT_EQ(Simulate({"--dump_steps=3", "--backend=cpu", "--out=" + Path("asked")}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/state_3.json")), Read(Path("asked/state_3.json")));
  ASSERT_EQ(Branches({"--out=" + Path("branches")}).exit_code, 0);
  EXPECT_EQ(Name("branches/summary.json"), "cpu");
}

TEST_F(BackendTool, CudaIsRefusedWhereItCannotRun) {
  DRAPE_NEEDS_NO_GPU();
  MakeImage();
  const std::string why = SurveyCuda().text;
  ExpectOneLineError(Simulate({"--backend=cuda"}), why);
  ExpectOneLineError(Branches({"--backend=cuda"}), why);
  ExpectOneLineError(Fit({"--backend=cuda"}), why);
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

TEST_F(BackendTool, AnUnknownNameListsTheChoices) {
  const std::string expected = "option 'backend': found 'gpu', expected one of auto, cpu, cuda";
  ExpectOneLineError(Simulate({"--backend=gpu"}), expected);
  ExpectOneLineError(Branches({"--backend=gpu"}), expected);
  ExpectOneLineError(Fit({"--backend=gpu"}), expected);
}

TEST_F(BackendTool, TheFirstLineSaysWhereItRuns) {
  const CudaSurvey survey = SurveyCuda();
  const std::string line = "running on " + (survey.usable ? survey.text : "1 CPU thread");
  std::vector<std::string> lines;
  const auto log = [&](const std::string& said) { lines.push_back(said); };
  MakeLoggedBackend("auto",
                    std::make_shared<ClothModel>(MakeDisc({.target_vertices = 120}), CusickScene(),
                                                 MakeLaw("smooth")),
                    1, {nullptr, nullptr, log});
  EXPECT_THAT(lines, testing::ElementsAre(line));
  MakeImage();
  ASSERT_EQ(Fit({}).exit_code, 0);
  EXPECT_THAT(Read(Path("out/fit.log")), testing::HasSubstr("\n" + line + "\n"));
}

TEST_F(BackendTool, WhyThereIsNoGpuIsAnswered) {
  DRAPE_NEEDS_NO_GPU();
  const std::string why = "no GPU: " + SurveyCuda().text;
  const auto verbose = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = SimulateCommand(more);
    command.insert(command.begin(), {"/usr/bin/env", "GLOG_v=1"});
    return RunProcess(command).err;
  };
  EXPECT_THAT(verbose({}), testing::HasSubstr(why));
  EXPECT_THAT(Simulate({}).err, testing::Not(testing::HasSubstr("GPU")));
  EXPECT_THAT(verbose({"--backend=cpu"}), testing::Not(testing::HasSubstr("GPU")));
}

// A fit continues where auto chooses another backend.
TEST_F(BackendTool, ACheckpointIsOfNoBackend) {
  MakeImage();
  ASSERT_EQ(Fit({"--backend=cpu", "--iterations=30,30", "--prior_sigma=9"},
                {.interrupt_when = Path("out/checkpoint.json"), .interrupt_after = 0.02})
                .exit_code,
            130);
  const ProcessResult resumed = Fit({"--iterations=30,30", "--prior_sigma=9", "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  const CudaSurvey survey = SurveyCuda();
  EXPECT_EQ(Name("out/summary.json"), survey.usable ? "cuda" : "cpu");
  EXPECT_THAT(Read(Path("out/fit.log")),
              testing::ContainsRegex("\nrunning on 1 CPU thread\n(.|\n)*\nrunning on " +
                                     (survey.usable ? survey.text : "1 CPU thread") + "\n"));
}

// Writing states in between does not change the drape: its pieces are one rollout.
TEST_F(BackendTool, PiecesAreOneRollout) {
  ASSERT_EQ(Simulate({"--steps=50", "--dump_steps=50"}).exit_code, 0);
  ASSERT_EQ(Simulate({"--steps=50", "--dump_steps=0,1,7,33,50", "--out=" + Path("more")}).exit_code,
            0);
  EXPECT_EQ(Read(Path("out/state_50.json")), Read(Path("more/state_50.json")));
}

TEST_F(BackendTool, CudaDrapesAsTheCpuDoes) {
  if (const CudaSurvey survey = SurveyCuda(); !survey.usable)
    GTEST_SKIP() << "needs a GPU: " << survey.text;
  for (const std::string name : {"cpu", "cuda"})
    ASSERT_EQ(
        Simulate({"--steps=12", "--dump_steps=5,12", "--backend=" + name, "--out=" + Path(name)})
            .exit_code,
        0);
  EXPECT_EQ(Name("cuda/summary.json"), "cuda");
  const State cpu = ReadState(Path("cpu/state_12.json"), 120);
  const State cuda = ReadState(Path("cuda/state_12.json"), 120);
  EXPECT_LT((cpu.x - cuda.x).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NE(cpu.x, cuda.x);
}

}  // namespace
}  // namespace drape::test
