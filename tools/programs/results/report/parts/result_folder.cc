// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/result_folder.h"

#include <algorithm>
#include <filesystem>

#include "losses/image/image.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// By which file and which key of it the results of a program are known.
struct ProgramMark {
  const char *program, *file, *key;
};
constexpr ProgramMark kMarks[] = {
    {"drape_compare", "comparison.json", "tables"},
    {"drape_bench", "bench.json", ""},
    {"drape_stability", "stability.json", ""},
    {"drape_space", "space.json", ""},
    {"drape_speed", "speed.json", "rows"},
    {"drape_fit", "summary.json", "start_material"},
    {"drape_garment", "summary.json", "garment"},
    {"drape_predict", "summary.json", "draws_wanted"},
    {"drape_equilibria", "summary.json", "samples_wanted"},
    {"drape_simulate", "summary.json", "steps_wanted"},
    {"drape_gradients", "summary.json", "horizons"},
    {"drape_compare_optimisers", "summary.json", "budget_rollouts"},
    {"drape_photo", "summary.json", "photo"},
    {"drape_export", "summary.json", "targets"},
    {"drape_validate", "summary.json", "cases"},
};

// Keys of the files of drape_metrics: of one drape, several, a comparison, of two runs, of two
// distributions, of fits of known fabrics, and of a data set.
constexpr const char* kMetricsKeys[] = {"shape",
                                        "drapes",
                                        "aligned",
                                        "pairs",
                                        "outline_energy_score_m",
                                        "ratios",
                                        "trivial_predictors"};

std::string ListPrograms() {
  std::string list;
  for (const ProgramMark& mark : kMarks)
    list += (list.empty() ? "" : ", ") + std::string(mark.program);
  return list;
}

std::string NoRoom(const std::string& what) {
  return HtmlElement("p", what + " has no room on this page", "missing") + "\n";
}

// A large picture, such as a photograph, as a thumbnail: else it would leave no room.
std::string BytesForPage(const std::string& file) {
  constexpr std::size_t kLarge = 200000;  // bytes
  constexpr int kSide = 1000;             // [px]
  std::string bytes = ReadWholeFile(file);
  if (bytes.size() < kLarge) return bytes;
  try {
    return MakeThumbnail(ReadPhotograph(file).image, kSide);
  } catch (const InputError&) {  // of a kind that browsers alone read
    return bytes;
  }
}

// "draw_2.obj" before "draw_10.obj": runs of digits by their length first.
bool ComesBefore(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (is_digit(a[i]) && is_digit(b[i])) {
      std::size_t end_a = i, end_b = i;
      while (end_a < a.size() && is_digit(a[end_a])) ++end_a;
      while (end_b < b.size() && is_digit(b[end_b])) ++end_b;
      if (end_a != end_b) return end_a < end_b;
    }
    if (a[i] != b[i]) return a[i] < b[i];
  }
  return a.size() < b.size();
}

ResultFolder ReadMetricsFile(const std::string& path) {
  constexpr const char* kExpected = "expected a folder of results or a JSON file of drape_metrics";
  if (!path.ends_with(".json"))
    throw InputError(path, std::string("is not a folder, ") + kExpected);
  ResultFolder file{.path = path,
                    .name = fs::path(path).filename().string(),
                    .program = "drape_metrics",
                    .file = {},
                    .summary = ReadJsonFile(path)};
  if (std::none_of(std::begin(kMetricsKeys), std::end(kMetricsKeys),
                   [&](const char* key) { return file.summary.contains(key); }))
    throw InputError(path, std::string("has no results of drape_metrics, ") + kExpected);
  return file;
}

}  // namespace

std::optional<DrapeDiscs> ResultFolder::Discs() const {
  const auto specimen = FindNumber(summary, "/specimen_diameter_m"),
             support = FindNumber(summary, "/support_diameter_m");
  if (!specimen || !support) return std::nullopt;
  return DrapeDiscs{*specimen / 2, *support / 2};
}

std::vector<std::string> ResultFolder::Files(const std::string& end) const {
  std::vector<std::string> names;
  if (!fs::is_directory(path)) return names;
  for (const auto& entry : fs::directory_iterator(path)) {
    const std::string file = entry.path().filename().string();
    if (file.ends_with(end) && !file.starts_with(".") && entry.is_regular_file())
      names.push_back(file);
  }
  std::sort(names.begin(), names.end(), ComesBefore);
  return names;
}

ResultFolder ReadResultFolder(const std::string& path) {
  if (fs::is_regular_file(path)) return ReadMetricsFile(path);
  if (!fs::is_directory(path)) throw InputError(path, "no such folder");
  const fs::path whole = fs::weakly_canonical(path);
  ResultFolder folder{
      .path = path, .name = whole.filename().string(), .program = {}, .file = {}, .summary = {}};
  for (const ProgramMark& mark : kMarks) {
    if (!fs::is_regular_file(folder.File(mark.file))) continue;
    folder.summary = ReadJsonFile(folder.File(mark.file));
    if (!folder.summary.is_object() || (*mark.key != '\0' && !folder.summary.contains(mark.key)))
      continue;
    folder.program = mark.program;
    folder.file = mark.file;
    return folder;
  }
  throw InputError(path, "has no results, expected the output folder of one of " + ListPrograms());
}

std::optional<ResultFolder> FindPhotograph(const nlohmann::json& image) {
  const fs::path file = FindText(image, "/file");
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  if (file.empty() || !fs::is_regular_file(folder + "/summary.json")) return {};
  try {
    ResultFolder photograph = ReadResultFolder(folder);
    const std::string name = file.filename().string();
    if (photograph.program == "drape_photo" &&
        (name == FindText(photograph.summary, "/silhouette") ||
         name == FindText(photograph.summary, "/projected")))
      return photograph;
  } catch (const InputError&) {  // of another program, or damaged
  }
  return {};
}

const nlohmann::json* Find(const nlohmann::json& json, const std::string& pointer) {
  const nlohmann::json::json_pointer where(pointer);
  if (!json.contains(where) || json.at(where).is_null()) return nullptr;
  return &json.at(where);
}

std::optional<double> FindNumber(const nlohmann::json& json, const std::string& pointer) {
  const nlohmann::json* found = Find(json, pointer);
  if (found == nullptr || !found->is_number()) return {};
  return found->get<double>();
}

std::string FindText(const nlohmann::json& json, const std::string& pointer) {
  const nlohmann::json* found = Find(json, pointer);
  return found != nullptr && found->is_string() ? found->get<std::string>() : "";
}

std::vector<std::string> FindTexts(const nlohmann::json& json, const std::string& pointer) {
  std::vector<std::string> texts;
  for (const nlohmann::json& item : FindList(json, pointer))
    if (item.is_string()) texts.push_back(item.get<std::string>());
  return texts;
}

const nlohmann::json& FindList(const nlohmann::json& json, const std::string& pointer) {
  static const nlohmann::json kNone = nlohmann::json::array();
  const nlohmann::json* found = Find(json, pointer);
  return found != nullptr && found->is_array() ? *found : kNone;
}

std::string NumberText(const nlohmann::json& json, const std::string& pointer, double factor,
                       const char* format) {
  const std::optional<double> value = FindNumber(json, pointer);
  return value ? Format(format, factor * *value) : "none";
}

std::string CoefficientText(const nlohmann::json& photograph) {
  const std::string text = NumberText(photograph, "/dc", 100, "%.1f");
  return FindNumber(photograph, "/dc_sd") ? text + NumberText(photograph, "/dc_sd", 100, " ± %.1f")
                                          : text;
}

void ReportPage::AddSection(const std::string& id, const std::string& heading,
                            const std::string& content) {
  if (content.empty()) return;
  sections.emplace_back(id, heading);
  body += "<section id=\"" + id + "\">\n" + HtmlElement("h2", heading) + "\n" + content +
          "</section>\n";
}

bool ReportPage::TakeRoom(std::size_t bytes, const std::string& what) {
  const bool fits = bytes <= room;
  if (fits)
    room -= bytes;
  else
    left_out.push_back(what);
  return fits;
}

std::string ReportPage::IfItFits(const std::string& what, std::string markup) {
  return TakeRoom(markup.size(), what) ? markup : NoRoom(what);
}

std::string ReportPage::AddImage(const std::string& file, const std::string& alt,
                                 const std::string& caption) {
  return IfItFits(file, "<figure class=\"picture\"><img alt=\"" + EscapeHtml(alt) + "\" src=\"" +
                            ImageUri(BytesForPage(file)) + "\">" +
                            (caption.empty() ? "" : HtmlElement("figcaption", caption)) +
                            "</figure>\n");
}

std::string ReportPage::AddPicture(const nlohmann::ordered_json& picture,
                                   const std::string& caption) {
  if (!TakeRoom(ScriptJson(picture).size(), caption)) return NoRoom(caption);
  pictures.push_back(picture);
  return "<figure data-picture=\"" + std::to_string(pictures.size() - 1) + "\">" +
         (caption.empty() ? "" : HtmlElement("figcaption", caption)) + "</figure>\n";
}

std::string SideBySide(const std::vector<ResultFolder>& folders,
                       const std::function<std::string(const ResultFolder&)>& part) {
  std::string html;
  int count = 0;
  for (const ResultFolder& folder : folders) {
    const std::string content = part(folder);
    if (content.empty()) continue;
    ++count;
    html += "<div>\n" + (folders.size() > 1 ? HtmlElement("h3", folder.name) : "") + content +
            "</div>\n";
  }
  if (count == 0) return "";
  return count == 1 ? html : "<div class=\"side\">\n" + html + "</div>\n";
}

}  // namespace drape
