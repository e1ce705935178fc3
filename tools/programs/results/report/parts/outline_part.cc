// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/outline_part.h"

#include <cmath>
#include <filesystem>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"
#include "tools/programs/results/tables/outline_list.h"

namespace drape {
namespace {

constexpr std::size_t kMostTiles = 96, kMostBranches = 30;  // of one folder
constexpr int kColours = 7;                                 // style.css has as many

// In mm about the middle of the tile, y down.
std::string MakePath(const Eigen::VectorXd& radius, double middle) {
  std::string path;
  for (Eigen::Index k = 0; k < radius.size(); ++k) {
    const double angle = 2 * M_PI * static_cast<double>(k) / static_cast<double>(radius.size());
    path += Format("%s%.0f %.0f", k == 0 ? "M" : "L", middle + 1e3 * radius[k] * std::cos(angle),
                   middle - 1e3 * radius[k] * std::sin(angle));
  }
  return path + "Z";
}

std::string Tile(const ListedOutline& outline, const DrapeDiscs& discs) {
  constexpr double kEdge = 10;  // [mm]
  const double middle = 1e3 * discs.specimen + kEdge;
  const auto ring = [&](double radius) {
    return Format("<circle cx=\"%.0f\" cy=\"%.0f\" r=\"%.1f\"/>", middle, middle, 1e3 * radius);
  };
  return Format("<li class=\"c%d\">", outline.group % kColours) +
         Format("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"", 2 * middle,
                2 * middle) +
         EscapeHtml("Outline of " + outline.name) + "\"><path d=\"" +
         MakePath(outline.radius, middle) + "\"/>" + ring(discs.support) + ring(discs.specimen) +
         "</svg>" + HtmlElement("span", outline.name) +
         HtmlElement("span",
                     Format("%.1f %%, %d nodes", 100 * outline.drape_coefficient, outline.folds)) +
         "</li>\n";
}

std::string Tiles(const ResultFolder& folder, ReportPage* page) {
  const std::string path = folder.File(kOutlinesFile);
  if (!std::filesystem::is_regular_file(path)) return "";
  std::vector<ListedOutline> outlines;
  try {
    outlines = ReadOutlines(path);
  } catch (const InputError& error) {
    return HtmlElement("p", error.what(), "missing");
  }
  if (outlines.empty()) return "";
  const std::size_t shown = std::min(outlines.size(), kMostTiles);
  std::string html = "<ul class=\"tiles\">\n";
  for (std::size_t i = 0; i < shown; ++i)
    html += Tile(outlines[i], folder.Discs().value_or(DrapeDiscs()));
  html += "</ul>\n";
  if (shown < outlines.size())
    html += HtmlElement(
        "p",
        Format("The first %zu of %zu drapes; %s has all.", shown, outlines.size(), kOutlinesFile),
        "missing");
  return page->IfItFits(folder.name + ": outlines of the drapes", html);
}

std::string Branches(const ResultFolder& folder) {
  if (folder.program != "drape_equilibria") return "";
  const nlohmann::json& branches = FindList(folder.summary, "/branches");
  std::vector<CellRow> rows;
  for (const nlohmann::json& branch : branches) {
    if (rows.size() == kMostBranches) break;
    const auto number = [&](const char* where, double factor, const char* format) {
      return NumberCell(NumberText(branch, where, factor, format));
    };
    const nlohmann::json* stable = Find(branch, "/stable");
    rows.push_back({{Format("branch %zu", rows.size() + 1), Cell::Kind::kHeader},
                    NumberCell(std::to_string(FindList(branch, "/seeds").size())),
                    number("/frequency", 100, "%.0f"),
                    number("/dc", 100, "%.1f"),
                    number("/folds", 1, "%.0f"),
                    number("/energy_J", 1e3, "%.4f"),
                    {stable != nullptr && *stable == true ? "yes" : "no"},
                    {FindText(branch, "/state")}});
  }
  if (rows.empty()) return "";
  std::string html = HtmlTable("Branches, the most frequent first; energy is of the lowest drape",
                               {"", "drapes", "share [%]", "drape coefficient [%]", "nodes",
                                "energy [mJ]", "stable", "state"},
                               rows);
  if (branches.size() > kMostBranches)
    html += HtmlElement("p",
                        Format("The first %zu of %zu branches; summary.json has all.",
                               kMostBranches, branches.size()),
                        "missing");
  return html;
}

}  // namespace

void AddOutlines(const std::vector<ResultFolder>& folders, ReportPage* page) {
  std::string html = SideBySide(
      folders, [&](const auto& folder) { return Branches(folder) + Tiles(folder, page); });
  if (html.find("class=\"tiles\"") != std::string::npos)
    html = HtmlElement("p",
                       "One colour for each specimen or branch; below each drape its drape "
                       "coefficient and number of nodes. The circles are the support and the flat "
                       "cloth.",
                       "quiet") +
           html;
  page->AddSection("outlines", "Drapes from above", html);
}

}  // namespace drape
