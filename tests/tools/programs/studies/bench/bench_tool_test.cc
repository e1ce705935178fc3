// SPDX-License-Identifier: Apache-2.0
// drape_bench as a user runs it: files, cells, Ctrl-C, bad input.
#include <fstream>

#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kBench = std::string(DRAPE_BIN_DIR) + "/drape_bench";
const std::string kSeed = std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json";
const std::string kRedWool = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/wool_red.json";

class BenchTool : public ToolFixture {
 protected:
  ProcessResult Bench(const std::vector<std::string>& more = {}, ProcessLimits limits = {}) const {
    limits.charts = charts_;
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

  Json Cells(const std::string& out) const { return ReadJson(out + "/bench.json")["cells"]; }
  // The results of the runs in bench.json.
  Json Runs(const std::string& out) const {
    Json runs = Json::array();
    for (const Json& cell : Cells(out)) runs.push_back(cell["result"]);
    return runs;
  }
  // The cell file of the reference of the cloth.
  std::string ReferenceFile() const {
    for (const auto& [file, text] : Snapshot(Path("out/cells")))
      if (text.find("bench_reference") != std::string::npos) return file;
    return "";
  }

  bool charts_ = false;
};

TEST_F(BenchTool, MeasuresTheProductAndContinues) {
  charts_ = true;
  const ProcessResult first = Bench();
  charts_ = false;
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, testing::HasSubstr("4 runs, "));
  const Json runs = Runs(Path("out"));
  ASSERT_EQ(runs.size(), 4u);
  for (const Json& run : runs) {
    EXPECT_GT(run["seconds"].get<double>(), 0);
    EXPECT_GT(run["peak_mb"].get<double>(), 0);
    EXPECT_GT(run["vertex_mm"].get<double>(), 0);
    EXPECT_EQ(run["repeats"], 2);
  }
  for (const char* chart : {"front_outline_mm", "front_vertex_mm", "front_radius_mm", "growth"})
    for (const char* kind : {".png", ".svg"})
      EXPECT_GT(Read(Path("out/") + chart + kind).size(), 1000u) << chart;
  EXPECT_THAT(Read(Path("out/report.md")), testing::HasSubstr("# Pareto front: "));
  const std::string table = Read(Path("out/runs.csv"));
  EXPECT_THAT(table, testing::StartsWith("# forward start=six_waves.json coarse_mesh=disc:120 "
                                         "reference=disc:200+disc:300 "));
  EXPECT_THAT(table, testing::HasSubstr("\nwork,material,law,"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2 + 4);
  ASSERT_EQ(Bench().exit_code, 0);
  EXPECT_EQ(Read(Path("out/runs.csv")), table);
  ASSERT_EQ(Bench({"--mesh=disc:120,disc:160,disc:200"}).exit_code,
            0);  // further values of an axis
  const Json more = Runs(Path("out"));
  ASSERT_EQ(more.size(), 6u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(more[k], runs[k]);
}

TEST_F(BenchTool, RunsOfChangedInputsAreNotMixedIn) {
  Write("wool.json", Read(kRedWool));
  Write("start.json", Read(kSeed));
  const std::vector<std::string> inputs = {"--fabric=" + Path("wool.json"), "--mesh=disc:120",
                                           "--start=" + Path("start.json")};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> options = inputs;
    options.insert(options.end(), more.begin(), more.end());
    return options;
  };
  ASSERT_EQ(Bench(with({"--share=0/2"})).exit_code, 0);
  ASSERT_EQ(Snapshot(Path("out/cells")).size(), 2u);  // a run and its reference
  Json heavy = Json::parse(Read(kRedWool), nullptr, true, true);
  heavy["density"] = 1.5 * heavy["density"].get<double>();
  Write("wool.json", heavy.dump());
  ASSERT_EQ(Bench(with({"--share=1/2"})).exit_code, 0);
  ASSERT_EQ(Snapshot(Path("out/cells")).size(), 4u);
  ASSERT_EQ(Bench(with({})).exit_code, 0);
  ASSERT_EQ(Bench(with({"--out=" + Path("fresh")})).exit_code, 0);
  const Json mixed = Runs(Path("out")), fresh = Runs(Path("fresh"));
  for (const char* number : {"vertex_mm", "radius_mm", "dc", "reference_errors"})
    for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(mixed[k][number], fresh[k][number]) << number;
  Write("start.json", Read(kSeed) + " ");
  ASSERT_EQ(Bench(with({"--share=1/2"})).exit_code, 0);
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 7u);
  ASSERT_EQ(Bench(with({"--share=1/2", "--order=1"})).exit_code, 0);  // the reference is the same
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 8u);
  ASSERT_EQ(Bench(with({"--share=1/2", "--reference=disc:160,disc:200"})).exit_code, 0);
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 10u);
}

TEST_F(BenchTool, SharesHaveTheirOwnRunsWhichTheWholeTakesOver) {
  const ProcessResult list = Bench({"--list"});
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 4);
  EXPECT_THAT(list.out,
              testing::StartsWith("forward material=wool_red mesh=disc:120 time_step=0.2\n"));
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessResult share = Bench({"--share=1/3"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, testing::HasSubstr("share 1/3: 1 of 1 cells are complete"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/runs.csv")));
  const auto cells = Snapshot(Path("out/cells"));
  ASSERT_EQ(cells.size(), 2u);  // the reference and one run
  ASSERT_EQ(Bench().exit_code, 0);
  const Json runs = Runs(Path("out"));
  ASSERT_EQ(runs.size(), 4u);
  bool kept = false;  // the second run, to its last digit
  for (const auto& [file, text] : cells) {
    EXPECT_EQ(Read(file), text);
    kept |= text.find(runs[1]["seconds"].dump()) != std::string::npos;
  }
  EXPECT_TRUE(kept);
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
  for (const Json& cell : Cells(Path("out")))
    EXPECT_EQ(cell["result"]["status"] == "no reference", cell["input"]["material"] == "lead")
        << cell;
  EXPECT_THAT(Bench({materials}).out, testing::HasSubstr(reason));
  const ProcessResult none =
      Bench({"--fabric=" + Path("lead.json"), "--share=0/2", "--out=" + Path("none")});
  EXPECT_THAT(none.out,
              testing::HasSubstr("share 0/2: 2 of 2 cells are complete, of which 2 failed"));
  EXPECT_EQ(Bench({"--fabric=" + Path("lead.json"), "--out=" + Path("none")}).exit_code, 3);
}

TEST_F(BenchTool, MeasuresDerivatives) {
  for (const char* work : {"gradient", "jacobian"}) {
    const std::string out = Path(work);
    const ProcessResult result =
        Bench({std::string("--work=") + work, "--solve=dynamic,static", "--mode=adjoint,tangent",
               "--mesh=disc:120", "--out=" + out});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json runs = Runs(out);
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
  const std::string report = Read(Path("out/report.md"));
  EXPECT_THAT(report, testing::HasSubstr("| hybrid"));
  EXPECT_THAT(report, testing::Not(testing::HasSubstr("| dynamic")));
  for (const Json& cell : Cells(Path("out"))) {
    const Json& run = cell["result"];
    const double residual = run["force_residual"], drift = run["drift_mm"];
    const bool is_dynamic = cell["input"]["solve"] == "dynamic";
    EXPECT_EQ(residual > 1e-6, is_dynamic) << run;
    EXPECT_TRUE(is_dynamic || drift < 1e-3) << run;
    EXPECT_NE(run["status"], is_dynamic ? "ok" : "not at rest") << run;
  }
}

TEST_F(BenchTool, ADamagedReferenceIsRefused) {
  ASSERT_EQ(Bench({"--mesh=disc:120", "--solve=hybrid"}).exit_code, 0);
  const std::string path = ReferenceFile();
  std::string text = Read(path);
  const std::size_t x = text.find("\"x\":[");
  ASSERT_NE(x, std::string::npos);
  text[text.find('1', x)] = '2';
  std::ofstream(path) << text;
  ExpectOneLineError(Bench({"--mesh=disc:120", "--solve=static"}), "is damaged or was altered");
}

TEST_F(BenchTool, FitsOfDistributionsHaveDraws) {
  const ProcessResult result = Bench(
      {"--work=fit", "--ground_truth=" + kRedWool, "--ground_truth_mesh=disc:120",
       "--mesh=disc:100", "--relax_time=4", "--solve=static", "--model=homogeneous,bdp",
       "--draws=2,4", "--candidates_per_round=1", "--iterations=2", "--posterior_iterations=1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json cells = Cells(Path("out"));
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(cells[2]["input"]["draws"], 4);
  for (const Json& cell : cells) EXPECT_GT(cell["result"]["mse"].get<double>(), 0) << cell;
  std::size_t fits = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Path("out/fits")))
    fits += std::filesystem::exists(entry.path() / "summary.json");
  EXPECT_EQ(fits, 3u);
}

TEST_F(BenchTool, KeepsTheRunsThatEndedBeforeCtrlC) {
  ASSERT_EQ(Bench({"--mesh=disc:120", "--solve=hybrid"}).exit_code, 0);
  std::filesystem::remove(Path("out/runs.csv"));
  const ProcessResult result = Bench(
      {"--mesh=disc:120", "--solve=hybrid", "--relax_time=10,400,401,402,403,404,405,406,407"},
      {.interrupt_when = Path("out/bench.json"), .interrupt_after = kSlowdown});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  const Json json = ReadJson(Path("out/bench.json"));
  EXPECT_EQ(json["outcome"], "cancelled");
  EXPECT_TRUE(json["cells"].front()["result"].is_object());
  EXPECT_TRUE(json["cells"].back()["result"].is_null());
  EXPECT_FALSE(std::filesystem::exists(Path("out/runs.csv")));
}

TEST_F(BenchTool, RefusesBadInput) {
  ExpectOneLineError(Bench({"--solve=fast"}), "one of dynamic, hybrid, static");
  ExpectOneLineError(Bench({"--mesh=disc:ten"}), "disc:ten");
  ExpectOneLineError(Bench({"--model=bdp"}), "which only fits have");
  ExpectOneLineError(Bench({"--reference=disc:300"}), "expected two: coarse, fine");
  ExpectOneLineError(Bench({"--reference=disc:300,disc:200"}), "expected a finer mesh");
  ExpectOneLineError(Bench({"--work=gradient", "--published=" + Path("t.json")}),
                     "expected forward");
  ExpectOneLineError(Bench({"--time_step=1e-300"}), "at most 1e6 time steps");
  ExpectOneLineError(Bench({"--time_step=0.1,0.1"}), "found two runs 'forward ");
  ExpectOneLineError(Bench({"--share=2/2"}), "expected i/n");
  ExpectOneLineError(Bench({"--work=fit", "--solve=hybrid"}), "'ground_truth'");
  ExpectOneLineError(Bench({"--fabric=" + Path("none.json")}), "none.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(BenchTool, TheTableIsWhatAccuracyPicksFrom) {
  const std::string table = Path("out/accuracy.json");
  ASSERT_EQ(Bench().exit_code, 0);
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
