// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/samples.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "losses/camera/camera.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTable = "samples.csv";
constexpr double kGramsPerKilogram = 1000.0;

struct CsvLine {
  int line = 0;  // of the file, from 1
  std::vector<std::string> fields;
};

// Removes blanks at both ends.
std::string Trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == text.npos ? "" : text.substr(first, last - first + 1);
}

// Splits a text [RFC 4180] and leaves out empty lines.
std::vector<CsvLine> SplitCsv(const std::string& text, char separator, const std::string& where) {
  std::vector<CsvLine> lines;
  CsvLine now{1, {}};
  std::string field;
  int line = 1;
  bool quoted = false;
  const auto end_field = [&] { now.fields.push_back(Trimmed(std::exchange(field, {}))); };
  const auto end_line = [&] {
    end_field();
    if (std::ranges::any_of(now.fields, [](const std::string& each) { return !each.empty(); }))
      lines.push_back(now);
    now = {line, {}};
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    line += c == '\n';
    if (quoted && c == '"' && text.substr(i + 1, 1) == "\"")
      field += text[++i];
    else if (c == '"' && (quoted || Trimmed(field).empty()))
      quoted = !quoted;
    else if (!quoted && c == separator)
      end_field();
    else if (!quoted && c == '\n')
      end_line();
    else
      field += c;
  }
  if (quoted)
    throw InputError(where + ":" + std::to_string(now.line), "a quotation mark is never closed");
  end_line();
  return lines;
}

// The number in a cell, 0 where it is empty.
double ReadCell(std::string text, const std::string& where, const std::string& unit, double least,
                double most) {
  if (text.empty()) return 0.0;
  const std::string found = text;
  if (text.find('.') == text.npos) std::ranges::replace(text, ',', '.');
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value > 0.0))
    throw InputError(where, "found '" + found + "', expected a number above 0 [" + unit + "]");
  CheckUsual(where, value, unit, least, most);
  return value;
}

SampleRow ReadRow(const CsvLine& line, const std::vector<std::string>& columns,
                  const std::string& path) {
  const std::string where = path + ":" + std::to_string(line.line);
  if (line.fields.size() > columns.size())
    throw InputError(where, "found " + std::to_string(line.fields.size()) +
                                " fields, expected at most the " + std::to_string(columns.size()) +
                                " of the first line");
  SampleRow row;
  for (std::size_t k = 0; k < columns.size(); ++k)
    row.cells[columns[k]] = k < line.fields.size() ? line.fields[k] : "";
  const auto place = [&](const char* column) { return where + ": column '" + column + "'"; };
  row.file = row.of("file");
  if (row.file.empty()) throw InputError(place("file"), "is empty, expected a picture");
  row.file = (fs::path(path).parent_path() / row.file).string();
  if (!row.of("error").empty()) return row;
  if (!fs::exists(row.file))
    throw InputError(place("file"), "found '" + row.of("file") +
                                        "', expected a picture: " + row.file + " does not exist");
  const std::string face = row.of("face");
  if (!face.empty() && face != "up" && face != "down")
    throw InputError(place("face"), "found '" + face + "', expected up, down or nothing");
  if (!row.of("warp").empty()) ParseWarp(row.of("warp"), place("warp"));
  row.mass = ReadCell(row.of("mass"), place("mass"), "g/m2", 10, 1500);
  row.diameter = ReadCell(row.of("diameter"), place("diameter"), "m", 0.05, 0.6);
  return row;
}

// Throws InputError for columns of one name and for a table without files.
void CheckColumns(const std::vector<std::string>& columns, const std::string& path) {
  std::set<std::string> names;
  for (const std::string& name : columns)
    if (!names.insert(name).second && !name.empty())
      throw InputError(path + ":1", "the column '" + name + "' is there twice, expected it once");
  if (!names.contains("file"))
    throw InputError(path + ":1",
                     "no column 'file', expected a line of names, such as "
                     "file,fabric,sample,specimen,face,mass");
}

SampleTable ReadTable(const std::string& path) {
  std::string text = ReadWholeFile(path);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // a spreadsheet's mark of UTF-8
  if (!IsUtf8(text)) throw InputError(path, "is no text in UTF-8, expected a table of samples");
  const std::string head = text.substr(0, text.find('\n'));
  const char separator = head.find(';') != head.npos    ? ';'
                         : head.find('\t') != head.npos ? '\t'
                                                        : ',';
  std::vector<CsvLine> lines = SplitCsv(text, separator, path);
  SampleTable table{.path = path, .columns = {}, .rows = {}};
  if (!lines.empty()) table.columns = lines.front().fields;
  CheckColumns(table.columns, path);
  std::map<std::string, int> seen;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    SampleRow row = ReadRow(lines[k], table.columns, path);
    if (!row.of("error").empty()) continue;
    const auto [first, is_new] = seen.emplace(row.file, lines[k].line);
    if (!is_new)
      throw InputError(path + ":" + std::to_string(lines[k].line) + ": column 'file'",
                       "found '" + row.of("file") + "' of line " + std::to_string(first->second) +
                           " again, expected each picture once");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<std::string> PicturesIn(const std::string& folder) {
  try {
    return ExpandImages(folder);
  } catch (const InputError&) {  // none
    return {};
  }
}

SampleTable ReadFolder(const std::string& folder) {
  SampleTable table{.path = folder, .columns = {"file", "fabric"}, .rows = {}};
  std::vector<std::string> folders = {folder};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && !entry.path().filename().string().starts_with('.'))
      folders.push_back(entry.path());
  std::sort(folders.begin() + 1, folders.end());
  for (const std::string& each : folders)
    for (SampleRow& row :
         SamplesOfFiles(PicturesIn(each), fs::weakly_canonical(each).filename()).rows)
      table.rows.push_back(std::move(row));
  return table;
}

// The path and the fabric that is chosen of it.
std::pair<std::string, std::string> SplitFabric(const std::string& path) {
  const std::size_t hash = path.rfind('#');
  if (hash == path.npos || fs::exists(path)) return {path, ""};
  return {path.substr(0, hash), path.substr(hash + 1)};
}

// Names each row by its file, or by folder and file where files of two folders have one name.
void NameRows(std::vector<SampleRow>* rows) {
  std::map<std::string, int> counts;
  for (const SampleRow& row : *rows) ++counts[fs::path(row.file).stem()];
  for (SampleRow& row : *rows) {
    const fs::path file = row.file;
    row.name = file.stem();
    if (counts[row.name] > 1) row.name = file.parent_path().filename().string() + "_" + row.name;
  }
}

}  // namespace

std::vector<std::string> SampleTable::Files() const {
  std::vector<std::string> files;
  for (const SampleRow& row : rows) files.push_back(row.file);
  return files;
}

std::vector<std::string> SampleTable::Fabrics() const {
  std::vector<std::string> fabrics;
  for (const SampleRow& row : rows)
    if (std::ranges::count(fabrics, row.of("fabric")) == 0) fabrics.push_back(row.of("fabric"));
  return fabrics;
}

std::string SampleTable::Common(const std::string& column) const {
  for (const SampleRow& row : rows)
    if (row.of(column) != rows.front().of(column))
      throw InputError(path + ": column '" + column + "'",
                       "found '" + row.of(column) + "' and '" + rows.front().of(column) +
                           "', expected one value for all pictures that are fitted together");
  return rows.empty() ? "" : rows.front().of(column);
}

std::vector<int> SampleTable::SpecimenNumbers() const {
  std::map<std::pair<std::string, std::string>, int> numbers;
  std::vector<int> list;
  for (const SampleRow& row : rows) {
    if (row.of("specimen").empty()) return {};
    const int next = static_cast<int>(numbers.size()) + 1;
    list.push_back(
        numbers.emplace(std::pair(row.of("sample"), row.of("specimen")), next).first->second);
  }
  return list;
}

bool IsSampleTable(const std::string& path) {
  const std::string file = SplitFabric(path).first;
  return (fs::is_regular_file(file) && fs::path(file).extension() == ".csv") ||
         fs::exists(fs::path(file) / kTable);
}

SampleTable SamplesOfFiles(const std::vector<std::string>& files, const std::string& fabric) {
  SampleTable table{.path = {}, .columns = {"file", "fabric"}, .rows = {}};
  for (const std::string& file : files)
    table.rows.push_back({.file = file, .name = {}, .cells = {{"file", file}, {"fabric", fabric}}});
  NameRows(&table.rows);
  return table;
}

SampleTable ReadSamples(const std::string& path) {
  const auto [file, fabric] = SplitFabric(path);
  const bool has_table = fs::exists(fs::path(file) / kTable);
  SampleTable table = has_table                ? ReadTable((fs::path(file) / kTable).string())
                      : fs::is_directory(file) ? ReadFolder(file)
                                               : ReadTable(file);
  if (!fabric.empty())
    std::erase_if(table.rows,
                  [&kept = fabric](const SampleRow& row) { return row.of("fabric") != kept; });
  if (table.rows.empty())
    throw InputError(path,
                     "has no picture, expected at least one" +
                         std::string(fabric.empty() ? "" : " of the fabric '" + fabric + "'"));
  NameRows(&table.rows);
  return table;
}

void AddImages(const std::string& text, FitSpec* spec, FitData* data) {
  if (!IsSampleTable(text)) {
    for (std::string& file : ExpandImages(text)) data->images.push_back(std::move(file));
    return;
  }
  const SampleTable table = ReadSamples(text);
  if (const std::vector<std::string> fabrics = table.Fabrics(); fabrics.size() > 1)
    throw InputError(table.path, "has " + std::to_string(fabrics.size()) +
                                     " fabrics, expected one: " + table.path + "#" + fabrics[0] +
                                     "; drapefit " + table.path + " fits each");
  const bool is_first = data->images.empty();
  for (const std::string& file : table.Files()) data->images.push_back(file);
  if (!is_first) return;
  const SampleRow& row = table.rows.front();
  table.Common("mass");
  table.Common("diameter");
  if (data->density == 0.0) data->density = row.mass / kGramsPerKilogram;
  if (data->specimens.empty() && HasPosterior(spec->model))
    data->specimens = table.SpecimenNumbers();
  if (row.diameter > 0.0 && std::isnan(spec->observation.discs.specimen))
    spec->observation.discs.specimen = row.diameter;
  if (spec->observation.warp == kUnknownWarp && !spec->observation.camera.gives_camera() &&
      !table.Common("warp").empty())
    spec->observation.warp = row.of("warp");
}

std::string CsvField(const std::string& text) {
  std::ostringstream quoted;
  quoted << std::quoted(text, '"', '"');
  return text.find_first_of(",;\"\n\r\t") == text.npos ? text : quoted.str();
}

}  // namespace drape
