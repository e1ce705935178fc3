// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/study_part.h"

#include <algorithm>
#include <filesystem>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"
#include "tools/programs/results/report/parts/provenance_part.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRows = 200;  // of a table

// "heat_map.chart.json" → "heat_map.png", which is the same chart.
std::string PictureName(const std::string& chart_file) {
  return chart_file.substr(0, chart_file.find(".chart.json")) + ".png";
}

std::string Chart(const ResultFolder& folder, const std::string& file, ReportPage* page) {
  try {
    const nlohmann::json picture = ReadJsonFile(folder.File(file));
    if (picture.value("format", "") != "drapefit-chart" || !picture.contains("charts"))
      throw InputError(file, "is not a chart of drapefit");
    const std::string title = picture.value("title", "");
    return (title.empty() ? "" : HtmlElement("h3", title)) +
           page->AddPicture(picture, PictureName(file));
  } catch (const std::exception& error) {
    return HtmlElement("p", error.what(), "missing");
  }
}

std::string Charts(const ResultFolder& folder, ReportPage* page) {
  std::string html;
  for (const std::string& file : folder.Files(".chart.json")) html += Chart(folder, file, page);
  return html;
}

// Those of fits are shown with their images, that of a photograph with its measurement.
std::string Pictures(const ResultFolder& folder, ReportPage* page) {
  std::string html;
  for (const std::string& file : folder.Files(".png")) {
    const fs::path path = folder.File(file);
    const bool has_chart = fs::exists(fs::path(path).replace_extension(".chart.json"));
    if (has_chart || (folder.IsFit() && file.starts_with("fit_")) || file == "mean_image.png" ||
        (folder.program == "drape_photo" && file == "overlay.png"))
      continue;
    html += page->AddImage(path, file, file);
  }
  return html;
}

std::string Tables(const ResultFolder& folder, ReportPage* page) {
  std::string html;
  for (const std::string& file : folder.Files(".md"))
    html += page->IfItFits(folder.name + "/" + file,
                           HtmlFromMarkdown(ReadWholeFile(folder.File(file))));
  for (const std::string& file : folder.Files(".csv")) try {
      html += page->IfItFits(
          folder.name + "/" + file,
          HtmlDetails("Table " + file,
                      HtmlFromCsv(file, ReadWholeFile(folder.File(file)), kMostRows)));
    } catch (const InputError& error) {
      html += HtmlElement("p", error.what(), "missing");
    }
  return html;
}

// Lists of results that are in the summary alone.
std::string Lists(const ResultFolder& folder, ReportPage* page) {
  struct List {
    const char *program, *key;
    std::vector<std::string> columns;
  };
  const List lists[] = {
      {"drape_validate",
       "cases",
       {"group", "name", "reference", "computed", "error", "tolerance", "order", "pass"}},
      {"drape_garment", "runs", {}}};
  std::string html;
  for (const List& known : lists)
    if (const nlohmann::json& list = FindList(folder.summary, std::string("/") + known.key);
        folder.program == known.program && !list.empty())
      html += page->IfItFits(folder.name + ": " + known.key,
                             HtmlFromObjects("", list, kMostRows, known.columns));
  return html;
}

std::string Flat(const nlohmann::json& object) { return HtmlTable("", {}, FlatRows(object)); }

std::string Provenance(const ResultFolder& folder) {
  const nlohmann::json& s = folder.summary;
  nlohmann::json plain = {{"program", folder.program}, {"folder", folder.path}};
  for (const auto& [key, value] : s.items())
    if (!value.is_structured() && !value.is_null()) plain[key] = value;
  std::string html = ProvenanceHtml(folder);
  html += HtmlDetails("Settings and results of the run", Flat(plain));
  for (const char* key : {"seconds", "meshes", "simpler_models", "initial_guess"})
    if (const nlohmann::json* found = Find(s, std::string("/") + key);
        found != nullptr && found->is_structured())
      html += HtmlDetails(key, Flat(*found));
  return html;
}

}  // namespace

void AddStudies(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("studies", "Charts and tables", SideBySide(folders, [&](const auto& folder) {
                     return Charts(folder, page) + Pictures(folder, page) + Lists(folder, page) +
                            Tables(folder, page);
                   }));
}

void AddProvenance(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("provenance", "Where these results are from", SideBySide(folders, Provenance));
}

}  // namespace drape
