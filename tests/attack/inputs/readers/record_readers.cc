// SPDX-License-Identifier: Apache-2.0
// Files that programs write for themselves: a checkpoint with fitted branches, records of a
// benchmark, growing tables. The cloth is one without physics, so that thousands are read quickly.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "physics/util/errors.h"
#include "physics/util/stored/csv_log.h"
#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/fit_checkpoint.h"
#include "solver/studies/bench/cases/bench_record.h"
#include "solver/studies/optimisers/drape_function.h"
#include "solver/studies/optimisers/methods/optimiser.h"
#include "solver/studies/optimisers/optimiser_record.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"
#include "tests/solver/fake_fit.h"

namespace drape::attack {
namespace {

using nlohmann::json;

constexpr char kJob[] = "job";

// In its second round, with one branch fitted.
StagedFitState MakeHalfwayState(const test::FakeFit& small) {
  std::vector<StagedFitState> saved;
  StagedFitControl control;
  control.save = [&](const StagedFitState& state) { saved.push_back(state); };
  RunStagedFit(small.problem, small.options, {}, control);
  const auto found = std::find_if(saved.begin(), saved.end(), [](const StagedFitState& state) {
    return state.round == 1 && DoneCandidates(state) == 1;
  });
  if (found == saved.end()) throw std::runtime_error("the fit has no second round");
  return *found;
}

// What is read must be a state from which the fit continues to its end.
std::string ReadAndContinue(const test::FakeFit& small, const std::string& path) {
  const auto state = ReadCheckpoint(path, kJob, small.problem, small.options);
  if (!state) return "found no checkpoint";
  const int rounds = static_cast<int>(small.options.candidates_per_round.size());
  const StagedFitState end = RunStagedFit(small.problem, small.options, *state, {});
  // Where no initial guess comes to rest there is nothing to fit.
  return end.round == rounds || end.candidates.empty() ? ""
                                                       : "continued to another round than the last";
}

std::vector<Reader> MakeCheckpointReaders(const std::string& scratch) {
  const auto small = std::make_shared<test::FakeFit>();
  const std::string path = scratch + "checkpoint.json";
  WriteCheckpoint(path, kJob, MakeHalfwayState(*small));
  const auto read = [small](const std::string& from) { return ReadAndContinue(*small, from); };
  return {{.name = "checkpoint",
           .file = "checkpoint.json",
           .content = ReadText(path),
           .read = read,
           .is_json = false},
          {.name = "checkpoint with its checksum",
           .file = "checkpoint.json",
           .content = ReadStoredJson(path, kCheckpointFormat).dump(),
           .read = read,
           .seal = [](const json& members) { return StoredJsonText(kCheckpointFormat, members); }}};
}

// A record of a few steps of a method.
BenchmarkRecord MakeRecord(test::FakeFit& small, ExpectedRecord* expected) {
  const TableParametrisation tables(small.problem.material, ParameterTying::kScales);
  const State start = {small.backend.Shape(small.problem.material),
                       Eigen::VectorXd::Zero(small.backend.model().num_dofs())};
  DrapeFunction function(&small.backend, &tables, &small.problem.observations, {start},
                         expected->stages.residuals, expected->stages.prior_sigma);
  OptimiserOptions options;
  options.budget = 20.0;
  options.published_rates = Eigen::VectorXd::Constant(2, 0.05);
  for (const OptimiserMethod& method : OptimiserMethods())
    if (method.available && method.derivatives) expected->method = method.name;
  BenchmarkRecord record;
  record.problem = expected->problem;
  record.parameters = 2;
  record.run = RunOptimiser(expected->method, function, options);
  record.shape = function.best_shapes().front();
  record.rms_px =
      *OutlineRms(small.backend.model().mesh, record.shape, small.problem.observations[0]);
  record.settled_rms_px = record.rms_px;
  return record;
}

std::vector<Reader> MakeBenchmarkReaders(const std::string& scratch) {
  const auto small = std::make_shared<test::FakeFit>();
  small->backend.fails = [](double, double) { return false; };
  const std::shared_ptr<ExpectedRecord> expected(new ExpectedRecord{.settings = "budget 20",
                                                                    .problem = "wool_2",
                                                                    .method = {},
                                                                    .most_spent = 21.0,
                                                                    .fit = small->problem,
                                                                    .stages = small->options,
                                                                    .guess = {}});
  const std::string path = scratch + "record.json";
  WriteBenchmarkRecord(path, expected->settings, MakeRecord(*small, expected.get()));
  const auto read = [small, expected](const std::string& from) {
    return ReadBenchmarkRecord(from, *expected) ? std::string() : "found no record";
  };
  return {{.name = "record",
           .file = "record.json",
           .content = ReadText(path),
           .read = read,
           .is_json = false},
          {.name = "record with its checksum",
           .file = "record.json",
           .content = ReadStoredJson(path, kRecordFormat).dump(),
           .read = read,
           .seal = [](const json& members) { return StoredJsonText(kRecordFormat, members); }}};
}

Reader MakeBenchTable(const std::string& scratch) {
  const std::string path = scratch + "runs.csv";
  BenchFile file(path, "work=forward", false);
  BenchRecord record;
  record.status = "ok";
  record[kWallSeconds] = 0.25;
  record[kOutlineMm] = 1.5e-3;
  for (const double h : {0.1, 0.2, 0.4}) {
    BenchSetting setting;
    setting.material = "a, \"b\".json";
    setting.h = h;
    file.Add(BenchWork::kForward, setting, record);
  }
  return {.name = "runs of drape_bench",
          .file = "runs.csv",
          .content = ReadText(path),
          .read =
              [](const std::string& from) {
                BenchFile(from, "work=forward", true);
                return std::string();
              },
          .is_json = false};
}

}  // namespace

std::vector<Reader> MakeRecordReaders(const std::string& scratch) {
  std::vector<Reader> readers = MakeCheckpointReaders(scratch);
  for (Reader& reader : MakeBenchmarkReaders(scratch)) readers.push_back(std::move(reader));
  readers.push_back(MakeBenchTable(scratch));
  return readers;
}

}  // namespace drape::attack
