// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_survey.h"

#include <charconv>
#include <cmath>
#include <exception>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kInputs = 11;
constexpr char kResultColumns[] = ",outcome,steps,seconds,residual,speed_m_s,distance_m";
constexpr int kColumns = kInputs + 6;

void AppendField(std::string& row, const std::optional<double>& value) {
  row += ',';
  if (value) AppendNumber(row, *value);
}

std::string Row(const std::string& inputs, const StabilityRun& run) {
  std::string row = inputs + ',' + ToString(run.outcome) + ',' + std::to_string(run.steps);
  AppendField(row, run.seconds);
  AppendField(row, run.residual);
  AppendField(row, run.speed);
  AppendField(row, run.distance);
  return row + '\n';
}

std::string Header(const std::string& shared) {
  return "# " + shared + '\n' + kStabilityInputColumns + kResultColumns + '\n';
}

std::vector<std::string> Fields(const std::string& row) {
  std::vector<std::string> fields(1);
  for (const char c : row) {
    if (c == ',')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

double Number(const std::string& text, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(where, "found '" + text + "', expected a number");
  return value;
}
std::optional<double> Optional(const std::string& text, const std::string& where) {
  return text.empty() ? std::nullopt : std::optional(Number(text, where));
}

void AddRow(const std::string& row, const std::string& where, StabilityRuns& runs) {
  const std::vector<std::string> f = Fields(row);
  if (static_cast<int>(f.size()) != kColumns)
    throw InputError(
        where, "has " + std::to_string(f.size()) + " fields, expected " + std::to_string(kColumns));
  std::string inputs = f[0];
  for (int i = 1; i < kInputs; ++i) inputs += ',' + f[i];
  runs[inputs] = {.outcome = ParseStabilityOutcome(f[kInputs], where),
                  .steps = static_cast<int>(Number(f[kInputs + 1], where)),
                  .seconds = Number(f[kInputs + 2], where),
                  .residual = Optional(f[kInputs + 3], where),
                  .speed = Optional(f[kInputs + 4], where),
                  .distance = Optional(f[kInputs + 5], where)};
}

std::vector<StabilityCase> Missing(std::span<const StabilityMap> maps, const StabilityRuns& runs) {
  std::vector<StabilityCase> missing;
  std::set<std::string> seen;
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : map.Cases()) {
      const std::string inputs = StabilityInputs(run);
      if (!runs.contains(inputs) && seen.insert(inputs).second) missing.push_back(run);
    }
  return missing;
}

// Where the runs of all threads come together.
class Collector {
 public:
  Collector(const std::string& path, int count, const RunControl& control, StabilityRuns& runs)
      : path_(path), file_(path, std::ios::app), count_(count), control_(control), runs_(runs) {
    if (!file_) throw InputError(path, "cannot be written");
  }

  void Add(const StabilityCase& run, const StabilityRun& result) {
    const std::string inputs = StabilityInputs(run);
    if (!(file_ << Row(inputs, result) << std::flush))
      throw InputError(path_, "cannot be written, is the disk full?");
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
  std::string path_;
  std::ofstream file_;
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
  const std::string text = ReadWholeFile(path), header = Header(shared);
  if (!text.starts_with(header))
    throw InputError(path, "does not begin with '# " + shared + "': made with other settings");
  StabilityRuns runs;
  std::istringstream in(text.substr(header.size()));
  int line = 2;
  for (std::string row; std::getline(in, row);) {
    ++line;
    if (in.eof()) break;  // no end of line: cut off
    AddRow(row, path + ":" + std::to_string(line), runs);
  }
  return runs;
}

void WriteStabilityRuns(const std::string& path, const std::string& shared,
                        const StabilityRuns& runs) {
  std::string text = Header(shared);
  for (const auto& [inputs, run] : runs) text += Row(inputs, run);
  WriteFileAtomically(path, text);
}

bool SurveyStability(StabilityRunner& runner, std::span<const StabilityMap> maps, int threads,
                     const std::string& path, const RunControl& control, StabilityRuns& runs) {
  const std::vector<StabilityCase> missing = Missing(maps, runs);
  Collector collector(path, static_cast<int>(missing.size()), control, runs);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (int i = 0; i < static_cast<int>(missing.size()); ++i)
    RunOne(runner, missing[i], *control.cancel, collector);
  collector.Rethrow();
  return !*control.cancel;
}

}  // namespace drape
