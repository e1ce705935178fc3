// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/bench/bench_report.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/math/statistics.h"
#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

Json MeasuresJson(const BenchRecord& record) {
  Json json = Json::object();
  for (int m = 0; m < kBenchMeasures; ++m)
    if (std::isfinite(record.values[m]))
      json[NameFor(static_cast<BenchMeasure>(m))] = record.values[m];
  return json;
}

Json BenchRunJson(const BenchRun& run) {
  Json json;
  for (const auto& [name, value] : ListAxes(run.setting)) json[name] = value;
  json["status"] = run.record.status;
  json.update(MeasuresJson(run.record));
  return json;
}

}  // namespace

std::string BenchTableText(const BenchJob& job, const BenchResult& result, BenchMeasure time) {
  const BenchMeasure error = ListErrors(job.work).front();
  std::string text = Format("%10s %10s %8s  %s\n", "seconds", NameFor(error), "peak MB", "front");
  for (const int i : AccuracyFront(result, time, error)) {
    const BenchRun& run = result.runs[i];
    text += Format("%10.3g %10.3g %8.0f  %s\n", run.record[time], run.record[error],
                   run.record[kPeakMegabytes], MakeLabel(run.setting, job.axes).c_str());
  }
  std::map<std::string, int> excluded;  // runs by status
  for (const BenchRun& run : result.runs)
    if (!run.record.ok()) ++excluded[run.record.status];
  text += Format("%zu runs, ", result.runs.size());
  text += excluded.empty() ? "all at rest and on the branch" : "not on the front:";
  for (const auto& [status, count] : excluded) text += Format(" %d %s;", count, status.c_str());
  if (!excluded.empty()) text.pop_back();
  text += "\n";
  for (const auto& [cloth, estimate] : result.reference_errors)
    text += Format("reference of %s: estimated error %.3g (%s)\n", cloth.c_str(), estimate[error],
                   NameFor(error));
  return text + NoReferencesText(result);
}

std::string NoReferencesText(const BenchResult& result) {
  std::string text;
  for (const auto& [cloth, reason] : result.no_references)
    text += "no reference of " + cloth + ": " + reason + " (another start or mesh?)\n";
  return text;
}

void WriteBenchJson(const std::string& path, const BenchJob& job, const BenchResult& result,
                    BenchMeasure time) {
  Json json = {{"work", ToString(job.work)},
               {"common", job.common},
               {"clock", time == kCpuSeconds ? "cpu" : "wall"}};
  for (const auto& [cloth, estimate] : result.reference_errors)
    json["reference_errors"][cloth] = MeasuresJson(estimate);
  for (const auto& [cloth, reason] : result.no_references) json["no_references"][cloth] = reason;
  for (const BenchMeasure error : ListErrors(job.work))
    for (const int i : AccuracyFront(result, time, error))
      json["fronts"][NameFor(error)].push_back(BenchRunJson(result.runs[i]));
  for (const GrowthSeries& one : MakeGrowth(job, result, time))
    json["growth"].push_back(
        {{"setting", one.name},
         {"seconds_exponent", FitPowerLaw(one.vertices, one.seconds)->exponent},
         {"memory_exponent", FitPowerLaw(one.vertices, one.megabytes)->exponent}});
  json["runs"] = Json::array();
  for (const BenchRun& run : result.runs) json["runs"].push_back(BenchRunJson(run));
  WriteWithProvenance(path, std::move(json));
}

}  // namespace drape
