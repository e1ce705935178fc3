// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/measure_part.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"
#include "tools/programs/results/report/parts/verdict_part.h"

namespace drape {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMostDrapeRows = 500;  // in a table

Cell Number(const json& object, const char* where, double factor, const char* format) {
  return NumberCell(NumberText(object, where, factor, format));
}

CellRow Row(const char* name, std::vector<Cell> cells) {
  CellRow row = {{name, Cell::Kind::kHeader}};
  row.insert(row.end(), cells.begin(), cells.end());
  return row;
}

std::string PhotographText(const ResultFolder& folder, ReportPage* page) {
  const json& s = folder.summary;
  std::vector<CellRow> rows = {
      Row("drape coefficient, ± standard deviation [%]", {NumberCell(CoefficientText(s))}),
      Row("the same without a model of the camera [%]",
          {Number(s, "/dc_without_camera_model", 100, "%.1f")}),
      Row("nodes", {Number(s, "/folds", 1, "%.0f")}),
      Row("smallest radius [mm]", {Number(s, "/radius_min_m", 1e3, "%.1f")}),
      Row("largest radius [mm]", {Number(s, "/radius_max_m", 1e3, "%.1f")}),
      Row("camera above the support [m]", {Number(s, "/camera/eye_height_m", 1, "%.2f")}),
      Row("its tilt [degrees]", {Number(s, "/tilt_rad", 180 / M_PI, "%.1f")}),
      Row("scale [px/m]", {Number(s, "/camera/px_per_m", 1, "%.0f")}),
      Row("error of the marker's outline, rms [px]", {Number(s, "/marker_rms_px", 1, "%.2f")}),
      Row("marker seen [%]", {Number(s, "/marker_seen_share", 100, "%.0f")}),
      Row("blur of the hem [mm]", {Number(s, "/blur_m", 1e3, "%.1f")}),
      Row("specimen [cm]", {Number(s, "/specimen_diameter_m", 100, "%.0f")}),
      Row("support [cm]", {Number(s, "/support_diameter_m", 100, "%.0f")})};
  std::erase_if(rows, [](const CellRow& row) { return row[1].text == "none"; });
  std::string picture;
  const std::string file = folder.File("overlay.png");
  if (fs::is_regular_file(file))
    picture = page->AddImage(file, "The photograph with the outline and the disc that were found",
                             FindText(s, "/photo"));
  return "<div class=\"side\">\n<div>" + picture + "</div>\n<div>" +
         HtmlTable("", {"", "found"}, rows) + "</div></div>\n";
}

// The photographs that a fit is of, but for those whose folders have a column of their own.
std::string FitPhotographs(const ResultFolder& fit, const std::vector<ResultFolder>& folders,
                           ReportPage* page) {
  std::string html;
  for (const json& image : FindList(fit.summary, "/images"))
    if (const auto photograph = FindPhotograph(image);
        photograph && std::none_of(folders.begin(), folders.end(), [&](const auto& folder) {
          return fs::equivalent(folder.path, photograph->path);
        }))
      html += PhotographText(*photograph, page);
  return html;
}

CellRow MeasuredRow(const json& drape) {
  const std::string file = FindText(drape, "/file"), error = FindText(drape, "/error");
  std::string notes = error.empty() ? "" : "not measured: " + error;
  for (const std::string& note : FindTexts(drape, "/quality/notes"))
    notes += (notes.empty() ? "" : "; ") + note;
  return {{file, Cell::Kind::kHeader},
          Number(drape, "/shape/dc", 100, "%.1f"),
          Number(drape, "/shape/folds", 1, "%.0f"),
          Number(drape, "/area_m2", 1e4, "%.1f"),
          Number(drape, "/shape/radius_min_m", 1e3, "%.1f"),
          Number(drape, "/shape/radius_max_m", 1e3, "%.1f"),
          {notes}};
}

std::string Measured(const json& drapes) {
  std::vector<CellRow> rows;
  std::string sheets;
  for (const json& drape : drapes) {
    if (rows.size() == kMostDrapeRows) break;
    rows.push_back(MeasuredRow(drape));
    if (const json* sheet = Find(drape, "/laboratory"); sheet != nullptr && sheet->is_object())
      sheets += HtmlDetails(FindText(drape, "/file"), LaboratoryHtml(*sheet));
  }
  std::string html = HtmlTable("",
                               {"file", "drape coefficient [%]", "nodes", "area [cm²]",
                                "smallest radius [mm]", "largest radius [mm]", "notes"},
                               rows) +
                     sheets;
  if (drapes.size() > kMostDrapeRows)
    html += HtmlElement("p", Format("the first %zu of %zu drapes", kMostDrapeRows, drapes.size()),
                        "missing");
  return html;
}

std::string Compared(const json& pair) {
  const auto row = [&](const char* name, const std::string& key, double factor,
                       const char* format) {
    return Row(name, {Number(pair, ("/raw/" + key).c_str(), factor, format),
                      Number(pair, ("/aligned/" + key).c_str(), factor, format)});
  };
  std::vector<CellRow> rows = {row("outline, rms [mm]", "outline_rms_m", 1e3, "%.2f"),
                               row("outline, Hausdorff [mm]", "outline_hausdorff_m", 1e3, "%.2f"),
                               row("silhouettes, IoU [%]", "iou", 100, "%.1f"),
                               row("silhouettes, MSE", "mse", 1, "%.4f")};
  if (Find(pair, "/raw/surface_hausdorff_m") != nullptr)
    rows.push_back(row("surfaces, Hausdorff [mm]", "surface_hausdorff_m", 1e3, "%.2f"));
  std::string html =
      HtmlTable("A " + FindText(pair, "/a/file") + ", B " + FindText(pair, "/b/file"),
                {"difference", "as they lie", "aligned"}, rows);
  rows.clear();
  for (const char* side : {"a", "b"}) {
    const json& shape = pair.at(side).at("shape");
    rows.push_back({{*side == 'a' ? "A" : "B", Cell::Kind::kHeader},
                    Number(shape, "/dc", 100, "%.1f"),
                    Number(shape, "/folds", 1, "%.0f"),
                    Number(shape, "/radius_min_m", 1e3, "%.1f"),
                    Number(shape, "/radius_max_m", 1e3, "%.1f")});
  }
  return html + HtmlTable("",
                          {"", "drape coefficient [%]", "nodes", "smallest radius [mm]",
                           "largest radius [mm]"},
                          rows);
}

std::string MetricsTable(const json& s) {
  if (s.contains("drapes")) return Measured(FindList(s, "/drapes"));
  if (s.contains("shape")) return Measured(json::array({s}));
  if (s.contains("raw")) return Compared(s);
  std::string html;
  for (const json& pair : FindList(s, "/pairs")) html += Compared(pair);
  if (!html.empty()) return html;
  json rest = s;
  rest.erase("versions");
  rest.erase("provenance");
  return HtmlTable("", {}, FlatRows(rest));
}

std::string Record(const json& record) {
  struct Reading {
    const char *key, *name, *unit;
    double factor = 1;
  };
  const Reading readings[] = {{"bend_warp", "bending rigidity, warp", "µN·m", 1e6},
                              {"bend_weft", "bending rigidity, weft", "µN·m", 1e6},
                              {"bend_bias", "bending rigidity, bias", "µN·m", 1e6},
                              {"c11", "tensile stiffness, weft (c11)", "N/m"},
                              {"c22", "tensile stiffness, warp (c22)", "N/m"},
                              {"c12", "coupling of warp and weft (c12)", "N/m"},
                              {"shear", "shear rigidity G", "N/m"}};
  std::vector<CellRow> rows;
  for (const Reading& reading : readings)
    if (const json* number = Find(record, std::string("/linear/") + reading.key))
      rows.push_back({{reading.name, Cell::Kind::kHeader},
                      Number(*number, "/value", reading.factor, "%.4g"),
                      Number(*number, "/sd", reading.factor, "%.2g"),
                      {reading.unit},
                      OriginCell(FindText(*number, "/origin"))});
  if (rows.empty()) return "";
  return HtmlTable("The linear record of " + FindText(record, "/name"),
                   {"quantity", "value", "standard deviation", "unit", "where from"}, rows);
}

std::string Export(const ResultFolder& folder) {
  if (folder.program != "drape_export") return "";
  std::vector<CellRow> rows;
  for (const json& target : FindList(folder.summary, "/targets")) {
    std::string lost;
    for (const std::string& text : FindTexts(target, "/lost"))
      lost += (lost.empty() ? "" : "; ") + text;
    rows.push_back({{FindText(target, "/target"), Cell::Kind::kHeader},
                    {FindText(target, "/file")},
                    {FindText(target, "/status")},
                    Number(target, "/round_trip/dc_change", 100, "%+.1f"),
                    Number(target, "/round_trip/nodes_change", 1, "%+.1f"),
                    {lost.empty() ? "nothing" : lost}});
  }
  std::string html;
  if (const json* record = Find(folder.summary, "/record")) html += Record(*record);
  if (!rows.empty())
    html += HtmlTable("Targets, and how the fabric drapes here with what is left of it",
                      {"target", "file", "status", "change of drape coefficient [points]",
                       "change of nodes", "what is lost"},
                      rows);
  for (const std::string& file : FindTexts(folder.summary, "/posterior_files"))
    html += HtmlElement("p", "Samples of the posterior: " + file);
  return html;
}

}  // namespace

void AddMeasurements(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("measurement", "Measurement", SideBySide(folders, [&](const auto& folder) {
                     if (folder.program == "drape_photo") return PhotographText(folder, page);
                     if (folder.program == "drape_metrics") return MetricsTable(folder.summary);
                     return folder.IsFit() ? FitPhotographs(folder, folders, page) : std::string();
                   }));
}

void AddExports(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("export", "For other programs", SideBySide(folders, Export));
}

}  // namespace drape
