// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "physics/util/stored/csv_log.h"
#include "solver/studies/bench/cases/bench_plan.h"

namespace drape {

// What is measured of a run. NaN where the work has no such number. Errors are against the
// reference of WorkPrecision.
enum BenchMeasure {
  kVertices,
  kRepeats,
  kWallSeconds,  // median of one run [s], of a batch divided by its drapes
  kWallSpread,   // slowest − fastest [s]
  kCpuSeconds,   // the same in processor time of all threads
  kCpuSpread,
  kSetupSeconds,   // model, symbolic analysis, backend [s]; wall clock
  kPeakMegabytes,  // of the run's process, less that of one that does nothing [MB]
  kVertexMm,       // root mean square distance of the vertices from the reference there [mm]
  kOutlineMm,      // of the outline r(θ) [mm]
  kRadiusMm,       // of the radius of the circle of the silhouette's area: the error of the drape
                   // coefficient as a length [mm]
  kDrapeCoefficient,
  kDrapeCoefficientError,
  kFolds,
  kDerivativeError,  // ‖d − d_reference‖/‖d_reference‖ of gradient or Jacobian by log entries
  kOutlinePx,        // of a fit: root mean square of the outline at rest [px]
  kMse,              // of a fit's silhouettes, at rest
  kHausdorffMm,      // of a fit's outlines, at rest [mm]
  kHeldOutMse,       // of the fitted drapes on the images held out
  kForceResidual,  // of the drape, not of a fit: forces that remain, by the weight
  kDriftMm,        // largest movement of a vertex once it is released [mm]
  kBenchMeasures
};
// The column of runs.csv, "vertex_mm".
const char* NameFor(BenchMeasure measure);

// Statuses of runs that have a result; only those that are "ok" are on a front.
inline constexpr char kRunOk[] = "ok", kRunOnOtherBranch[] = "other branch",
                      kRunNotAtRest[] = "not at rest";
// Of a run that was not made, since there is nothing to compare it with.
inline constexpr char kRunNoReference[] = "no reference";

struct BenchRecord {
  std::string status;  // one of those above, or why there is no result
  std::array<double, kBenchMeasures> values;

  BenchRecord() { values.fill(std::numeric_limits<double>::quiet_NaN()); }
  double operator[](BenchMeasure measure) const { return values[measure]; }
  double& operator[](BenchMeasure measure) { return values[measure]; }
  bool ok() const { return status == kRunOk; }
  bool has_result() const { return ok() || status == kRunOnOtherBranch || status == kRunNotAtRest; }
};

// Status and numbers as one row of CSV "status,1,2,,3", and back (throws InputError, prefix
// `where`).
std::string RecordLine(const BenchRecord& record);
BenchRecord ParseRecordLine(const std::string& line, const std::string& where);

// runs.csv, a CSV log of the runs that have ended, so that an interrupted benchmark can be resumed.
class BenchFile {
 public:
  // Begins the file, or with `resume` reads the runs that it has; an unfinished last row is
  // dropped. Throws InputError when it cannot be written, holds what is no record, or was begun
  // with another `common`; without `resume` also when it has runs already.
  BenchFile(std::string path, const std::string& common, bool resume);

  // Whether a file of the same `common` was there.
  bool continues() const { return continues_; }
  const BenchRecord* Find(const std::string& identity) const;
  // Appends at once, to the disk.
  void Add(BenchWork work, const BenchSetting& setting, const BenchRecord& record);

 private:
  void RefuseRuns() const;
  std::vector<CsvRow> ReadRuns(const std::string& common);
  std::string path_;
  bool continues_ = false;
  std::map<std::string, BenchRecord> runs_;  // by identity
};

}  // namespace drape
