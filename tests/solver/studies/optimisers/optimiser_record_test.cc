// SPDX-License-Identifier: Apache-2.0
// A record of a run is read back to the last bit, or refused.
#include "solver/studies/optimisers/optimiser_record.h"

#include <cmath>
#include <limits>

#include "physics/material/material_scaling.h"
#include "physics/util/stored/stored_json.h"
#include "solver/studies/optimisers/drape_function.h"
#include "solver/studies/optimisers/methods/optimiser.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/util/stored/tampering.h"
#include "tests/solver/fake_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

using nlohmann::json;

class OptimiserRecordTest : public FileFixture {
 protected:
  OptimiserRecordTest() {
    problem_.fine = &backend_;
    problem_.material = test::TestMaterial();
    problem_.observations = {
        test::ObserveDrape(backend_, Scaled(test::TestMaterial(), 3.0, 1.5), 45)};
    expected_.stages.residuals.solve_mode = SolveMode::kDynamic;
    expected_.stages.parameters = ParameterTying::kScales;
    record_ = Run();
  }
  // The record of a run in a few steps.
  BenchmarkRecord Run() {
    const TableParametrisation tables(problem_.material, ParameterTying::kScales);
    const State start = {backend_.Shape(problem_.material),
                         Eigen::VectorXd::Zero(backend_.model().num_dofs())};
    DrapeFunction function(&backend_, &tables, &problem_.observations, {start},
                           expected_.stages.residuals, expected_.stages.prior_sigma);
    BenchmarkRecord record;
    record.problem = expected_.problem;
    record.parameters = 2;
    OptimiserOptions options;
    options.budget = 20.0;
    for (const OptimiserMethod& method : OptimiserMethods())
      if (method.available && method.derivatives) expected_.method = method.name;
    options.published_rates = Eigen::VectorXd::Constant(2, 0.05);
    record.run = RunOptimiser(expected_.method, function, options);
    record.shape = function.best_shapes().front();
    record.rms_px = *OutlineRms(backend_.model().mesh, record.shape, problem_.observations[0]);
    record.settled_rms_px = std::numeric_limits<double>::infinity();  // no outline at rest
    record.drift = 1e-3;
    record.stiffness = -0.5;
    return record;
  }
  json Members() const {
    WriteBenchmarkRecord(path_, expected_.settings, record_);
    return ReadStoredJson(path_, kRecordFormat);
  }
  // Empty: it is read.
  std::string ComputeError(const json& members) const {
    test::WriteQuickly(path_, StoredJsonText(kRecordFormat, members));
    try {
      ReadBenchmarkRecord(path_, expected_);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(path_));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
      return error.what();
    }
    return "";
  }

  test::FakeBackend backend_;
  FitProblem problem_;
  ExpectedRecord expected_{.settings = "budget 20",
                           .problem = "wool_2",
                           .method = {},
                           .most_spent = 21.0,
                           .fit = problem_,
                           .stages = {},
                           .guess = {}};
  BenchmarkRecord record_;
  const std::string path_ = Path("wool_2.lm.json");
};

TEST_F(OptimiserRecordTest, IsReadBackBitForBit) {
  ASSERT_GT(record_.run.trace.size(), 1u);
  EXPECT_FALSE(ReadBenchmarkRecord(path_, expected_));
  WriteBenchmarkRecord(path_, expected_.settings, record_);
  const BenchmarkRecord read = *ReadBenchmarkRecord(path_, expected_);
  EXPECT_EQ(read.run.theta, record_.run.theta);
  EXPECT_EQ(read.run.cost, record_.run.cost);
  EXPECT_EQ(read.run.trace.size(), record_.run.trace.size());
  EXPECT_EQ(read.shape, record_.shape);
  EXPECT_EQ(read.rms_px, record_.rms_px);
  EXPECT_EQ(read.settled_rms_px, record_.settled_rms_px);
  EXPECT_EQ(read.stiffness, record_.stiffness);
}

TEST_F(OptimiserRecordTest, ARunThatFoundNothingIsReadBack) {
  record_.run.trace.clear();
  record_.run.theta.resize(0);
  record_.shape.resize(0);
  WriteBenchmarkRecord(path_, expected_.settings, record_);
  EXPECT_TRUE(std::isinf(ReadBenchmarkRecord(path_, expected_)->run.cost));
}

TEST_F(OptimiserRecordTest, EveryMemberIsChecked) {
  int tried = 0;
  const test::Tampering tampering(Members(), [&](const std::string& what, const json& tampered) {
    ++tried;
    if (what == "/stiffness = -1") return;   // an unstable drape
    if (what == "/run/end = \"x\"") return;  // any text
    EXPECT_NE(ComputeError(tampered), "") << what;
  });
  EXPECT_GT(tried, 200);
}

TEST_F(OptimiserRecordTest, WhatARunCannotHaveFoundIsRefused) {
  struct Change {
    const char* at;
    json value;
    const char* error;
  };
  const Change changes[] = {
      {"/settings", "other", "found a run with other settings"},
      {"/problem", "wool_7", "key 'problem'"},
      {"/parameters", 7, "key 'parameters'"},
      {"/seed", 3, "key 'seed'"},
      {"/run/method", "adam", "key 'run.method'"},
      {"/run/function_seconds", 1e6, "key 'run.function_seconds'"},
      {"/run/jacobian_seconds", 1e6, "key 'run.jacobian_seconds'"},
      {"/run/trace", json::array(), "key 'run.theta'"},
      {"/run/trace/0/2", 0.0, "a lower cost than that of the point before"},
      {"/run/trace/0/0", 1e6, "key 'run.trace[0][0]'"},
      {"/run/spent", 1e6, "key 'run.spent'"},
      {"/run/theta", json::array(), "expected an array of 2"},
      {"/run/theta", {1e3, 0.0}, "tables are not finite"},
      {"/run/failed", 1000000, "key 'run.failed'"},
      {"/shape", json::array(), "key 'shape'"},
      {"/shape", std::vector<double>(record_.shape.size(), 0.0), "found a torn or crushed cloth"},
      {"/rms_px", 0.0, "found an outline error [px] of 0"}};
  const json members = Members();
  EXPECT_EQ(ComputeError(members), "");
  for (const Change& change : changes) {
    json changed = members;
    changed[json::json_pointer(change.at)] = change.value;
    EXPECT_THAT(ComputeError(changed), testing::HasSubstr(change.error)) << change.at;
  }
  json cheaper = members;
  cheaper["run"]["trace"].back()[2] = 0.0;
  EXPECT_THAT(ComputeError(cheaper), testing::HasSubstr("found a cost of 0"));
}

TEST_F(OptimiserRecordTest, NoMutantIsMoreThanARecordOrAnError) {
  const std::string members = Members().dump();
  std::mt19937_64 random(18);
  for (int i = 0; i < test::NumMutants(1000); ++i) {
    const json mutant = json::parse(test::Mutant(members, random), nullptr, false);
    if (mutant.is_object()) ComputeError(mutant);
  }
}

}  // namespace
}  // namespace drape
