// SPDX-License-Identifier: Apache-2.0
#include "physics/material/bending_table.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <sstream>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/stored/csv_log.h"

namespace drape {
namespace {

constexpr char kDensity[] = "density[kg.m-2]";
// Names of columns of the CSV file by row of the bend table.
constexpr const char* kLinear[kBendRows] = {"linear warp[SI*1e9]", "linear diag[SI*1e9]",
                                            "linear weft[SI*1e9]"};
constexpr const char* kNonlinear[kBendRows] = {"nonlinear warp[SI*1e12]", "nonlinear diag[SI*1e12]",
                                               "nonlinear weft[SI*1e12]"};
constexpr double kLinearUnit = 1e-9;      // [N·m]
constexpr double kNonlinearUnit = 1e-12;  // [N·m²]
constexpr double kCurvatureStep = 10.0;   // between columns [1/m]

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

CsvRow ReadFields(const std::string& line, const std::string& where) {
  CsvRow fields = ParseCsvRow(line, where);
  for (std::string& field : fields) field = Trimmed(field);
  return fields;
}

// The lines that are not blank, with their numbers in the file.
std::vector<std::pair<int, std::string>> ReadLines(const std::string& path) {
  std::istringstream text(ReadWholeFile(path));
  std::vector<std::pair<int, std::string>> lines;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (!Trimmed(line).empty()) lines.emplace_back(number, Trimmed(line));
  }
  return lines;
}

std::size_t FindColumn(const CsvRow& names, const std::string& name, const std::string& path) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string list;
  for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
  throw InputError(path + ":1", "column '" + name + "' is missing, found: " + list);
}

void RequireColumns(const CsvRow& names, const std::string& path) {
  FindColumn(names, kDensity, path);
  for (const auto& columns : {kLinear, kNonlinear})
    for (int r = 0; r < kBendRows; ++r) FindColumn(names, columns[r], path);
}

int ParseRow(const BendingRow& row, int count) {
  int number = 0;
  const char* const end = row.row.data() + row.row.size();
  const auto [parsed, error] = std::from_chars(row.row.data(), end, number);
  if (error != std::errc() || parsed != end || number < 1 || number > count)
    throw InputError(row.table, "has no row '" + row.row + "', expected " +
                                    (count > 0 ? "1 to " + std::to_string(count)
                                               : std::string("rows below the column names")));
  return number;
}

}  // namespace

std::optional<BendingRow> SplitBendingRow(const std::string& path) {
  constexpr char kEnd[] = ".csv#";
  const std::size_t at = path.find(kEnd);
  std::error_code ignored;
  if (at == std::string::npos || std::filesystem::exists(path, ignored)) return std::nullopt;
  const std::size_t hash = at + sizeof kEnd - 2;
  const std::size_t colon = std::min(path.find(':', hash), path.size());
  const std::string row = path.substr(hash + 1, colon - hash - 1);
  if (row.find('/') != std::string::npos) return std::nullopt;  // of a folder
  return BendingRow{path.substr(0, hash), row,
                    colon < path.size() ? path.substr(colon + 1) : std::string()};
}

BendingMeasurement ReadBendingRow(const BendingRow& row) {
  const auto lines = ReadLines(row.table);
  if (lines.empty()) throw InputError(row.table, "is empty, expected a line of column names");
  const CsvRow names = ReadFields(lines[0].second, row.table + ":1");
  RequireColumns(names, row.table);
  const int number = ParseRow(row, static_cast<int>(lines.size()) - 1);
  const auto& [line, text] = lines[static_cast<std::size_t>(number)];
  const std::string where = row.table + ":" + std::to_string(line);
  const auto read = [&](const std::string& column, const CsvRow& fields) {
    return ParseCsvNumber(fields[FindColumn(names, column, row.table)],
                          where + ": column '" + column + "'");
  };
  const CsvRow fields = ReadFields(text, where);
  if (fields.size() != names.size())
    throw InputError(where, "found " + std::to_string(fields.size()) + " fields, expected " +
                                std::to_string(names.size()));
  BendingMeasurement measured;
  measured.density = read(kDensity, fields);
  for (int r = 0; r < kBendRows; ++r) {
    const double linear = kLinearUnit * read(kLinear[r], fields);
    const double nonlinear = kNonlinearUnit * read(kNonlinear[r], fields);
    for (int k = 0; k < kBendCols; ++k)
      measured.bend.b[r][k] = kBendPerRigidity * (linear + kCurvatureStep * k * nonlinear);
  }
  return measured;
}

}  // namespace drape
