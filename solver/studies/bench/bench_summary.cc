// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_summary.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "physics/util/text_format.h"
#include "solver/studies/bench/pareto.h"

namespace drape {
namespace {

std::string UnitName(BenchMeasure error) {
  switch (error) {
    case kVertexMm:
      return "rms distance of the vertices [mm]";
    case kOutlineMm:
      return "rms distance of the outline [mm]";
    case kRadiusMm:
      return "error of the outline's mean radius [mm]";
    case kDerivativeError:
      return "relative error of the derivative by 39 log entries";
    case kOutlinePx:
      return "rms distance of the outline, at rest [px]";
    case kHausdorffMm:
      return "Hausdorff distance of the outlines, at rest [mm]";
    case kMse:
      return "MSE of the silhouettes, at rest";
    default:
      return NameFor(error);
  }
}

std::string TimeName(BenchMeasure time) {
  return time == kCpuSeconds ? "processor time [s]" : "wall-clock time [s]";
}

// One series a method, that of its first other settings: more than a picture can hold.
std::vector<GrowthSeries> ShownGrowth(const BenchJob& job, const BenchResult& result,
                                      BenchMeasure time) {
  BenchResult shown;
  std::set<std::string> kept;  // settings but the mesh
  std::set<std::string> methods;
  for (const BenchRun& run : result.runs) {
    BenchSetting rest = run.setting;
    rest.mesh.clear();
    const std::string identity = CheckpointKey(job.work, rest);
    if (!kept.contains(identity) && !methods.insert(MethodName(rest, job.axes)).second) continue;
    kept.insert(identity);
    shown.runs.push_back(run);
  }
  return MakeGrowth(job, shown, time);
}

FrontChart MakeChart(const BenchJob& job, const BenchResult& result, BenchMeasure time,
                     BenchMeasure error) {
  FrontChart chart{.title = std::string("Work against precision: ") + ToString(job.work),
                   .cost_name = TimeName(time),
                   .error_name = UnitName(error),
                   .series = {},
                   .points = {}};
  for (const BenchRun& run : result.runs) {
    auto& series = chart.series;
    const std::string method = MethodName(run.setting, job.axes);
    auto at = std::find(series.begin(), series.end(), method);
    if (at == series.end()) at = series.insert(at, method);
    chart.points.push_back({.cost = run.record[time],
                            .error = run.record[error],
                            .vertices = run.record[kVertices],
                            .series = static_cast<int>(at - series.begin()),
                            .excluded = run.record.ok() ? "" : run.record.status,
                            .label = MakeLabel(run.setting, job.axes)});
  }
  for (const auto& [cloth, estimate] : result.reference_errors)
    if (std::isfinite(estimate[error]))
      chart.reference_error = std::max(chart.reference_error, estimate[error]);
  return chart;
}

}  // namespace

BenchMeasure TimeMeasure(const std::string& clock) {
  return clock == "cpu" ? kCpuSeconds : kWallSeconds;
}

std::vector<BenchMeasure> ListErrors(BenchWork work) {
  switch (work) {
    case BenchWork::kForward:
      return {kRadiusMm, kOutlineMm, kVertexMm};
    case BenchWork::kGradient:
    case BenchWork::kJacobian:
      return {kDerivativeError, kOutlineMm};
    case BenchWork::kFit:
      return {kOutlinePx, kMse, kHausdorffMm, kHeldOutMse};
  }
  return {};
}

std::vector<int> AccuracyFront(const BenchResult& result, BenchMeasure time, BenchMeasure error) {
  std::vector<CostAndError> points;
  for (const BenchRun& run : result.runs) {
    points.push_back({run.record.ok() ? run.record[time] : std::nan(""), run.record[error]});
  }
  return ParetoFront(points);
}

std::vector<GrowthSeries> MakeGrowth(const BenchJob& job, const BenchResult& result,
                                     BenchMeasure time) {
  BenchAxes varied = job.axes;
  varied.mesh.resize(1);
  std::vector<GrowthSeries> all;
  for (const BenchRun& run : result.runs) {
    const BenchRecord& record = run.record;
    if (!(record[time] > 0 && record[kPeakMegabytes] > 0)) continue;
    const std::string name = MakeLabel(run.setting, varied);
    auto it = std::find_if(all.begin(), all.end(), [&](const auto& s) { return s.name == name; });
    if (it == all.end())
      it = all.insert(all.end(), {.name = name, .vertices = {}, .seconds = {}, .megabytes = {}});
    it->vertices.push_back(record[kVertices]);
    it->seconds.push_back(record[time]);
    it->megabytes.push_back(record[kPeakMegabytes]);
  }
  std::erase_if(all, [](const GrowthSeries& one) {
    return std::set<double>(one.vertices.begin(), one.vertices.end()).size() < 2;
  });
  return all;
}

std::vector<CodeSeries> CompareCodes(const BenchResult& result, BenchMeasure time,
                                     const PublishedSpeeds& published) {
  std::vector<CodeSeries> codes;
  std::vector<const BenchRecord*> reference_law;
  for (const auto& [setting, record] : result.runs) {
    if (!record.ok() || !(record[kRadiusMm] > 0)) continue;
    if (setting.law != "smooth") {
      reference_law.push_back(&record);
      continue;
    }
    const std::string name =
        "drapefit, " + (setting.backend == "cpu" ? Format("%d thread%s", setting.threads,
                                                          setting.threads == 1 ? "" : "s")
                                                 : Format("GPU, %d at once", setting.batch));
    auto it =
        std::find_if(codes.begin(), codes.end(), [&](const auto& s) { return s.name == name; });
    if (it == codes.end()) it = codes.insert(it, {.name = name});
    it->vertices.push_back(record[kVertices]);
    it->seconds.push_back(record[time]);
    it->radius_mm.push_back(record[kRadiusMm]);
  }
  if (reference_law.empty()) return {};
  constexpr double kAlike = 0.1;  // share of the vertices
  for (const PublishedSpeed& row : published.rows) {
    CodeSeries code{.name = row.name + ", " + row.machine};
    for (std::size_t i = 0; i < row.forward.size(); ++i)
      for (const BenchRecord* ours : reference_law)
        if (std::abs((*ours)[kVertices] / published.vertices[i] - 1) < kAlike) {
          code.vertices.push_back(published.vertices[i]);
          code.seconds.push_back(kPublishedSteps * row.forward[i]);
          code.radius_mm.push_back((*ours)[kRadiusMm]);
          break;
        }
    if (!code.seconds.empty()) codes.push_back(std::move(code));
  }
  return codes;
}

void RenderBenchCharts(const std::string& folder, const BenchJob& job, const BenchResult& result,
                       BenchMeasure time) {
  for (const BenchMeasure error : ListErrors(job.work))
    RenderFrontChart(folder + "/front_" + NameFor(error), MakeChart(job, result, time, error));
  RenderGrowthChart(folder + "/growth", std::string("Growth with the mesh: ") + ToString(job.work),
                    TimeName(time), ShownGrowth(job, result, time));
  if (const std::vector<CodeSeries> codes = CompareCodes(result, time, job.published);
      !job.published.rows.empty() && !codes.empty())
    RenderCodesChart(folder + "/codes", TimeName(time), codes);
}

}  // namespace drape
