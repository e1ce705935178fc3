// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/provenance_part.h"

#include <algorithm>
#include <cctype>
#include <cstring>

#include "tools/programs/results/report/parts/html_text.h"

namespace drape {
namespace {

using nlohmann::json;

bool IsPlain(unsigned char c) { return std::isalnum(c) != 0 || std::strchr("-_=+,./:@%", c); }

std::string CommandText(const json& command) {
  if (!command.is_array()) return ValueText(command);
  std::vector<std::string> words;
  for (const json& word : command)
    words.push_back(word.is_string() ? word.get<std::string>() : word.dump());
  return ShellLine(words);
}

void AddRow(const std::string& name, const std::string& text, std::vector<CellRow>* rows) {
  if (!text.empty()) rows->push_back({{name, Cell::Kind::kHeader}, {text}});
}

// "name value, name value" of those members that are there.
std::string Joined(const json& object,
                   const std::vector<std::pair<const char*, const char*>>& keys) {
  std::string text;
  for (const auto& [key, name] : keys)
    if (const json* value = Find(object, std::string("/") + key); value != nullptr)
      text += (text.empty() ? "" : ", ") + std::string(name) + ValueText(*value);
  return text;
}

std::string Seeds(const json& options) {
  std::string text;
  if (!options.is_object()) return text;
  for (const auto& [key, value] : options.items())
    if (key == "seed" || key.ends_with("_seed") || key.ends_with("seeds"))
      text += (text.empty() ? "" : ", ") + key + " " + ValueText(value);
  return text;
}

std::string RunTable(const ResultFolder& folder, const json& run) {
  std::vector<CellRow> rows;
  if (const json* command = Find(run, "/command")) AddRow("command", CommandText(*command), &rows);
  for (const json& earlier : FindList(run, "/continues"))
    if (const json* command = Find(earlier, "/command"))
      AddRow("continues", CommandText(*command), &rows);
  if (Find(run, "/options") != nullptr)
    AddRow("repeated by",
           ShellLine({folder.program, "--config=" + folder.File(folder.file), "--out=NEW"}), &rows);
  AddRow("in the folder", FindText(run, "/working_directory"), &rows);
  AddRow("started", FindText(run, "/started"), &rows);
  if (const json* seconds = Find(run, "/seconds")) AddRow("took [s]", ValueText(*seconds), &rows);
  AddRow("machine",
         Joined(run, {{"host", ""},
                      {"processor", ""},
                      {"cores", "cores "},
                      {"threads", "threads "},
                      {"gpu", ""}}),
         &rows);
  if (const json* build = Find(run, "/build"))
    AddRow("build",
           Joined(*build, {{"drapefit", "drapefit "},
                           {"commit", "commit "},
                           {"compiler", "compiler "},
                           {"build_type", ""},
                           {"instructions", ""},
                           {"ceres", "Ceres "},
                           {"cholmod", "CHOLMOD "},
                           {"eigen", "Eigen "},
                           {"glibc", "glibc "}}),
           &rows);
  if (const json* options = Find(run, "/options")) AddRow("seeds", Seeds(*options), &rows);
  return HtmlTable("", {}, rows);
}

std::string FilesTable(const json& run) {
  std::vector<CellRow> rows;
  for (const char* kind : {"inputs", "configs"})
    for (const json& file : FindList(run, std::string("/") + kind)) {
      const json* bytes = Find(file, "/bytes");
      rows.push_back({{FindText(file, "/path")},
                      NumberCell(bytes != nullptr ? bytes->dump() : ""),
                      {FindText(file, "/sha256")}});
    }
  if (rows.empty()) return "";
  return HtmlDetails("Files that the run read (" + std::to_string(rows.size()) + ")",
                     HtmlTable("", {"file", "bytes", "SHA-256"}, rows));
}

}  // namespace

std::string ProvenanceHtml(const ResultFolder& folder) {
  const json* run = Find(folder.summary, "/provenance");
  if (run == nullptr) return "";
  std::string html = RunTable(folder, *run) + FilesTable(*run);
  if (const json* options = Find(*run, "/options"))
    html += HtmlDetails("All options of the run", HtmlTable("", {}, FlatRows(*options)));
  return html;
}

std::string ShellLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && std::all_of(word.begin(), word.end(), IsPlain)) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace drape
