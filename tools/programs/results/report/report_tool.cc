// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/report_tool.h"

#include <glog/logging.h>

#include <algorithm>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/programs/results/report/built_in_template.h"
#include "tools/programs/results/report/parts/drape_part.h"
#include "tools/programs/results/report/parts/html_text.h"
#include "tools/programs/results/report/parts/measure_part.h"
#include "tools/programs/results/report/parts/outline_part.h"
#include "tools/programs/results/report/parts/posterior_part.h"
#include "tools/programs/results/report/parts/study_part.h"
#include "tools/programs/results/report/parts/verdict_part.h"

namespace drape {
namespace {

std::string Title(const std::vector<ResultFolder>& folders) {
  std::string title = "drapefit report: ";
  for (std::size_t i = 0; i < folders.size(); ++i) title += (i == 0 ? "" : ", ") + folders[i].name;
  return title;
}

// What found no room, before anything else.
std::string LeftOut(const ReportPage& page, double max_mb) {
  constexpr std::size_t kMostNames = 12;
  if (page.left_out.empty()) return "";
  std::string names;
  for (std::size_t i = 0; i < std::min(kMostNames, page.left_out.size()); ++i)
    names += (i == 0 ? "" : ", ") + page.left_out[i];
  if (page.left_out.size() > kMostNames)
    names += Format(" and %zu more", page.left_out.size() - kMostNames);
  return HtmlElement("p",
                     Format("Left out, to keep this page below %g MB: ", max_mb) + names +
                         ". A larger --max_mb of drape_report shows them.",
                     "left_out") +
         "\n";
}

std::string Head(const std::vector<ResultFolder>& folders, const ReportPage& page, double max_mb) {
  std::string html =
      "<header>\n" + HtmlElement("h1", Title(folders)) + "\n<nav aria-label=\"Parts\"><ul>";
  for (const auto& [id, heading] : page.sections)
    html += "<li><a href=\"#" + id + "\">" + EscapeHtml(heading) + "</a></li>";
  return html + "</ul></nav>\n" +
         "<noscript><p class=\"quiet\">Without scripts, charts and the drape in three dimensions "
         "are missing; all tables are here.</p></noscript>\n" +
         LeftOut(page, max_mb) + "</header>\n";
}

// The template with its markers replaced, in their order; what is put in is not searched again.
std::string Fill(std::string_view page,
                 const std::vector<std::pair<std::string_view, std::string>>& contents) {
  std::string filled;
  for (const auto& [marker, content] : contents) {
    const std::size_t at = page.find(marker);
    CHECK_NE(at, std::string_view::npos) << marker;
    filled += page.substr(0, at);
    filled += content;
    page.remove_prefix(at + marker.size());
  }
  return filled + std::string(page);
}

// Folders of the same name are shown by their paths.
void NameApart(std::vector<ResultFolder>* folders) {
  for (ResultFolder& folder : *folders)
    if (std::count_if(folders->begin(), folders->end(),
                      [&](const ResultFolder& other) { return other.name == folder.name; }) > 1)
      folder.name = folder.path;
}

}  // namespace

OptionTable ReportTable(ReportOptions& options) {
  return {
      .tool = "drape_report",
      .summary = "makes one page of finished results: verdict, images, material, drapes, charts",
      .example = "drape_report out/fit out/predict --out=out/report.html",
      .notes =
          "FOLDER: what drape_fit, drape_predict, drape_simulate, drape_equilibria, "
          "drape_compare, drape_bench, drape_space, drape_stability, drape_gradients, "
          "drape_compare_optimisers, drape_speed, drape_validate, drape_garment, drape_photo or "
          "drape_export have written, or a JSON file of drape_metrics; several are shown side by "
          "side.\n"
          "The page is one file for any browser. It needs no network, its tables are "
          "complete without scripts, and it prints. Nothing is computed again.\n",
      .options = {{.key = "out", .value = &options.out, .doc = "file of the page", .is_path = true},
                  {.key = "max_mb",
                   .value = &options.max_mb,
                   .doc = "largest size of the page; what would make it larger is named instead",
                   .unit = "MB",
                   .least = 1.2,
                   .most = 1000}},
      .operands = &options.folders,
      .operand_names = "FOLDER..."};
}

std::string MakeReport(const std::vector<ResultFolder>& folders, double max_mb) {
  constexpr std::size_t kTexts = 250000;  // that are not counted, and the marks of the rest
  ReportPage page;
  const auto most = static_cast<std::size_t>(1e6 * max_mb);
  page.room = most - std::min(most, kReportTemplate.size() + kTexts);
  page.body = "<main>\n";
  AddVerdicts(folders, &page);
  AddMeasurements(folders, &page);
  AddImages(folders, &page);
  AddMaterials(folders, &page);
  AddExports(folders, &page);
  AddOutlines(folders, &page);
  AddDrapes(folders, &page);
  AddPosteriors(folders, &page);
  AddPredictions(folders, &page);
  AddSpectra(folders, &page);
  AddStudies(folders, &page);
  AddProvenance(folders, &page);
  page.body += "</main>\n";
  nlohmann::ordered_json data;
  data["pictures"] = std::move(page.pictures);
  data["drapes"] = std::move(page.drapes);
  return Fill(kReportTemplate, {{"%%TITLE%%", EscapeHtml(Title(folders))},
                                {"%%BODY%%", Head(folders, page, max_mb) + page.body},
                                {"%%DATA%%", ScriptJson(data)}});
}

std::string RunReport(const ReportOptions& options, const RunControl& control) {
  if (options.folders.empty())
    throw InputError("FOLDER", "expected at least one folder of results");
  CheckReplaceable(options.out);
  std::vector<ResultFolder> folders;
  for (const std::string& path : options.folders) {
    if (control.cancelled()) return "";
    folders.push_back(ReadResultFolder(path));
  }
  NameApart(&folders);
  const std::string page = MakeReport(folders, options.max_mb);
  WriteFileAtomically(options.out, page);
  return Format("see %s (%.2f MB)\n", options.out.c_str(), 1e-6 * static_cast<double>(page.size()));
}

namespace {

ToolOutcome Run(const ReportOptions& options, const RunControl& control) {
  std::string text = RunReport(options, control);
  return {.text = std::move(text), .cancelled = control.cancelled()};
}

}  // namespace

int ReportMain(int argc, char** argv) { return ToolMain(argc, argv, ReportTable, Run); }

}  // namespace drape
