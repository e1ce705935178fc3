// SPDX-License-Identifier: Apache-2.0
// drape_bench's plan, records, extrapolation, front and table, on made-up numbers.
#include <unistd.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "physics/simulation/backend.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "solver/studies/bench/bench_summary.h"
#include "solver/studies/bench/cases/bench_plan.h"
#include "solver/studies/bench/cases/bench_record.h"
#include "solver/studies/bench/make_accuracy_table.h"
#include "solver/studies/bench/pareto.h"
#include "solver/studies/bench/richardson.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class Work>
std::string ComputeError(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

BenchAxes TwoByTwo() {
  BenchAxes axes;
  axes.material = {"fabrics/wool.json"};
  axes.mesh = {"disc:300", "disc:600"};
  axes.h = {0.2, 0.1};
  axes.mode = {"adjoint", "tangent"};
  return axes;
}

TEST(ParetoFront, HoldsWhatNoPointBeatsFastestFirst) {
  EXPECT_THAT(ParetoFront({{3, 1}, {1, 5}, {2, 5}, {2, 2}, {4, 1}, {2, 2}, {kNaN, 0}, {0, kNaN}}),
              ElementsAre(1, 3, 0));
  EXPECT_THAT(ParetoFront({{1, 0.5}, {2, 0.5 * (1 - 1e-9)}, {3, 0.4999}}), ElementsAre(0, 2));
  EXPECT_TRUE(ParetoFront({}).empty());
}

TEST(Extrapolate, IsExactForItsOrder) {
  const auto quantity = [](double size, double order) {
    return Eigen::Vector2d(3 + 2 * std::pow(size, order), 5 - std::pow(size, order)).eval();
  };
  for (const double order : {1.0, 2.0, 3.0}) {
    const Eigen::Vector2d limit =
        Extrapolate<Eigen::Vector2d>(quantity(0.1, order), quantity(0.15, order), 1.5, order);
    EXPECT_LT((limit - Eigen::Vector2d(3, 5)).norm(), 1e-12) << order;
  }
}

TEST(BenchPlan, IsTheProductOfTheAxesThatTheWorkHas) {
  const auto forward = ListRuns(BenchWork::kForward, TwoByTwo());
  ASSERT_EQ(forward.size(), 4u);
  EXPECT_EQ(forward[0].mesh, "disc:300");
  EXPECT_EQ(forward[0].h, 0.2);
  EXPECT_EQ(forward[1].h, 0.1);
  EXPECT_EQ(forward[1].steps(), 100);
  EXPECT_EQ(forward[2].mesh, "disc:600");
  EXPECT_EQ(ListRuns(BenchWork::kGradient, TwoByTwo()).size(), 8u);
}

TEST(BenchPlan, OnlyDistributionsHaveDraws) {
  BenchAxes axes = TwoByTwo();
  axes.mesh.resize(1);
  axes.h.resize(1);
  axes.mode.resize(1);
  axes.model = {"homogeneous", "bdp"};
  axes.draws = {8, 16};
  const auto runs = ListRuns(BenchWork::kFit, axes);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(MethodName(runs[0], axes), "homogeneous");
  EXPECT_EQ(MethodName(runs[2], axes), "bdp");
  EXPECT_EQ(MakeLabel(runs[2], axes), "bdp draws=16");
  EXPECT_EQ(MakeLabel(runs[0], axes), "homogeneous");
}

TEST(BenchPlan, OneThreadHasNoBatches) {
  BenchAxes axes = TwoByTwo();
  axes.mesh.resize(1);
  axes.h.resize(1);
  axes.backend = {"cpu", "cuda"};
  axes.batch = {1, 64};
  EXPECT_EQ(ListRuns(BenchWork::kForward, axes).size(), 3u);
  axes.threads = {2};
  EXPECT_EQ(ListRuns(BenchWork::kForward, axes).size(), 4u);
}

TEST(BenchPlan, AMethodIsWhatTheAxesVary) {
  BenchAxes axes = TwoByTwo();
  axes.mode.resize(1);
  BenchSetting run;
  EXPECT_EQ(MethodName(run, axes), "hybrid");
  axes.backend = {"cpu", "cuda"};
  EXPECT_EQ(MethodName(run, axes), "cpu");
  axes.integrator = {"hybrid", "static"};
  EXPECT_EQ(MethodName(run, axes), "hybrid cpu");
}

TEST(BenchPlan, NamesEachRun) {
  const auto runs = ListRuns(BenchWork::kGradient, TwoByTwo());
  std::set<std::string> identities;
  for (const BenchSetting& run : runs) identities.insert(CheckpointKey(BenchWork::kGradient, run));
  EXPECT_EQ(identities.size(), runs.size());
  EXPECT_NE(CheckpointKey(BenchWork::kForward, runs[0]),
            CheckpointKey(BenchWork::kGradient, runs[0]));
  EXPECT_EQ(MakeLabel(runs[2], TwoByTwo()), "disc:300 time_step=0.1 adjoint");
}

TEST(BenchPlan, RejectsValuesThatNoRunCanHave) {
  BenchAxes axes = TwoByTwo();
  axes.integrator = {"hybrid", "implicit"};
  EXPECT_EQ(ComputeError([&] { ListRuns(BenchWork::kForward, axes); }),
            "axis 'solve': found 'implicit', expected one of dynamic, hybrid, static");
  axes = TwoByTwo();
  axes.h = {0.1, 0.1};
  EXPECT_EQ(ComputeError([&] { ListRuns(BenchWork::kForward, axes); }),
            "axis 'time_step': found 0.1 twice, expected different values");
  axes.h = {};
  EXPECT_EQ(ComputeError([&] { ListRuns(BenchWork::kForward, axes); }),
            "axis 'time_step': found no value, expected at least one");
  EXPECT_THAT(ComputeError([] { ParseBenchWork("backward"); }), HasSubstr("found 'backward'"));
}

class BenchFileTest : public FileFixture {
 protected:
  BenchSetting Cell(double h) const {
    BenchSetting run;
    run.material = "wool.json";
    run.h = h;
    return run;
  }
};

TEST_F(BenchFileTest, IsReadBackByAResumedRun) {
  BenchRecord record;
  record.status = "other branch";
  record[kVertexMm] = 1.0 / 3;
  BenchFile(Path("runs.csv"), "seed=a", false).Add(BenchWork::kForward, Cell(0.1), record);
  const BenchFile resumed(Path("runs.csv"), "seed=a", true);
  EXPECT_TRUE(resumed.continues());
  EXPECT_FALSE(BenchFile(Path("new.csv"), "seed=a", true).continues());
  const BenchRecord* found = resumed.Find(CheckpointKey(BenchWork::kForward, Cell(0.1)));
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->status, "other branch");
  EXPECT_EQ((*found)[kVertexMm], 1.0 / 3);
  EXPECT_TRUE(std::isnan((*found)[kOutlineMm]));
  EXPECT_EQ(resumed.Find(CheckpointKey(BenchWork::kForward, Cell(0.2))), nullptr);
  EXPECT_EQ(resumed.Find(CheckpointKey(BenchWork::kGradient, Cell(0.1))), nullptr);
}

TEST_F(BenchFileTest, RefusesWhatIsNotItsOwn) {
  const std::string path = Path("runs.csv");
  { const BenchFile without_runs(path, "seed=0", false); }  // it may be replaced
  BenchFile(path, "seed=a", false).Add(BenchWork::kForward, Cell(0.1), BenchRecord());
  EXPECT_THAT(ComputeError([&] { BenchFile(path, "seed=a", false); }), HasSubstr("--resume"));
  EXPECT_THAT(ComputeError([&] { BenchFile(path, "seed=b", true); }),
              HasSubstr("found '# seed=a', expected '# seed=b'"));
  Write("runs.csv", Read(path) + "forward,wool\n");
  EXPECT_THAT(ComputeError([&] { BenchFile(path, "seed=a", true); }),
              HasSubstr("runs.csv:4: found 2 fields"));
}

TEST_F(BenchFileTest, NamesMayHaveCommasAndACutRowIsMeasuredAgain) {
  const std::string path = Path("runs.csv");
  BenchSetting odd = Cell(0.1);
  odd.material = "a,\"b\"\nc.json";
  BenchRecord record;
  record.status = "ok";
  record[kWallSeconds] = 0.25;
  {
    BenchFile file(path, "seed=a, b", false);
    file.Add(BenchWork::kForward, odd, record);
    file.Add(BenchWork::kForward, Cell(0.2), record);
  }
  const std::string whole = Read(path);
  Write("runs.csv", whole.substr(0, whole.size() - 5));
  BenchFile resumed(path, "seed=a, b", true);
  ASSERT_NE(resumed.Find(CheckpointKey(BenchWork::kForward, odd)), nullptr);
  EXPECT_EQ(resumed.Find(CheckpointKey(BenchWork::kForward, Cell(0.2))), nullptr);
  resumed.Add(BenchWork::kForward, Cell(0.2), record);
  EXPECT_EQ(Read(path), whole);
}

TEST_F(BenchFileTest, NumbersThatNoRunHasAreRefused) {
  for (const char* line : {"ok,nan", "ok,inf", "ok,1,-1", "ok,1e999", "ok,x"}) {
    std::string fields = line;
    while (std::count(fields.begin(), fields.end(), ',') < kBenchMeasures) fields += ',';
    EXPECT_INPUT_ERROR(ParseRecordLine(fields, "run"), "expected a number");
  }
}

// Threads of the parent do not survive the fork; the child would wait for them forever.
TEST(RunInChild, RunsBatchesInParallelAfterItsParentDid) {
  const auto model = SmallDisc("smooth", 100);
  const MaterialField material = TestMaterial();
  const State start = model->RestState();
  const std::vector<RolloutInput> batch(8, {&material, &start});
  const auto run = [&] {
    MakeCpuBackend(model, 2)->Rollouts(batch, {.h = 0.1, .steps = 2}, nullptr);
    return std::string("done");
  };
  run();
  std::atomic<bool> cancel = false;
  std::jthread watch([&](const std::stop_token& stop) {
    for (int i = 0; i < 300 && !stop.stop_requested(); ++i) usleep(100000);
    cancel = true;
  });
  EXPECT_EQ(RunInChild(run, &cancel).output, "done");
}

// Two fabrics; the finer mesh is 16 times as slow, and its coarse step leaves the branch of one.
struct MadeUpBench {
  BenchJob job;
  BenchResult result;

  MadeUpBench() {
    job.axes.material = {"a.json", "b.json"};
    for (const std::string& material : job.axes.material) {
      const double worse = material == "b.json" ? 2 : 1;
      Add(material, "disc:300", "hybrid", 0.1, 8 * worse, 1);
      Add(material, "disc:1200", "hybrid", 0.1, 1 * worse, 16);
      Add(material, "disc:1200", "hybrid", 0.2, 1 * worse, 8, worse > 1 ? "other branch" : "ok");
      Add(material, "disc:600", "dynamic", 0.1, 3 * worse, 4);
      Add(material, "disc:4800", "static", 0.1, 0.1, 1);
      Add(material, "disc:1200", "dynamic", 0.4, 1 * worse, 2, worse > 1 ? "not at rest" : "ok");
    }
  }
  void Add(const std::string& material, const std::string& mesh, const std::string& integrator,
           double h, double error, double seconds, const std::string& status = "ok") {
    BenchRun run;
    run.setting.material = material;
    run.setting.mesh = mesh;
    run.setting.integrator = integrator;
    run.setting.h = h;
    run.record.status = status;
    run.record[kRadiusMm] = error;
    run.record[kForceResidual] = 1e-10 * error;
    run.record[kDriftMm] = 1e-3 * error;
    run.record[kWallSeconds] = seconds;
    result.runs.push_back(run);
  }
  AccuracyTable Table() const { return MakeAccuracyTable(job, result, kWallSeconds, 1.5); }
};

TEST(AccuracyTable, PromisesTheWorstFabricTimesTheSafety) {
  const AccuracyTable table = MadeUpBench().Table();
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[0].mesh, "disc:300");
  EXPECT_DOUBLE_EQ(table.rows[0].error_mm, 24);
  EXPECT_DOUBLE_EQ(table.rows[0].cost, 1.0 / 16);
  EXPECT_DOUBLE_EQ(table.rows[2].error_mm, 3);
  EXPECT_DOUBLE_EQ(table.exact, 3);
  EXPECT_DOUBLE_EQ(table.fast, 24);
  EXPECT_DOUBLE_EQ(table.rows[0].residual, 16e-10);  // of the worse fabric
  EXPECT_DOUBLE_EQ(table.rows[0].drift_mm, 16e-3);
}

// Two seconds for 2 mm would beat every other row, were it at rest with both fabrics.
TEST(AccuracyTable, ASettingThatIsNotAtRestHasNoRow) {
  MadeUpBench bench;
  for (const AccuracyRow& row : bench.Table().rows) EXPECT_NE(row.h, 0.4);
  std::vector<int> front = AccuracyFront(bench.result, kWallSeconds, kRadiusMm);
  for (const int i : front) EXPECT_TRUE(bench.result.runs[i].record.ok()) << i;
  for (BenchRun& run : bench.result.runs)
    if (run.setting.integrator == "hybrid") run.record.status = kRunNotAtRest;
  EXPECT_INPUT_ERROR(bench.Table(), "keeps the branch of all fabrics and ends at rest");
}

TEST(AccuracyTable, PicksTheCheapestThatHolds) {
  const AccuracyTable table = ParseAccuracyTable(AccuracyTableText(MadeUpBench().Table()), "t");
  EXPECT_EQ(table.Pick("fast", "").mesh, "disc:300");
  EXPECT_EQ(table.Pick("10mm", "").mesh, "disc:600");
  EXPECT_EQ(table.Pick("10mm", "hybrid").mesh, "disc:1200");
  EXPECT_EQ(table.Pick("exact", "").mesh, "disc:1200");
  EXPECT_EQ(table.Pick("balanced", "hybrid").mesh, "disc:1200");
}

TEST(AccuracyTable, RefusesWhatItHasNot) {
  const AccuracyTable table = MadeUpBench().Table();
  EXPECT_EQ(ComputeError([&] { table.Pick("0.5mm", ""); }),
            "option 'accuracy': found 0.5mm, expected at least 3mm: the table has nothing more "
            "exact");
  for (const char* text : {"good", "2", "-1mm", "mm", "2 mm", "nanmm"})
    EXPECT_THAT(ComputeError([&] { table.Pick(text, ""); }), HasSubstr("such as 0.5mm")) << text;
  EXPECT_THAT(ComputeError([] { ParseAccuracyTable("{\"format\": \"x\"}", "t"); }),
              HasSubstr("t: key"));
  AccuracyTable at_rest = table;
  std::erase_if(at_rest.rows, [](const auto& row) { return row.integrator == "dynamic"; });
  EXPECT_EQ(ComputeError([&] { at_rest.Pick("fast", "dynamic"); }),
            "option 'accuracy': found solve = dynamic, expected hybrid: the table has no dynamic "
            "setting whose drapes are at rest");
}

TEST(AccuracyTable, TwiceTheTimeForNothingIsNoRow) {
  MadeUpBench bench;
  for (const double worse : {1.0, 2.0})
    bench.Add(worse > 1 ? "b.json" : "a.json", "disc:1200", "hybrid", 0.05, 0.999 * worse, 32);
  const AccuracyTable table = bench.Table();
  EXPECT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.Pick("exact", "hybrid").h, 0.1);
}

// A table goes through the same ranges as the options that it sets.
TEST(AccuracyTable, RefusesNumbersOutOfRange) {
  const auto text = nlohmann::json::parse(AccuracyTableText(MadeUpBench().Table()));
  const auto error = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json changed = text;
    (changed.contains(key) ? changed : changed["rows"][1])[key] = value;
    return ComputeError([&] { ParseAccuracyTable(changed.dump(), "t.json"); });
  };
  EXPECT_EQ(error("steps", 2000000000),
            "t.json: key 'rows[1].steps': found 2000000000, expected a whole number from 1 to "
            "1000000");
  EXPECT_EQ(error("time_step", 1e9),
            "t.json: key 'rows[1].time_step': found 1000000000.0, expected a number from 0.0001 "
            "to 10");
  EXPECT_EQ(error("residual", 0.01),
            "t.json: key 'rows[1].residual': found 0.01, expected a number from 0 to 1e-06");
  EXPECT_EQ(error("drift_mm", 2),
            "t.json: key 'rows[1].drift_mm': found 2, expected a number from 0 to 1");
  EXPECT_EQ(error("mesh", "disc:99999999"),
            "t.json: key 'rows[1].mesh': found \"disc:99999999\", expected disc:N with N from 100 "
            "to 1000000");
  for (const char* mesh : {"disc:", "disc", "disc:600,radius=9", "../mesh.obj", ""})
    EXPECT_THAT(error("mesh", mesh), HasSubstr("'rows[1].mesh'")) << mesh;
  EXPECT_THAT(error("error_mm", 0), HasSubstr("'rows[1].error_mm'"));
  EXPECT_THAT(error("cost", -1), HasSubstr("'rows[1].cost'"));
  EXPECT_THAT(error("fast_mm", 1e300), HasSubstr("'fast_mm'"));
  EXPECT_THAT(error("max_residual", 1), HasSubstr("'max_residual'"));
  EXPECT_THAT(error("version", 1), HasSubstr("found 1, expected 2, a table of drapes at rest"));
}

BenchRun MakeRun(const std::string& law, double vertices, double seconds, double radius_mm) {
  BenchRun run;
  run.setting.law = law;
  run.record.status = kRunOk;
  run.record[kVertices] = vertices;
  run.record[kCpuSeconds] = seconds;
  run.record[kRadiusMm] = radius_mm;
  return run;
}

TEST(CompareCodes, GivesAPublishedProgramTheErrorOfItsMesh) {
  BenchResult result;
  result.runs = {MakeRun("smooth", 300, 0.05, 2.0), MakeRun("reference", 300, 0.06, 8.0),
                 MakeRun("reference", 1200, 0.4, 3.3)};
  PublishedSpeeds published{.vertices = {297, 1205, 2699}, .rows = {}};
  published.rows.push_back({.name = "other",
                            .machine = "a GPU",
                            .source = "",
                            .forward = {0.01, 0.03, 0.1},
                            .backward = {}});
  const std::vector<CodeSeries> codes = CompareCodes(result, kCpuSeconds, published);
  ASSERT_EQ(codes.size(), 2u);
  EXPECT_EQ(codes[0].name, "drapefit, 1 thread");
  EXPECT_EQ(codes[0].radius_mm, std::vector<double>{2.0});
  EXPECT_EQ(codes[1].name, "other, a GPU");
  EXPECT_EQ(codes[1].seconds, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(codes[1].radius_mm, (std::vector<double>{8.0, 3.3}));  // no run is like the third mesh
  result.runs.resize(1);
  EXPECT_TRUE(CompareCodes(result, kCpuSeconds, published).empty());
}

}  // namespace
}  // namespace drape::test
