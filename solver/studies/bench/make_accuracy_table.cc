// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/make_accuracy_table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "physics/util/errors.h"
#include "solver/studies/bench/pareto.h"

namespace drape {
namespace {

// What the fabrics of one setting say together: mean time, worst error.
struct Candidate {
  AccuracyRow row;
  int fabrics = 0;
};

std::vector<Candidate> Candidates(const BenchJob& job, const BenchResult& result, BenchMeasure time,
                                  double safety) {
  std::map<std::string, Candidate> by_setting;
  const double fabrics = static_cast<double>(job.axes.material.size());
  double reference_error = 0.0;
  for (const auto& [cloth, estimate] : result.reference_errors)
    reference_error = std::max(reference_error, estimate[kRadiusMm]);
  for (const BenchRun& run : result.runs) {
    if (!run.record.ok() || run.setting.integrator == "static") continue;
    BenchSetting rest = run.setting;
    rest.material.clear();
    Candidate& candidate = by_setting[CheckpointKey(job.work, rest)];
    AccuracyRow& row = candidate.row;
    row.mesh = rest.mesh;
    row.integrator = rest.integrator;
    row.h = rest.h;
    row.steps = rest.steps();
    row.error_mm = std::max(row.error_mm, safety * (run.record[kRadiusMm] + reference_error));
    row.residual = std::max(row.residual, run.record[kForceResidual]);
    row.drift_mm = std::max(row.drift_mm, run.record[kDriftMm]);
    row.cost += run.record[time] / fabrics;
    ++candidate.fabrics;
  }
  std::vector<Candidate> all;
  for (const auto& [identity, candidate] : by_setting)
    if (candidate.fabrics == static_cast<int>(job.axes.material.size())) all.push_back(candidate);
  return all;
}

// A row must promise at least so much less than the next faster one, as a share: what is less is
// the rounding of Newton's method.
constexpr double kLeastGain = 0.01;

// Those of an integrator that no other beats.
std::vector<AccuracyRow> AccuracyFront(const std::vector<Candidate>& candidates,
                                       const std::string& integrator) {
  std::vector<AccuracyRow> rows, front;
  std::vector<CostAndError> points;
  for (const Candidate& candidate : candidates) {
    if (candidate.row.integrator != integrator) continue;
    rows.push_back(candidate.row);
    points.push_back({candidate.row.cost, candidate.row.error_mm});
  }
  for (const int i : ParetoFront(points))
    if (front.empty() || rows[i].error_mm < (1.0 - kLeastGain) * front.back().error_mm)
      front.push_back(rows[i]);
  return front;
}

}  // namespace

AccuracyTable MakeAccuracyTable(const BenchJob& job, const BenchResult& result, BenchMeasure time,
                                double safety) {
  const std::vector<Candidate> candidates = Candidates(job, result, time, safety);
  AccuracyTable table;
  table.made_on = job.common;
  table.rows = AccuracyFront(candidates, "hybrid");
  if (table.rows.empty())
    throw InputError("option 'table'",
                     "found no hybrid setting that keeps the branch of all fabrics and ends at "
                     "rest, expected some");
  // A fit needs a hybrid setting of each level.
  table.fast = table.rows.front().error_mm;
  table.exact = table.rows.back().error_mm;
  table.balanced = std::sqrt(table.fast * table.exact);
  const double exact_cost = table.rows.back().cost;
  for (const AccuracyRow& row : AccuracyFront(candidates, "dynamic")) table.rows.push_back(row);
  for (AccuracyRow& row : table.rows) row.cost /= exact_cost;
  std::sort(table.rows.begin(), table.rows.end(),
            [](const AccuracyRow& a, const AccuracyRow& b) { return a.cost < b.cost; });
  return table;
}

}  // namespace drape
