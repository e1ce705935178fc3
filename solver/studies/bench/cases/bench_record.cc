// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_record.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr std::array<const char*, kBenchMeasures> kNames = {
    "vertices",      "repeats", "seconds",          "seconds_spread", "cpu_seconds", "cpu_spread",
    "setup_seconds", "peak_mb", "vertex_mm",        "outline_mm",     "radius_mm",   "dc",
    "dc_error",      "folds",   "derivative_error", "outline_px",     "mse",         "hausdorff_mm",
    "held_out_mse"};

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> parts;
  std::string part;
  for (const char c : line) {
    if (c != ',') {
      part += c;
      continue;
    }
    parts.push_back(part);
    part.clear();
  }
  parts.push_back(part);
  return parts;
}

std::string HeaderLine() {
  std::string line = "work";
  for (const auto& [name, value] : ListAxes(BenchSetting())) line += "," + name;
  line += ",status";
  for (const char* name : kNames) line += std::string(",") + name;
  return line;
}

// "forward material=… law=…", as CheckpointKey has it, of the first fields of a line.
std::string IdentityOfFields(const std::vector<std::string>& fields) {
  std::string identity = fields[0];
  std::size_t at = 1;
  for (const auto& [name, value] : ListAxes(BenchSetting()))
    identity += " " + name + "=" + fields[at++];
  return identity;
}

void AppendLine(const std::string& path, const std::string& line) {
  std::ofstream file(path, std::ios::app);
  file << line << std::endl;
  if (!file) throw InputError(path, "cannot be written");
}

}  // namespace

const char* NameFor(BenchMeasure measure) { return kNames[measure]; }

std::string RecordLine(const BenchRecord& record) {
  std::string line = record.status;
  for (const double value : record.values) {
    line += ',';
    if (std::isfinite(value)) AppendNumber(line, value);
  }
  return line;
}

BenchRecord ParseRecordLine(const std::string& line, const std::string& where) {
  const std::vector<std::string> fields = Split(line);
  if (fields.size() != kBenchMeasures + 1)
    throw InputError(where, "found " + std::to_string(fields.size()) + " fields, expected " +
                                std::to_string(kBenchMeasures + 1));
  BenchRecord record;
  record.status = fields[0];
  for (int m = 0; m < kBenchMeasures; ++m) {
    const std::string& field = fields[m + 1];
    if (field.empty()) continue;
    const char* const end = field.data() + field.size();
    if (std::from_chars(field.data(), end, record.values[m]).ptr != end)
      throw InputError(where, "found '" + field + "' as " + kNames[m] + ", expected a number");
  }
  return record;
}

BenchFile::BenchFile(std::string path, const std::string& common, bool resume)
    : path_(std::move(path)) {
  const std::string content = std::filesystem::exists(path_) ? ReadWholeFile(path_) : "";
  constexpr int kLinesBeforeRuns = 2;
  const bool has_runs = std::count(content.begin(), content.end(), '\n') > kLinesBeforeRuns;
  if (has_runs && !resume)
    throw InputError(path_,
                     "holds the results of earlier runs, expected --resume to continue with "
                     "them or another --out");
  continues_ = resume && !content.empty();
  if (continues_) {
    ReadRuns(content, common);
  } else {
    WriteFileAtomically(path_, "# " + common + "\n" + HeaderLine() + "\n");
  }
}

void BenchFile::ReadRuns(const std::string& content, const std::string& common) {
  std::istringstream lines(content);
  std::string line;
  std::getline(lines, line);
  if (line != "# " + common)
    throw InputError(path_ + ":1", "found '" + line + "', expected '# " + common +
                                       "': the options are not those that the run began with");
  std::getline(lines, line);
  if (line != HeaderLine()) throw InputError(path_ + ":2", "expected '" + HeaderLine() + "'");
  const std::size_t first = 1 + ListAxes(BenchSetting()).size();
  for (int number = 3; std::getline(lines, line); ++number) {
    const std::string where = path_ + ":" + std::to_string(number);
    std::vector<std::string> fields = Split(line);
    if (fields.size() != first + 1 + kBenchMeasures)
      throw InputError(where, "found " + std::to_string(fields.size()) + " fields, expected " +
                                  std::to_string(first + 1 + kBenchMeasures));
    std::string rest = fields[first];
    for (std::size_t i = first + 1; i < fields.size(); ++i) rest += "," + fields[i];
    runs_[IdentityOfFields(fields)] = ParseRecordLine(rest, where);
  }
}

const BenchRecord* BenchFile::Find(const std::string& identity) const {
  const auto it = runs_.find(identity);
  return it == runs_.end() ? nullptr : &it->second;
}

void BenchFile::Add(BenchWork work, const BenchSetting& setting, const BenchRecord& record) {
  std::string line = ToString(work);
  for (const auto& [name, value] : ListAxes(setting)) line += "," + value;
  AppendLine(path_, line + "," + RecordLine(record));
  runs_[CheckpointKey(work, setting)] = record;
}

}  // namespace drape
