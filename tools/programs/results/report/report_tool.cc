// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/report_tool.h"

#include <glog/logging.h>

#include <algorithm>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/built_in_template.h"
#include "tools/programs/results/report/parts/drape_part.h"
#include "tools/programs/results/report/parts/html_text.h"
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

std::string Head(const std::vector<ResultFolder>& folders, const ReportPage& page) {
  std::string html =
      "<header>\n" + HtmlElement("h1", Title(folders)) + "\n<nav aria-label=\"Parts\"><ul>";
  for (const auto& [id, heading] : page.sections)
    html += "<li><a href=\"#" + id + "\">" + EscapeHtml(heading) + "</a></li>";
  return html + "</ul></nav>\n" +
         "<noscript><p class=\"quiet\">Without scripts, charts and the drape in three dimensions "
         "are missing; all tables are here.</p></noscript>\n</header>\n";
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
          "drape_compare_optimisers, drape_speed or drape_garment have written; several "
          "are shown side by side.\n"
          "The page is one file for any browser. It needs no network, its tables are "
          "complete without scripts, and it prints. Nothing is computed again.\n",
      .options =
          {{.key = "out", .value = &options.out, .doc = "file of the page", .is_path = true}},
      .operands = &options.folders,
      .operand_names = "FOLDER..."};
}

std::string MakeReport(const std::vector<ResultFolder>& folders) {
  ReportPage page;
  page.body = "<main>\n";
  AddVerdicts(folders, &page);
  AddImages(folders, &page);
  AddMaterials(folders, &page);
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
                                {"%%BODY%%", Head(folders, page) + page.body},
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
  WriteFileAtomically(options.out, MakeReport(folders));
  return "see " + options.out + "\n";
}

}  // namespace drape
