// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_survey.h"

#include <cmath>
#include <exception>
#include <set>
#include <utility>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/stored/csv_log.h"

namespace drape {
namespace {

const CsvRow kResultColumns = {"outcome",  "steps",     "seconds",
                               "residual", "speed_m_s", "distance_m"};

// The inputs of a run, which have neither quotation marks nor commas in them, and its results.
CsvRow Columns() {
  CsvRow columns = ParseCsvRow(kStabilityInputColumns, "columns");
  columns.insert(columns.end(), kResultColumns.begin(), kResultColumns.end());
  return columns;
}

std::string Field(const std::optional<double>& value) {
  std::string field;
  if (value) AppendNumber(field, *value);
  return field;
}

CsvRow Row(const std::string& inputs, const StabilityRun& run) {
  CsvRow row = ParseCsvRow(inputs, "inputs");
  for (std::string field :
       {std::string(ToString(run.outcome)), std::to_string(run.steps), Field(run.seconds),
        Field(run.residual), Field(run.speed), Field(run.distance)})
    row.push_back(std::move(field));
  return row;
}

double NotNegative(const std::string& text, const std::string& where) {
  const double value = ParseCsvNumber(text, where);
  if (value < 0)
    throw InputError(where, "found '" + text + "', expected a number that is not negative");
  return value;
}
std::optional<double> Optional(const std::string& text, const std::string& where) {
  return text.empty() ? std::nullopt : std::optional(NotNegative(text, where));
}
int Steps(const std::string& text, const std::string& where) {
  constexpr double kMostSteps = 1e9;
  const double steps = NotNegative(text, where);
  if (steps > kMostSteps || steps != std::floor(steps))
    throw InputError(where, "found '" + text + "', expected a number of steps");
  return static_cast<int>(steps);
}

void AddRow(const CsvRow& row, const std::string& where, StabilityRuns& runs) {
  const std::size_t inputs = row.size() - kResultColumns.size();
  const std::string* result = &row[inputs];
  runs[FormatCsvRow({row.begin(), row.begin() + static_cast<std::ptrdiff_t>(inputs)})] = {
      .outcome = ParseStabilityOutcome(result[0], where),
      .steps = Steps(result[1], where),
      .seconds = NotNegative(result[2], where),
      .residual = Optional(result[3], where),
      .speed = Optional(result[4], where),
      .distance = Optional(result[5], where)};
}

// Where the runs of all threads come together.
class Collector {
 public:
  Collector(const KeepStabilityRun& keep, int count, const RunControl& control, StabilityRuns& runs)
      : keep_(keep), count_(count), control_(control), runs_(runs) {}

  void Add(const StabilityCase& run, const StabilityRun& result) {
    const std::string inputs = StabilityInputs(run);
    keep_(inputs, result);
    runs_[inputs] = result;
    ++done_;
    control_.Report(done_ / static_cast<double>(count_),
                    "run " + std::to_string(done_) + " of " + std::to_string(count_));
  }
  void Fail(std::exception_ptr error) {
    if (!error_) error_ = std::move(error);
  }
  bool MustEnd() const { return error_ || *control_.cancel; }
  void Rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  const KeepStabilityRun& keep_;
  int count_, done_ = 0;
  const RunControl& control_;
  StabilityRuns& runs_;
  std::exception_ptr error_;
};

// One run; what it throws ends the survey.
void RunOne(StabilityRunner& runner, const StabilityCase& run, const std::atomic<bool>& cancel,
            Collector& collector) {
  bool must_end = false;
#pragma omp critical(drape_stability)
  must_end = collector.MustEnd();
  if (must_end) return;
  try {
    const std::optional<StabilityRun> result = runner.Run(run, cancel);
#pragma omp critical(drape_stability)
    try {
      if (result) collector.Add(run, *result);
    } catch (...) {
      collector.Fail(std::current_exception());
    }
  } catch (...) {
#pragma omp critical(drape_stability)
    collector.Fail(std::current_exception());
  }
}

}  // namespace

StabilityRuns ReadStabilityRuns(const std::string& path, const std::string& shared) {
  StabilityRuns runs;
  for (const auto& [where, row] : ReadCsvLog(path, shared, Columns())) AddRow(row, where, runs);
  return runs;
}

void WriteStabilityRuns(const std::string& path, const std::string& shared,
                        const StabilityRuns& runs) {
  std::vector<CsvRow> rows;
  for (const auto& [inputs, run] : runs) rows.push_back(Row(inputs, run));
  WriteCsvLog(path, shared, Columns(), rows);
}

std::string StabilityRow(const std::string& inputs, const StabilityRun& run) {
  return FormatCsvRow(Row(inputs, run));
}

void ParseStabilityRow(const std::string& row, const std::string& where, StabilityRuns& runs) {
  const CsvRow fields = ParseCsvRow(row, where);
  if (fields.size() != Columns().size())
    throw InputError(where, "found " + std::to_string(fields.size()) + " fields, expected " +
                                std::to_string(Columns().size()));
  AddRow(fields, where, runs);
}

std::vector<StabilityCase> DistinctCases(std::span<const StabilityMap> maps) {
  std::vector<StabilityCase> cases;
  std::set<std::string> seen;
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : map.Cases())
      if (seen.insert(StabilityInputs(run)).second) cases.push_back(run);
  return cases;
}

bool SurveyStability(StabilityRunner& runner, std::span<const StabilityCase> cases, int threads,
                     const KeepStabilityRun& keep, const RunControl& control, StabilityRuns& runs) {
  std::vector<StabilityCase> missing;
  for (const StabilityCase& run : cases)
    if (!runs.contains(StabilityInputs(run))) missing.push_back(run);
  Collector collector(keep, static_cast<int>(missing.size()), control, runs);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (int i = 0; i < static_cast<int>(missing.size()); ++i)
    RunOne(runner, missing[i], *control.cancel, collector);
  collector.Rethrow();
  return !*control.cancel;
}

bool SurveyStability(StabilityRunner& runner, std::span<const StabilityMap> maps, int threads,
                     const std::string& path, const RunControl& control, StabilityRuns& runs) {
  const auto append = [&](const std::string& inputs, const StabilityRun& run) {
    AppendCsvRow(path, Row(inputs, run));
  };
  return SurveyStability(runner, DistinctCases(maps), threads, append, control, runs);
}

}  // namespace drape
