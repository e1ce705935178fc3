// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/serve/desk_commands.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/program_folder.h"
#include "tools/inputs/samples.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool IsPoints(const std::string& field) {
  return field == "cloth_points" || field == "ground_points";
}

// The options of drape_photo that a photograph's fields give.
std::vector<std::string> PhotoWords(const json& fields) {
  std::vector<std::string> words;
  for (const char* field : kFieldColumns) {
    const std::string value = fields.value(field, "");
    const std::string key = field == std::string("diameter") ? "specimen" : field;
    if (IsOfMeasurement(field) && !value.empty()) words.push_back("--" + key + "=" + value);
  }
  return words;
}

std::vector<DeskCommand> GarmentCommands(const std::string& folder, const std::string& fabric,
                                         const std::string& threads) {
  const std::string result = folder + "/result",
                    configs = FindConfigs(ProgramFolder(), "the garment");
  DeskCommand dress{"garment",
                    {"--garment=" + configs + "/garments/circle_skirt.json",
                     "--body=mannequin:walk", "--fabric=" + fabric, "--preview", "--edge=0.05",
                     "--seconds=1.5", threads, "--out=" + result}};
  if (fs::exists(result + "/checkpoint.json")) dress.arguments.push_back("--resume");
  return {dress, {"report", {result, "--out=" + folder + "/report.html"}}};
}

}  // namespace

std::vector<std::string> DeskCommand::Words() const {
  const std::string folder = ProgramFolder();
  std::vector<std::string> words = {verb.empty() ? folder + "/drapefit"
                                                 : ProgramPath(folder, verb)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

std::string DeskCommand::Text() const {
  std::vector<std::string> words = {"drapefit"};
  if (!verb.empty()) words.push_back(verb);
  words.insert(words.end(), arguments.begin(), arguments.end());
  return ShellLine(words);
}

bool IsOfMeasurement(const std::string& field) {
  static const std::set<std::string> fields = {
      "warp", "diameter", "support", "focal_35mm", "threshold", "cloth_points", "ground_points"};
  return fields.contains(field);
}

void CheckFields(const json& fields) {
  if (!fields.is_object()) throw InputError("fields", "expected an object of texts");
  for (const auto& [name, value] : fields.items()) {
    if (std::ranges::count(kFieldColumns, name) == 0)
      throw InputError("field '" + PlainText(name) + "'", "is unknown");
    if (!value.is_string()) throw InputError("field '" + name + "'", "expected a text");
    const std::string text = value;
    const std::size_t most = IsPoints(name) ? 2000 : 60;
    const char* refused = name == "fabric" ? "#?*[],;\"/\\|" : "";  // it names folders
    if (text.size() > most || MakePrintable(text) != text ||
        text.find_first_of(std::string(refused) + "\n\t") != text.npos ||
        std::string("=+-@. ").find(text[0]) != std::string::npos ||
        (IsPoints(name) && text.find_first_not_of("0123456789,") != text.npos))
      throw InputError("field '" + name + "'",
                       "found '" + PlainText(text) +
                           (IsPoints(name) ? "', expected columns and rows of points"
                                           : "', expected a plain text of at most 60 bytes"));
  }
}

std::string PlainText(const std::string& text) {
  constexpr std::size_t kMost = 100;
  std::string plain = MakePrintableLine(text.substr(0, kMost));
  while (plain.size() > kMost || !IsUtf8(plain)) plain.pop_back();
  return plain;
}

std::vector<DeskCommand> ListCommands(const std::string& id, const json& record,
                                      const DeskOptions& options) {
  const std::string folder = options.out + "/" + id, kind = record.at("kind");
  const std::string threads = Format("--threads=%d", options.threads);
  if (kind == "picture") {
    DeskCommand photo{"photo", {folder + "/" + record.at("file").get<std::string>()}};
    for (const std::string& word : PhotoWords(record.at("fields"))) photo.arguments.push_back(word);
    photo.arguments.push_back("--out=" + folder + "/photo");
    return {photo};
  }
  if (kind == "fit") {
    DeskCommand fit{"", {folder + "/samples.csv", threads, "--out=" + folder + "/result"}};
    if (!options.fit_config.empty()) fit.arguments.push_back("--fit_config=" + options.fit_config);
    return {fit};
  }
  const std::string fabric = options.out + "/" + record.at("of").get<std::string>() + "/result/" +
                             record.at("fit").get<std::string>();
  if (kind == "garment") return GarmentCommands(folder, fabric, threads);
  return {{"export", {"--fabric=" + fabric, "--to=all", threads, "--out=" + folder + "/result"}}};
}

std::string SamplesText(const std::vector<std::pair<std::string, json>>& pictures) {
  std::vector<std::string> columns;
  for (const char* field : kFieldColumns)
    if (std::ranges::any_of(pictures, [&](const auto& picture) {
          return !picture.second.at("fields").value(field, "").empty();
        }))
      columns.push_back(field);
  std::string text = "file,photograph";
  for (const std::string& column : columns) text.append(",").append(column);
  for (const auto& [id, record] : pictures) {
    text += "\n" + id + fs::path(record.at("file").get<std::string>()).extension().string() + ",";
    text += CsvField(record.at("name"));
    for (const std::string& column : columns)
      text.append(",").append(CsvField(record.at("fields").value(column, "")));
  }
  return text + "\n";
}

json ReadResult(const std::string& folder, const json& record) try {
  if (record.at("kind") == "picture") {
    const json summary = json::parse(ReadOwnFile(folder + "/photo/summary.json"));
    json result;
    for (const char* key : {"dc", "dc_sd", "folds", "bending_length", "specimen_in_overlay_px",
                            "warnings", "tilt_rad"})
      result[key] = summary.at(key);
    return result;
  }
  json result = {{"files", ListFiles(folder)}, {"fits", json::array()}};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder + "/result")) {
    const std::string name = entry.path().filename();
    if (name.starts_with("fit") && fs::exists(entry.path() / "material.json"))
      result["fits"].push_back(name);
  }
  for (const char* page : {"report.html", "result/report.html"})
    if (fs::exists(folder + "/" + page)) result["page"] = page;
  return result;
} catch (const std::exception&) {  // nothing there
  return json::object();
}

json ReadOutlines(const std::string& folder) try {
  for (const std::string& name : ListFiles(folder))
    if (name.ends_with("/outlines.json")) return json::parse(ReadOwnFile(folder + "/" + name));
  return nullptr;
} catch (const std::exception&) {  // the fit has just ended
  return nullptr;
}

std::vector<std::string> ListFiles(const std::string& folder) {
  constexpr int kMostLevels = 2;
  std::vector<std::string> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename();
    if (name.starts_with('.') || entry.depth() >= kMostLevels) entry.disable_recursion_pending();
    if (!name.starts_with('.') && fs::is_regular_file(entry->symlink_status()))
      files.push_back(entry->path().lexically_relative(folder));
  }
  std::ranges::sort(files);
  return files;
}

std::string ReadTail(const std::string& path, long bytes) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const long size = file ? long(file.tellg()) : 0;
  file.seekg(std::max(0L, size - bytes));
  std::string text(std::size_t(std::min(size, bytes)), '\0');
  file.read(text.data(), std::streamsize(text.size()));
  if (size > bytes) text.erase(0, text.find('\n') + 1);
  return MakePrintable(text);
}

}  // namespace drape
