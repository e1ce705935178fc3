// SPDX-License-Identifier: Apache-2.0
// drape_bench as a user runs it: files, resume, Ctrl-C, bad input.
#include "physics/util/stored/stored_json.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kBench = std::string(DRAPE_BIN_DIR) + "/drape_bench";
const std::string kSeed = std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json";
const std::string kRedWool = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/wool_red.json";

class BenchTool : public ToolFixture {
 protected:
  ProcessResult Bench(const std::vector<std::string>& more = {},
                      const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {kBench,
                                        "--fabric=" + kRedWool,
                                        "--start=" + kSeed,
                                        "--mesh=disc:120,disc:160",
                                        "--solve=hybrid,static",
                                        "--time_step=0.2",
                                        "--coarse_mesh=disc:120",
                                        "--reference=disc:200,disc:300",
                                        "--reference_relax_mesh=disc:200",
                                        "--repeats=2",
                                        "--branch_mm=50",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(BenchTool, MeasuresTheProductAndResumes) {
  const ProcessResult first = Bench();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, testing::HasSubstr("4 runs, "));
  const Json json = ReadJson(Path("out/bench.json"));
  ASSERT_EQ(json["runs"].size(), 4u);
  for (const Json& run : json["runs"]) {
    EXPECT_GT(run["seconds"].get<double>(), 0);
    EXPECT_GT(run["peak_mb"].get<double>(), 0);
    EXPECT_GT(run["vertex_mm"].get<double>(), 0);
    EXPECT_EQ(run["repeats"], 2);
  }
  for (const char* chart : {"front_outline_mm", "front_vertex_mm", "front_radius_mm", "growth"})
    for (const char* kind : {".png", ".svg"})
      EXPECT_GT(Read(Path("out/") + chart + kind).size(), 1000u) << chart;
  const std::string runs = Read(Path("out/runs.csv"));
  ASSERT_EQ(Bench({"--resume"}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/runs.csv")), runs);
  ExpectOneLineError(Bench(), "--resume");
  ExpectOneLineError(Bench({"--resume", "--order=1"}), "the file was made with other settings");
}

TEST_F(BenchTool, SharesHaveTheirOwnRunsWhichTheWholeTakesOver) {
  const ProcessResult list = Bench({"--list"});
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 4);
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessResult share = Bench({"--share=1/3"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, testing::HasSubstr("share 1/3: 1 of 1 cells are complete"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/runs.csv")));
  const std::string reference = Read(Path("out/reference_wool_red_smooth_homogeneous.json"));
  const auto cells = Snapshot(Path("out/cells"));
  ASSERT_EQ(cells.size(), 2u);  // settings and one run
  ASSERT_EQ(Bench().exit_code, 0);
  EXPECT_EQ(Read(Path("out/reference_wool_red_smooth_homogeneous.json")), reference);
  const Json runs = ReadJson(Path("out/bench.json"))["runs"];
  ASSERT_EQ(runs.size(), 4u);
  bool kept = false;  // the second run, to its last digit
  for (const auto& [file, text] : cells)
    kept |= text.find(runs[1]["seconds"].dump()) != std::string::npos;
  EXPECT_TRUE(kept);
  ExpectOneLineError(Bench({"--share=0/3", "--order=1"}), "made with other settings");
}

// A cloth that its weight pulls through the support has no drape.
TEST_F(BenchTool, AFabricWithoutAReferenceIsNamedAndTheOthersAreMeasured) {
  Json lead = ReadJson(kRedWool);
  lead["density"] = 1000.0;
  for (Json& row : lead["stretch"])
    for (Json& entry : row) entry = 1e-8 * entry.get<double>();
  for (Json& row : lead["bend"])
    for (Json& entry : row) entry = 1e-8 * entry.get<double>();
  Write("lead.json", lead.dump());
  const std::string materials = "--fabric=" + Path("lead.json") + "," + kRedWool;
  const std::string reason = "no reference of lead smooth homogeneous: the drape on disc:300 is '";
  const ProcessResult result = Bench({materials});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("8 runs, not on the front: 4 no reference"));
  EXPECT_THAT(result.out, testing::HasSubstr(reason));
  EXPECT_THAT(result.out, testing::HasSubstr("reference of wool_red smooth homogeneous: estim"));
  const Json json = ReadJson(Path("out/bench.json"));
  EXPECT_EQ(json["no_references"].size(), 1u);
  for (const Json& run : json["runs"])
    EXPECT_EQ(run["status"] == "no reference", run["material"] == "lead") << run;
  EXPECT_FALSE(std::filesystem::exists(Path("out/reference_lead_smooth_homogeneous.json")));
  EXPECT_THAT(Bench({materials, "--resume"}).out, testing::HasSubstr(reason));
  const ProcessResult none =
      Bench({"--fabric=" + Path("lead.json"), "--share=0/2", "--out=" + Path("none")});
  EXPECT_THAT(none.out, testing::HasSubstr(reason));
  EXPECT_THAT(none.out, testing::HasSubstr("share 0/2: 2 of 2 cells"));
  EXPECT_EQ(Bench({"--fabric=" + Path("lead.json"), "--out=" + Path("none")}).exit_code, 3);
}

TEST_F(BenchTool, MeasuresDerivatives) {
  for (const char* work : {"gradient", "jacobian"}) {
    const std::string out = Path(work);
    const ProcessResult result =
        Bench({std::string("--work=") + work, "--solve=dynamic,static", "--mode=adjoint,tangent",
               "--mesh=disc:120", "--out=" + out});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json runs = ReadJson(out + "/bench.json")["runs"];
    ASSERT_EQ(runs.size(), 4u);
    // Adjoint and tangent find the same.
    for (const int i : {0, 2}) {
      const double adjoint = runs[i]["derivative_error"], tangent = runs[i + 1]["derivative_error"];
      EXPECT_GT(adjoint, 0);
      EXPECT_NEAR(adjoint / tangent, 1, 1e-5) << work;
    }
  }
}

// Half a second of falling is no drape, however cheap.
TEST_F(BenchTool, ShowsWhatIsNotAtRestBesideTheFront) {
  const ProcessResult result =
      Bench({"--mesh=disc:120", "--solve=dynamic,hybrid", "--relax_time=1,10", "--branch_mm=1000"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("not at rest"));
  const Json json = ReadJson(Path("out/bench.json"));
  for (const Json& run : json["fronts"]["radius_mm"]) EXPECT_EQ(run["solve"], "hybrid");
  for (const Json& run : json["runs"]) {
    const double residual = run["force_residual"], drift = run["drift_mm"];
    const bool is_dynamic = run["solve"] == "dynamic";
    EXPECT_EQ(residual > 1e-6, is_dynamic) << run;
    EXPECT_TRUE(is_dynamic || drift < 1e-3) << run;
    EXPECT_NE(run["status"], is_dynamic ? "ok" : "not at rest") << run;
  }
}

// A drape and its outline in a stored reference must agree.
TEST_F(BenchTool, ATamperedReferenceIsRefused) {
  ASSERT_EQ(Bench({"--mesh=disc:120", "--solve=hybrid"}).exit_code, 0);
  const std::string path = Path("out/reference_wool_red_smooth_homogeneous.json");
  constexpr StoredFormat kFormat = {"drapefit-bench-reference", 1};
  const Json reference = ReadStoredJson(path, kFormat);
  for (const char* at : {"/fine/outline/0", "/coarse/outline/359", "/coarse/x/0"}) {
    Json tampered = reference;
    tampered[Json::json_pointer(at)] = -1.0;
    WriteStoredJson(path, kFormat, tampered);
    ExpectOneLineError(Bench({"--mesh=disc:120", "--solve=hybrid", "--resume"}),
                       "the outline is not that of x");
  }
}

// A reference is not reused by a run that does not continue its runs.
TEST_F(BenchTool, WithoutRunsTheReferenceIsMadeAgain) {
  ASSERT_EQ(Bench({"--mesh=disc:120", "--solve=hybrid"}).exit_code, 0);
  const std::string reference = Path("out/reference_wool_red_smooth_homogeneous.json");
  const std::string first = Read(reference);
  std::filesystem::remove(Path("out/runs.csv"));
  const ProcessResult other =
      Bench({"--mesh=disc:120", "--solve=hybrid", "--resume", "--reference=disc:160,disc:200"});
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE(Read(reference), first);
}

TEST_F(BenchTool, FitsOfDistributionsHaveDraws) {
  const ProcessResult result = Bench(
      {"--work=fit", "--ground_truth=" + kRedWool, "--ground_truth_mesh=disc:160",
       "--mesh=disc:120", "--relax_time=4", "--solve=static", "--model=homogeneous,bdp",
       "--draws=2,4", "--candidates_per_round=1", "--iterations=2", "--posterior_iterations=1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json runs = ReadJson(Path("out/bench.json"))["runs"];
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[2]["draws"], "4");
  for (const Json& run : runs) EXPECT_GT(run["mse"].get<double>(), 0) << run;
}

TEST_F(BenchTool, KeepsTheRunsThatEndedBeforeCtrlC) {
  const ProcessResult result =
      Bench({"--relax_time=400,401,402,403"}, {.interrupt_when = Path("out/reference_wool_red_"
                                                                      "smooth_homogeneous.json")});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_LT(ReadJson(Path("out/bench.json"))["runs"].size(), 16u);
}

TEST_F(BenchTool, RefusesBadInput) {
  ExpectOneLineError(Bench({"--solve=fast"}), "one of dynamic, hybrid, static");
  ExpectOneLineError(Bench({"--mesh=disc:ten"}), "disc:ten");
  ExpectOneLineError(Bench({"--model=bdp"}), "which only fits have");
  ExpectOneLineError(Bench({"--reference=disc:300"}), "expected two: coarse, fine");
  ExpectOneLineError(Bench({"--reference=disc:300,disc:200"}), "expected a finer mesh");
  ExpectOneLineError(Bench({"--work=gradient", "--table=" + Path("t.json")}), "expected forward");
  ExpectOneLineError(Bench({"--work=fit", "--solve=hybrid"}), "'ground_truth'");
  ExpectOneLineError(Bench({"--fabric=" + Path("none.json")}), "none.json");
}

TEST_F(BenchTool, TheTableIsWhatAccuracyPicksFrom) {
  const std::string table = Path("table.json");
  ASSERT_EQ(Bench({"--table=" + table}).exit_code, 0);
  const std::vector<std::string> command = {
      kSimulate,          "--fabric=" + kRedWool,      "--start=" + kSeed,
      "--accuracy=exact", "--accuracy_table=" + table, "--out=" + Path("drape")};
  const ProcessResult picked = RunProcess(command);
  ASSERT_EQ(picked.exit_code, 0) << picked.err;
  EXPECT_THAT(picked.out, testing::HasSubstr("accuracy exact: disc:1"));
  EXPECT_THAT(picked.out, testing::HasSubstr("expect the mean radius of the outline within"));
  EXPECT_EQ(ReadJson(Path("drape/summary.json"))["solve"], "hybrid");
  auto with_mesh = command;
  with_mesh.push_back("--mesh=disc:130");
  const ProcessResult given = RunProcess(with_mesh);
  EXPECT_THAT(given.out, testing::HasSubstr("given and kept: --mesh, so no error is promised"));
  EXPECT_EQ(ReadJson(Path("drape/summary.json"))["mesh"]["vertices"], 130);
  auto too_exact = command;
  too_exact[3] = "--accuracy=0.0001mm";
  ExpectOneLineError(RunProcess(too_exact), "the table has nothing more exact");
}

}  // namespace
}  // namespace drape::test
