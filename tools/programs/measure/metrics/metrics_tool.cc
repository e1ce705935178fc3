// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/trivial_predictors.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/measured_surface.h"
#include "losses/outline/outline.h"
#include "physics/mesh/scan_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/samples.h"
#include "tools/programs/results/tables/sample_report.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// The options of drape_metrics.
struct MetricsOptions {
  std::vector<std::string> operands;  // files and folders; none with a data set
  CameraInput camera;
  DiscsInput discs;
  std::string centre = "auto";  // CentreMode; auto: outline for drapes by themselves
  DatasetQuery data;            // its folder: none with operands
  std::string csv;              // file of the drapes measured by themselves
  std::string statistics;       // file of their means
  std::string overlay;          // picture of one
  std::string out;              // JSON file
};

// Files to measure or to compare.

// The view of a drape.
struct View {
  CameraInput camera;
  CentreMode centre = CentreMode::kNominal;
  DrapeDiscs discs = {};
};

struct ViewedFile {
  std::string path;
  ObservedDrape seen;
  Camera camera;  // with the centre of this drape
  ImageQuality quality;
  std::optional<ObjSurface> surface;  // of a mesh [m]
};

bool IsImage(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

// Returns whether `path` is a folder. Throws InputError when there is nothing there.
bool IsFolder(const std::string& path) {
  if (!fs::exists(path)) throw InputError(path, "no such file or folder");
  return fs::is_directory(path);
}

// Moves the middle of the extents to the origin, but for z.
void Centre(ObjSurface* surface) {
  auto x = surface->x.reshaped(3, surface->x.size() / 3);
  const Eigen::Vector3d middle = 0.5 * (x.rowwise().minCoeff() + x.rowwise().maxCoeff());
  x.topRows<2>().colwise() -= middle.head<2>();
}

// A mesh, checked like an image: through an image of it. Its centre is searched for from the middle
// of its extents.
ViewedFile ViewMesh(const std::string& path, const View& view) {
  ObjSurface surface = ReadSurface(path);
  CameraInput input = view.camera;
  const Camera camera = MakeCamera(input, view.discs);
  const bool is_free =
      view.centre == CentreMode::kOutline && !input.gives_camera() && !input.gives_centre();
  if (is_free) Centre(&surface);
  const std::vector<std::string> notes = CheckSurface(&surface, view.discs, path);
  if (is_free) Centre(&surface);
  GrayImage image = ObserveSurface(surface, camera, view.discs, path).image;
  if (!input.gives_camera() && !camera.is_pinhole()) {
    input.scale = camera.scale;
    input.image_width_mm = CameraInput::kNotGiven;
  }
  MeasuredImage measured =
      MeasureImage({std::move(image), {}}, input, view.centre, view.discs, path);
  measured.quality.notes.insert(measured.quality.notes.end(), notes.begin(), notes.end());
  return {path, ObserveImage(measured.image, measured.camera, view.discs, path), measured.camera,
          std::move(measured.quality), std::move(surface)};
}

// A drape by itself. Throws InputError for whatever cannot be read or seen, and for what shows no
// drape.
ViewedFile ViewFile(const std::string& path, const View& view) {
  if (IsSurfaceFile(path)) return ViewMesh(path, view);
  MeasuredImage measured =
      MeasureImage(ReadSilhouette(path), view.camera, view.centre, view.discs, path);
  return {path,
          ObserveImage(measured.image, measured.camera, view.discs, path),
          measured.camera,
          std::move(measured.quality),
          {}};
}

// A drape to be compared with others that `camera` sees; with CentreMode::kOutline it is moved so
// that its centre is that of the camera. Throws InputError also for an image of another size.
ViewedFile ViewFileBeside(const std::string& path, const View& view, const Camera& camera) {
  View same = view;
  same.camera.width = camera.width;
  same.camera.height = camera.height;
  if (IsSurfaceFile(path) && view.camera.picture.given()) {
    same.camera.scale = camera.scale;
    same.camera.picture = {};
  }
  ViewedFile file = ViewFile(path, same);
  if (file.camera.pixels_per_metre() != camera.pixels_per_metre())
    throw InputError(path, Format("is seen at %.1f px/m, expected the %.1f of the first image",
                                  file.camera.pixels_per_metre(), camera.pixels_per_metre()));
  if (view.centre == CentreMode::kNominal) return file;
  file.seen =
      ObserveImage(MovedImage(file.seen.image, file.camera, camera), camera, view.discs, path);
  return file;
}

// The camera of a comparison: of the size of the first image among the files, or that of a
// rendering where all are meshes.
Camera FindCamera(const CameraInput& input, const DrapeDiscs& discs,
                  const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (!IsSurfaceFile(file)) return MakeCamera(input, ReadImage(file), discs, file);
  return MakeCamera(input, discs);
}

// Images and meshes in a folder, sorted. Throws InputError for fewer than `least`.
std::vector<std::string> DrapesIn(const std::string& folder, size_t least) {
  std::vector<std::string> files;
  for (const fs::path& path : fs::directory_iterator(folder))
    if (IsSurfaceFile(path) || IsImage(path)) files.push_back(path.string());
  std::sort(files.begin(), files.end());
  if (files.size() < least) {
    throw InputError(folder, "found " + std::to_string(files.size()) +
                                 " images and meshes, expected at least " + std::to_string(least));
  }
  return files;
}

// Reports: tables for a terminal (mm, mm²), JSON in SI units.

struct ComparedPair {
  std::string a, b;  // paths
  DrapeComparison comparison;
  std::optional<SurfaceDistance> surfaces;  // of two meshes
  ShapeFeatures shape_a, shape_b;
  std::vector<std::string> notes;  // on the images
};
// One drape by itself, or why it could not be measured.
struct MeasuredDrape {  // NOLINT(bugprone-exception-escape)
  std::string file;
  std::string error;   // empty: measured
  SampleRow row = {};  // of a table
  Camera camera;
  ImageQuality quality;
  double area = 0.0;         // inside the outline [m²]
  double mean_radius = 0.0;  // [m]
  ShapeFeatures shape;
  LaboratoryDrape laboratory;
};

constexpr double kCm2 = 1e-4;
constexpr double kDegree = M_PI / 180;
constexpr const char* kSheetTitle = "The drape, as laboratories report it";

std::string TwoNumbers(const char* name, double a, double b) {
  return Format("  %-26s %10.4g %10.4g\n", name, a, b);
}

// A feature as tables and CSV files show it.
struct FeatureColumn {
  const char* name;  // with its unit
  const char* key;   // of a CSV column
  double (*value)(const ShapeFeatures& shape);
};
constexpr FeatureColumn kFeatureColumns[] = {
    {"drape coefficient", "dc", [](const ShapeFeatures& s) { return s.drape_coefficient; }},
    {"folds", "folds", [](const ShapeFeatures& s) { return double(s.folds); }},
    {"band 2 [mm2]", "band_2_mm2", [](const ShapeFeatures& s) { return s.band_energy[0] / kMm2; }},
    {"band 3-5 [mm2]", "band_3_5_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[1] / kMm2; }},
    {"band 6-9 [mm2]", "band_6_9_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[2] / kMm2; }},
    {"band 10-15 [mm2]", "band_10_15_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[3] / kMm2; }},
    {"smallest radius [mm]", "radius_min_mm",
     [](const ShapeFeatures& s) { return s.radius_min / kMm; }},
    {"largest radius [mm]", "radius_max_mm",
     [](const ShapeFeatures& s) { return s.radius_max / kMm; }},
    {"isoperimetric ratio", "isoperimetric_ratio",
     [](const ShapeFeatures& s) { return s.isoperimetric_ratio; }}};

std::string ShapeText(const ShapeFeatures& a, const ShapeFeatures& b) {
  std::string text = Format("  %-26s %10s %10s\n", "", "A", "B");
  for (const FeatureColumn& column : kFeatureColumns)
    text += TwoNumbers(column.name, column.value(a), column.value(b));
  return text;
}

Json ShapeJson(const ShapeFeatures& shape) {
  return {
      {"dc", shape.drape_coefficient},       {"folds", shape.folds},
      {"band_energy_m2", shape.band_energy}, {"radius_min_m", shape.radius_min},
      {"radius_max_m", shape.radius_max},    {"isoperimetric_ratio", shape.isoperimetric_ratio}};
}

std::string CameraLine(const MeasuredDrape& drape) {
  if (IsSurfaceFile(drape.file)) return "a mesh, seen from above";
  return CameraText(drape.camera, drape.quality);
}

std::string JoinedNotes(const MeasuredDrape& drape) {
  std::string text;
  for (const std::string& note : drape.quality.notes) text += (text.empty() ? "" : "; ") + note;
  return text;
}

std::string MeasuredText(const MeasuredDrape& drape) {
  const auto line = [](const char* name, double value) {
    return Format("  %-26s %10.4g\n", name, value);
  };
  std::string text =
      drape.file + "\n  " + CameraLine(drape) + "\n" +
      Format("  %-26s %10.1f\n", "drape coefficient [%]", 100 * drape.shape.drape_coefficient) +
      line("area [cm2]", drape.area / kCm2) + line("mean radius [mm]", drape.mean_radius / kMm);
  for (const FeatureColumn& column : kFeatureColumns)
    text += line(column.name, column.value(drape.shape));
  text += SheetText(DrapeSheet(drape.laboratory, kSheetTitle));
  for (const std::string& note : drape.quality.notes) text += "  note: " + note + "\n";
  return text;
}

// One line for each drape.
std::string MeasuredTable(const std::vector<MeasuredDrape>& drapes) {
  std::string text = Format("%-32s %8s %6s %10s %18s %8s  %s\n", "file", "DC [%]", "folds",
                            "area [cm2]", "radius [mm]", "px/m", "notes");
  for (const MeasuredDrape& drape : drapes) {
    const std::string name = std::filesystem::path(drape.file).filename();
    if (!drape.error.empty()) {
      text += Format("%-32s ", name.c_str()) + "not measured: " + drape.error + "\n";
      continue;
    }
    text += Format("%-32s %8.1f %6d %10.1f %8.1f … %-8.1f %7.1f  ", name.c_str(),
                   100 * drape.shape.drape_coefficient, drape.shape.folds, drape.area / kCm2,
                   drape.shape.radius_min / kMm, drape.shape.radius_max / kMm,
                   drape.camera.pixels_per_metre()) +
            JoinedNotes(drape) + "\n";
  }
  return text;
}

// The drapes as comma-separated values, with a line of names that hold the units.
std::string MeasuredCsv(const std::vector<MeasuredDrape>& drapes) {
  Json lines = Json::array();
  for (const MeasuredDrape& drape : drapes) {
    Json line = {{"file", drape.file}};
    if (drape.row.cells.is_object()) line.update(drape.row.cells);
    line["file"] = drape.file;
    const auto add = [&](const std::string& key, double value) {
      line[key] = drape.error.empty() ? Json(value) : Json();
    };
    for (const FeatureColumn& column : kFeatureColumns) add(column.key, column.value(drape.shape));
    add("area_cm2", drape.area / kCm2);
    add("radius_mean_mm", drape.mean_radius / kMm);
    add("centre_column_px", drape.camera.cx);
    add("centre_row_px", drape.camera.cy);
    add("px_per_m", drape.camera.pixels_per_metre());
    for (const LaboratoryRow& row : DrapeSheet(drape.laboratory, "").rows) add(row.key, row.value);
    line["notes"] = JoinedNotes(drape);
    line["error"] = drape.error;
    lines.push_back(std::move(line));
  }
  return CsvOfObjects(lines);
}

Json MeasuredJson(const MeasuredDrape& drape) {
  Json json = {{"file", drape.file}};
  if (!drape.error.empty()) {
    json["error"] = drape.error;
    return json;
  }
  json["shape"] = ShapeJson(drape.shape);
  json["area_m2"] = drape.area;
  json["radius_mean_m"] = drape.mean_radius;
  json["laboratory"] = DrapeSheetJson(drape.laboratory, kSheetTitle);
  json["camera"] = CameraJson(drape.camera);
  json["quality"] = QualityJson(drape.quality);
  return json;
}

std::string PairText(const ComparedPair& pair) {
  const auto& [raw, aligned, alignment] = pair.comparison;
  std::string notes;
  for (const std::string& note : pair.notes) notes += "  note: " + note + "\n";
  std::string text =
      "A " + pair.a + "\nB " + pair.b + "\n" +
      Format("  %-26s %10s %10s\n", "", "as it lies", "aligned") +
      TwoNumbers("silhouette MSE", raw.mse, aligned.mse) +
      TwoNumbers("silhouette IoU", raw.iou, aligned.iou) +
      TwoNumbers("outline rms [mm]", raw.profile_rms / kMm, aligned.profile_rms / kMm) +
      TwoNumbers("outline Hausdorff [mm]", raw.outline_hausdorff / kMm,
                 aligned.outline_hausdorff / kMm);
  if (pair.surfaces)
    text += TwoNumbers("surface Hausdorff [mm]", pair.surfaces->raw / kMm,
                       pair.surfaces->aligned / kMm);
  return text +
         Format("  aligned: B %sturned by %.1f deg counter-clockwise\n",
                alignment.mirrored ? "mirrored (y to -y) and " : "", alignment.rotation / kDegree) +
         ShapeText(pair.shape_a, pair.shape_b) + notes;
}

Json PairJson(const ComparedPair& pair) {
  const DrapeComparison& c = pair.comparison;
  Json json = {
      {"a", {{"file", pair.a}, {"shape", ShapeJson(pair.shape_a)}}},
      {"b", {{"file", pair.b}, {"shape", ShapeJson(pair.shape_b)}}},
      {"raw", DistanceJson(c.raw)},
      {"aligned", DistanceJson(c.aligned)},
      {"alignment", {{"rotation_rad", c.alignment.rotation}, {"mirrored", c.alignment.mirrored}}},
      {"notes", pair.notes}};
  if (pair.surfaces) {
    json["raw"]["surface_hausdorff_m"] = pair.surfaces->raw;
    json["aligned"]["surface_hausdorff_m"] = pair.surfaces->aligned;
  }
  return json;
}

// The view of drapes by themselves or in a comparison. files: they name the discs of the drapes,
// and have to agree.
View MakeView(const MetricsOptions& options, CentreMode by_default,
              std::vector<std::string> files) {
  const CentreMode centre =
      options.centre == "auto" ? by_default : ParseName<CentreMode>(options.centre, "centre");
  const std::size_t count = files.size();
  for (std::size_t i = 0; i < count; ++i) files.push_back(options.camera.FileFor(files[i]));
  return {options.camera, centre, FindDiscs(options.discs, files)};
}

void AppendNotes(const ViewedFile& file, std::vector<std::string>* notes) {
  for (const std::string& note : file.quality.notes) notes->push_back(file.path + ": " + note);
}

ComparedPair Compare(const std::string& a, const std::string& b, const View& view,
                     const Camera& camera) {
  const ViewedFile first = ViewFileBeside(a, view, camera);
  const ViewedFile second = ViewFileBeside(b, view, camera);
  ComparedPair pair{
      a, b, CompareDrapes(first.seen, second.seen, camera), {}, first.seen.shape, second.seen.shape,
      {}};
  AppendNotes(first, &pair.notes);
  AppendNotes(second, &pair.notes);
  if (first.surface && second.surface) {
    pair.surfaces = CompareSurfaces(*first.surface, *second.surface, pair.comparison.alignment,
                                    a + " and " + b);
  }
  return pair;
}

// The results of a mode: the table and its part of the JSON file.
struct Found {
  std::string text;
  Json json;
};

MeasuredDrape Measure(const std::string& path, const View& view, ViewedFile* viewed) {
  *viewed = ViewFile(path, view);
  return {path,
          {},
          {},
          viewed->camera,
          viewed->quality,
          ProfileArea(viewed->seen.radius),
          viewed->seen.radius.mean(),
          viewed->seen.shape,
          MeasureLaboratoryDrape(viewed->seen.radius, view.discs)};
}

Found MeasureOne(const MetricsOptions& options, const std::string& path) {
  const View view = MakeView(options, CentreMode::kOutline, {path});
  ViewedFile viewed;
  const MeasuredDrape drape = Measure(path, view, &viewed);
  if (!options.csv.empty()) WriteFileAtomically(options.csv, MeasuredCsv({drape}));
  if (!options.overlay.empty()) {
    const GrayImage picture = viewed.surface ? viewed.seen.image : ReadImage(path);
    const Eigen::VectorXd radius_px = viewed.seen.radius * viewed.camera.pixels_per_metre();
    WritePng(RenderMeasurement(picture, radius_px, viewed.camera, view.discs), options.overlay);
  }
  return {MeasuredText(drape), MeasuredJson(drape)};
}

// The view of a drape of a table. A drape that cannot be measured becomes a line with the reason.
MeasuredDrape MeasureRow(const MetricsOptions& options, const SampleRow& row) {
  MetricsOptions own = options;
  if (row.diameter > 0) own.discs.specimen = row.diameter;
  MeasuredDrape drape;
  try {
    ViewedFile viewed;
    drape = Measure(row.file, MakeView(own, CentreMode::kOutline, {row.file}), &viewed);
  } catch (const InputError& error) {
    const std::string reason = error.what(), name = row.file + ": ";
    drape.file = row.file;
    drape.error = reason.starts_with(name) ? reason.substr(name.size()) : reason;
  }
  drape.row = row;
  return drape;
}

MeasuredSample MakeSample(const MetricsOptions& options, const MeasuredDrape& drape) {
  const auto photograph = options.camera.gives_camera() && drape.error.empty()
                              ? ReadPhotographNotes(options.camera.FileFor(drape.file))
                              : std::nullopt;
  return {.row = drape.row,
          .error = drape.error,
          .coefficient = drape.shape.drape_coefficient,
          .coefficient_sd = photograph ? photograph->coefficient_sd : 0.0,
          .nodes = drape.shape.folds,
          .notes = JoinedNotes(drape)};
}

Found MeasureEach(const MetricsOptions& options, const SampleTable& table,
                  const RunControl& control) {
  std::vector<MeasuredDrape> drapes;
  std::vector<MeasuredSample> samples;
  for (const SampleRow& row : table.rows) {
    if (control.cancelled()) return {};
    control.Report(static_cast<double>(drapes.size()) / static_cast<double>(table.rows.size()),
                   row.file);
    drapes.push_back(MeasureRow(options, row));
    samples.push_back(MakeSample(options, drapes.back()));
  }
  if (std::ranges::none_of(drapes, [](const auto& drape) { return drape.error.empty(); }))
    throw InputError(options.operands[0], "none of " + std::to_string(drapes.size()) +
                                              " drapes can be measured; " + drapes[0].file + ": " +
                                              drapes[0].error);
  Found found{MeasuredTable(drapes), {{"drapes", Json::array()}}};
  for (const MeasuredDrape& drape : drapes) found.json["drapes"].push_back(MeasuredJson(drape));
  found.json["samples"] = SamplesJson(samples);
  found.text += "\n" + SamplesText(found.json["samples"]);
  if (!options.csv.empty()) WriteFileAtomically(options.csv, MeasuredCsv(drapes));
  if (!options.statistics.empty())
    WriteFileAtomically(options.statistics, CsvOfObjects(found.json["samples"]["groups"]));
  return found;
}

// The drapes in A as draws of a distribution that those in B were drawn from.
Found CompareDistributions(const MetricsOptions& options, const RunControl& control) {
  std::vector<std::string> files[2];
  for (int side = 0; side < 2; ++side)
    files[side] = DrapesIn(options.operands[side], side == 0 ? 2 : 1);
  std::vector<std::string> all = files[0];
  all.insert(all.end(), files[1].begin(), files[1].end());
  const View view = MakeView(options, CentreMode::kNominal, all);
  const Camera camera = FindCamera(options.camera, view.discs, all);
  std::vector<ObservedDrape> drapes[2];
  DistributionScorer::Drapes views[2];
  for (int side = 0; side < 2; ++side) {
    for (const std::string& path : files[side]) {
      if (control.cancelled()) return {};
      drapes[side].push_back(ViewFileBeside(path, view, camera).seen);
    }
    for (const ObservedDrape& drape : drapes[side]) views[side].push_back(&drape);
  }
  DistributionScorer scorer;
  scorer.Add(views[0], views[1]);
  const DistributionScore score = scorer.Score();
  Found found{std::to_string(views[0].size()) + " draws in " + options.operands[0] +
                  ", observed in " + options.operands[1] + "\n" + ScoreText(score),
              ScoreJson(score)};
  found.json["draws"] = views[0].size();
  found.json["camera"] = CameraJson(camera);
  return found;
}

Found CompareTwo(const MetricsOptions& options, const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  const bool a = IsFolder(operands[0]), b = IsFolder(operands[1]);
  if (a && b) return CompareDistributions(options, control);
  if (a != b)
    throw InputError(operands[a ? 0 : 1],
                     "is a folder, expected a file like " + operands[a ? 1 : 0]);
  const View view = MakeView(options, CentreMode::kNominal, operands);
  const Camera camera = FindCamera(options.camera, view.discs, operands);
  const ComparedPair pair = Compare(operands[0], operands[1], view, camera);
  Found found{PairText(pair), PairJson(pair)};
  found.json["camera"] = CameraJson(camera);
  return found;
}

// The name of the folder of a file.
std::string ParentName(const std::string& file) {
  return fs::weakly_canonical(file).parent_path().filename();
}

void RequireOnlyWith(const std::string& option, const std::string& value, bool fits,
                     const std::string& expected) {
  if (!value.empty() && !fits) throw InputError("option '" + option + "'", "expected " + expected);
}

Found EvaluateOperands(const MetricsOptions& options, const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  if (operands.empty())
    throw InputError("command line",
                     "found no file or folder, expected a drape, a folder of them, "
                     "two to compare (A and B), or --data");
  const bool one = operands.size() == 1, folder = one && fs::is_directory(operands[0]);
  const bool table = one && IsSampleTable(operands[0]);
  RequireOnlyWith("overlay", options.overlay, one && !folder && !table, "one drape");
  RequireOnlyWith("csv", options.csv, operands.size() != 2, "drapes that are not compared");
  RequireOnlyWith("statistics", options.statistics, folder || table || operands.size() > 2,
                  "several drapes that are not compared");
  if (operands.size() == 2) return CompareTwo(options, control);
  if (table) return MeasureEach(options, ReadSamples(operands[0]), control);
  if (folder) {
    const std::vector<std::string> files = DrapesIn(operands[0], 1);
    return MeasureEach(options, SamplesOfFiles(files, ParentName(files[0])), control);
  }
  for (const std::string& operand : operands) {
    if (IsFolder(operand))
      throw InputError(operand, "is a folder among files, expected one folder, or files");
  }
  return one ? MeasureOne(options, operands[0])
             : MeasureEach(options, SamplesOfFiles(operands, ParentName(operands[0])), control);
}

Found EvaluateData(const MetricsOptions& options, const RunControl& control) {
  const Camera camera = MakeCamera(options.camera, DrapeDiscs());
  if (FindDiscs(options.discs) != DrapeDiscs())
    throw InputError("option 'specimen' or 'support'",
                     "found " + ToString(FindDiscs(options.discs)) +
                         " beside the published data set, expected its " + ToString(DrapeDiscs()));
  if (!options.operands.empty())
    throw InputError("command line", "found '" + options.operands[0] + "' beside --data");
  const DatasetReport report = EvaluateDataset(options.data, camera, control);
  Found found{DatasetText(report), DatasetJson(report)};
  found.json["camera"] = CameraJson(camera);
  return found;
}

// The option of the centre.
std::vector<Option> ViewOptions(MetricsOptions& options) {
  return {ChoiceOption("centre", &options.centre, {"auto", "nominal", "outline"},
                       "where the support's centre is: nominal: at camera_cx, camera_cy; outline: "
                       "found from the outline of each drape; auto: outline for drapes by "
                       "themselves, nominal for those that are compared")};
}

std::vector<Option> FileOptions(MetricsOptions& options) {
  return {
      PathOption("csv", &options.csv, "drapes by themselves: file with one line for each"),
      PathOption("statistics", &options.statistics,
                 "several drapes: file with mean, standard deviation, n and interval by fabric, "
                 "sample, specimen and face"),
      PathOption("overlay", &options.overlay,
                 "one drape by itself: PNG of its outline (blue), the support (green) and the flat "
                 "cloth (brown)"),
      PathOption("out", &options.out, "JSON file for the results")};
}

OptionTable MetricsTable(MetricsOptions& options) {
  std::vector<Option> all = Concatenate(Grouped("camera", FieldOptionList(options.camera)),
                                        FieldOptionList(options.discs), ViewOptions(options),
                                        Grouped("data set", FieldOptionList(options.data)),
                                        OfOneRun(FileOptions(options)));
  return {
      .tool = "drape_metrics",
      .summary =
          "measures drapes, compares two, scores predicted drapes, and evaluates predictors "
          "without a model on a data set",
      .example = "drape_metrics photo.jpg --image_width_mm=400 --overlay=outline.png",
      .notes =
          "one image or mesh (OBJ, STL, PLY): drape coefficient, folds, area, radii and other "
          "features of the outline; a folder, a table samples.csv (drape_photo --help), or three "
          "or more files: a line for each, and their means; what cannot be measured "
          "becomes a line with the reason (exit code 2 only if nothing can be measured)\n"
          "two, A and B, are compared: two images or meshes; or two folders of images and "
          "meshes: A holds samples of a distribution, B what was observed\n"
          "aligned: after the rotation and reflection of B that brings its outline closest to "
          "that of A\n",
      .options = std::move(all),
      .common = {"image_width_mm", "camera_scale", "specimen", "support", "centre", "csv",
                 "statistics", "overlay", "data", "data_fabric", "out"},
      .operands = &options.operands,
      .operand_names = "[A [B …]]"};
}

// Measures one file, a folder or several files, compares two files or folders, or lists a data set
// and evaluates its trivial predictors. Writes the files that the options name.
ToolOutcome Run(const MetricsOptions& options, const RunControl& control) {
  for (const std::string& file : {options.out, options.csv, options.statistics, options.overlay})
    if (!file.empty()) {
      CheckKeeps(file);
      CheckReplaceable(file);
    }
  const Found found = options.data.folder.empty() ? EvaluateOperands(options, control)
                                                  : EvaluateData(options, control);
  if (control.cancelled()) return {.cancelled = true};
  if (!options.out.empty()) WriteWithProvenance(options.out, found.json);
  return {.text = found.text};
}

}  // namespace

int MetricsMain(int argc, char** argv) { return ToolMain(argc, argv, MetricsTable, Run); }

}  // namespace drape
