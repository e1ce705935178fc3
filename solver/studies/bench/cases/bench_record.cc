// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_record.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr std::array<const char*, kBenchMeasures> kNames = {
    "vertices",    "repeats",      "seconds",          "seconds_spread",
    "cpu_seconds", "cpu_spread",   "setup_seconds",    "peak_mb",
    "vertex_mm",   "outline_mm",   "radius_mm",        "dc",
    "dc_error",    "folds",        "derivative_error", "outline_px",
    "mse",         "hausdorff_mm", "held_out_mse",     "force_residual",
    "drift_mm"};

CsvRow ColumnNames() {
  CsvRow names = {"work"};
  for (const auto& [name, value] : ListAxes(BenchSetting())) names.push_back(name);
  names.push_back("status");
  names.insert(names.end(), kNames.begin(), kNames.end());
  return names;
}

// Work and axes of a run.
CsvRow IdentityFields(BenchWork work, const BenchSetting& setting) {
  CsvRow fields = {ToString(work)};
  for (const auto& [name, value] : ListAxes(setting)) fields.push_back(value);
  return fields;
}

// "forward material=… law=…", as CheckpointKey has it, of the first fields of a row.
std::string IdentityOfFields(const CsvRow& fields) {
  std::string identity = fields[0];
  std::size_t at = 1;
  for (const auto& [name, value] : ListAxes(BenchSetting()))
    identity += " " + name + "=" + fields[at++];
  return identity;
}

CsvRow RecordFields(const BenchRecord& record) {
  CsvRow fields = {record.status};
  for (const double value : record.values) {
    fields.emplace_back();
    if (std::isfinite(value)) AppendNumber(fields.back(), value);
  }
  return fields;
}

// fields: status and numbers.
BenchRecord ParseRecord(const CsvRow& fields, const std::string& where) {
  if (fields.size() != kBenchMeasures + 1)
    throw InputError(where, "found " + std::to_string(fields.size()) + " fields, expected " +
                                std::to_string(kBenchMeasures + 1));
  BenchRecord record;
  record.status = fields[0];
  for (int m = 0; m < kBenchMeasures; ++m) {
    const std::string& field = fields[m + 1];
    if (field.empty()) continue;
    record.values[m] = ParseCsvNumber(field, where + ": " + kNames[m]);
    // A run may take less memory than a process that does nothing.
    if (record.values[m] < 0 && m != kPeakMegabytes && m != kDrapeCoefficient)
      throw InputError(where, "found '" + field + "' as " + kNames[m] +
                                  ", expected a number that is not negative");
  }
  return record;
}

}  // namespace

const char* NameFor(BenchMeasure measure) { return kNames[measure]; }

std::string RecordLine(const BenchRecord& record) { return FormatCsvRow(RecordFields(record)); }

BenchRecord ParseRecordLine(const std::string& line, const std::string& where) {
  return ParseRecord(ParseCsvRow(line, where), where);
}

BenchFile::BenchFile(std::string path, const std::string& common, bool resume)
    : path_(std::move(path)) {
  std::vector<CsvRow> kept;
  if (std::filesystem::exists(path_) && std::filesystem::file_size(path_) > 0) {
    if (!resume) RefuseRuns();
    continues_ = resume;
    if (resume) kept = ReadRuns(common);
  }
  WriteCsvLog(path_, common, ColumnNames(), kept);
}

// A file without runs may be replaced.
void BenchFile::RefuseRuns() const {
  constexpr int kLinesBeforeRuns = 2;
  const std::string content = ReadOwnFile(path_);
  if (std::count(content.begin(), content.end(), '\n') > kLinesBeforeRuns)
    throw InputError(path_,
                     "holds the results of earlier runs, expected --resume to continue with "
                     "them or another --out");
}

std::vector<CsvRow> BenchFile::ReadRuns(const std::string& common) {
  const std::size_t first = IdentityFields(BenchWork::kForward, BenchSetting()).size();
  std::vector<CsvRow> rows;
  for (auto& [where, fields] : ReadCsvLog(path_, common, ColumnNames())) {
    const auto begin = fields.begin() + static_cast<std::ptrdiff_t>(first);
    runs_[IdentityOfFields(fields)] = ParseRecord({begin, fields.end()}, where);
    rows.push_back(std::move(fields));
  }
  return rows;
}

const BenchRecord* BenchFile::Find(const std::string& identity) const {
  const auto it = runs_.find(identity);
  return it == runs_.end() ? nullptr : &it->second;
}

void BenchFile::Add(BenchWork work, const BenchSetting& setting, const BenchRecord& record) {
  CsvRow row = IdentityFields(work, setting);
  const CsvRow fields = RecordFields(record);
  row.insert(row.end(), fields.begin(), fields.end());
  AppendCsvRow(path_, row);
  runs_[CheckpointKey(work, setting)] = record;
}

}  // namespace drape
