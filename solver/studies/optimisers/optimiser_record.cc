// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_record.h"

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/fit/parameters/coupled_table.h"
#include "solver/fit/protocol/candidate_check.h"

namespace drape {
namespace {

using nlohmann::json;

json ToJson(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

json ToJson(const OptimiserRun& run) {
  json trace = json::array();
  for (const TracePoint& point : run.trace)
    trace.push_back({point.spent, point.seconds, point.cost});
  return {{"method", run.method},
          {"end", run.end},
          {"trace", trace},
          {"theta", ToJson(run.theta)},
          {"spent", run.spent},
          {"seconds", run.seconds},
          {"jacobian_seconds", run.jacobian_seconds},
          {"function_seconds", run.function_seconds},
          {"evaluations", run.evaluations},
          {"jacobians", run.jacobians},
          {"failed", run.failed}};
}

// The start, then points where the cost fell.
std::vector<TracePoint> ReadTrace(const JsonInput& input, double most_spent) {
  std::vector<TracePoint> trace;
  for (int i = 0; i < input.ExpectArray().Size(); ++i) {
    const JsonInput numbers = input.At(i).ExpectArray(3);
    const TracePoint point = {numbers.At(0).NumberWithin(0.0, most_spent),
                              numbers.At(1).NotNegative(), numbers.At(2).NotNegative()};
    if (i > 0 && (point.spent < trace.back().spent || point.seconds < trace.back().seconds))
      numbers.Fail("no less spent, and no fewer seconds, than at the point before");
    if (i > 0 && point.cost >= trace.back().cost)
      numbers.At(2).Fail("a lower cost than that of the point before");
    trace.push_back(point);
  }
  return trace;
}

OptimiserRun ReadRun(const JsonInput& input, const ExpectedRecord& expected) {
  input.ExpectKeys({"method", "end", "trace", "theta", "spent", "seconds", "jacobian_seconds",
                    "function_seconds", "evaluations", "jacobians", "failed"});
  OptimiserRun run;
  run.method = input.At("method").String();
  if (run.method != expected.method) input.At("method").Fail('"' + expected.method + '"');
  run.end = input.At("end").String();
  run.trace = ReadTrace(input.At("trace"), expected.most_spent);
  const bool found = !run.trace.empty();
  if (found) run.cost = run.trace.back().cost;
  const auto parameters = static_cast<int>(TyingMatrix(expected.stages.parameters).cols());
  run.theta = input.At("theta").Vector(found ? parameters : 0);
  run.spent =
      input.At("spent").NumberWithin(found ? run.trace.back().spent : 0.0, expected.most_spent);
  run.seconds = input.At("seconds").NotNegative();
  run.function_seconds = input.At("function_seconds").NumberWithin(0.0, run.seconds);
  run.jacobian_seconds = input.At("jacobian_seconds").NumberWithin(0.0, run.function_seconds);
  constexpr int kMostCounted = 1'000'000'000;
  run.evaluations = input.At("evaluations").IntegerWithin(found ? 1 : 0, kMostCounted);
  run.jacobians = input.At("jacobians").IntegerWithin(0, kMostCounted);
  run.failed = input.At("failed").IntegerWithin(0, run.evaluations + run.jacobians);
  return run;
}

// Infinity where the drape had no outline where it came to rest.
double ReadSettledRms(const JsonInput& input) {
  return input.value().is_null() ? std::numeric_limits<double>::infinity() : input.NotNegative();
}

// Also finds the coupling of its table.
void CheckDrape(BenchmarkRecord& record, const ExpectedRecord& expected, const std::string& path) {
  FitCandidate candidate;
  candidate.guess = expected.guess;
  candidate.base = GuessTables(ListStartTables(expected.fit), expected.guess);
  candidate.theta = record.run.theta;
  candidate.shapes = {record.shape};
  candidate.cost = record.run.cost;
  candidate.profile_rms = record.rms_px;
  CheckCandidate(expected.fit, expected.stages, candidate, path);
  record.coupling =
      LargestSquaredCoupling(FittedMaterial(expected.stages, candidate).stretch.front());
}

}  // namespace

void WriteBenchmarkRecord(const std::string& path, const std::string& settings,
                          const BenchmarkRecord& record) {
  WriteStoredJson(path, kRecordFormat,
                  {{"settings", settings},
                   {"problem", record.problem},
                   {"parameters", record.parameters},
                   {"seed", record.seed},
                   {"run", ToJson(record.run)},
                   {"shape", ToJson(record.shape)},
                   {"rms_px", record.rms_px},
                   {"settled_rms_px", record.settled_rms_px},
                   {"drift_m", record.drift},
                   {"stiffness", record.stiffness}});
}

std::optional<BenchmarkRecord> ReadBenchmarkRecord(const std::string& path,
                                                   const ExpectedRecord& expected) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json file = ReadStoredJson(path, kRecordFormat);
  const JsonInput input(file, path);
  input.ExpectKeys({"settings", "problem", "parameters", "seed", "run", "shape", "rms_px",
                    "settled_rms_px", "drift_m", "stiffness"});
  if (input.At("settings").String() != expected.settings)
    throw InputError(path,
                     "found a run with other settings, expected the same ones or another "
                     "--out");
  BenchmarkRecord record;
  record.problem = input.At("problem").String();
  if (record.problem != expected.problem) input.At("problem").Fail('"' + expected.problem + '"');
  record.run = ReadRun(input.At("run"), expected);
  const bool found = !record.run.trace.empty();
  const auto parameters = static_cast<int>(TyingMatrix(expected.stages.parameters).cols());
  record.parameters = input.At("parameters").IntegerWithin(parameters, parameters);
  record.seed = input.At("seed").IntegerWithin(expected.seed, expected.seed);
  record.shape = input.At("shape").Vector(found ? expected.fit.fine->model().num_dofs() : 0);
  record.rms_px = input.At("rms_px").NotNegative();
  record.settled_rms_px = ReadSettledRms(input.At("settled_rms_px"));
  record.drift = input.At("drift_m").NotNegative();
  record.stiffness = input.At("stiffness").Number();
  if (found) CheckDrape(record, expected, path);
  return record;
}

}  // namespace drape
