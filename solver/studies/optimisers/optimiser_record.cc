// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_record.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using nlohmann::json;

json ToJson(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

Eigen::VectorXd Vector(const JsonInput& input) {
  Eigen::VectorXd values(input.ExpectArray().Size());
  for (int i = 0; i < values.size(); ++i) values[i] = input.At(i).Number();
  return values;
}

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
          {"evaluations", run.evaluations},
          {"jacobians", run.jacobians},
          {"failed", run.failed}};
}

OptimiserRun ReadRun(const JsonInput& input) {
  OptimiserRun run;
  run.method = input.At("method").String();
  run.end = input.At("end").String();
  const JsonInput trace = input.At("trace");
  for (int i = 0; i < trace.ExpectArray().Size(); ++i) {
    const JsonInput point = trace.At(i);
    point.ExpectArray(3);
    run.trace.push_back({point.At(0).Number(), point.At(1).Number(), point.At(2).Number()});
    run.cost = run.trace.back().cost;
  }
  run.theta = Vector(input.At("theta"));
  run.spent = input.At("spent").Number();
  run.seconds = input.At("seconds").Number();
  run.jacobian_seconds = input.At("jacobian_seconds").Number();
  run.evaluations = input.At("evaluations").Integer();
  run.jacobians = input.At("jacobians").Integer();
  run.failed = input.At("failed").Integer();
  return run;
}

}  // namespace

void WriteBenchmarkRecord(const std::string& path, const std::string& settings,
                          const BenchmarkRecord& record) {
  const json file = {{"format", "drapefit-optimiser-run"},
                     {"settings", settings},
                     {"problem", record.problem},
                     {"parameters", record.parameters},
                     {"run", ToJson(record.run)},
                     {"shape", ToJson(record.shape)},
                     {"rms_px", record.rms_px},
                     {"settled_rms_px", record.settled_rms_px},
                     {"drift_m", record.drift},
                     {"stiffness", record.stiffness}};
  WriteFileAtomically(path, file.dump() + "\n");
}

std::optional<BenchmarkRecord> ReadBenchmarkRecord(const std::string& path,
                                                   const std::string& settings) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (input.At("settings").String() != settings)
    throw InputError(path,
                     "found a run with other settings, expected the same ones or another "
                     "--out");
  BenchmarkRecord record;
  record.problem = input.At("problem").String();
  record.parameters = input.At("parameters").Integer();
  record.run = ReadRun(input.At("run"));
  record.shape = Vector(input.At("shape"));
  record.rms_px = input.At("rms_px").Number();
  record.settled_rms_px = input.At("settled_rms_px").Number();
  record.drift = input.At("drift_m").Number();
  record.stiffness = input.At("stiffness").Number();
  return record;
}

}  // namespace drape
