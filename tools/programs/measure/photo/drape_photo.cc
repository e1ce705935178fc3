// SPDX-License-Identifier: Apache-2.0
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/photo/photo.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/forward/outline_pool.h"
#include "solver/job/first_answer.h"
#include "solver/studies/runner/study.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/samples.h"
#include "tools/programs/results/tables/sample_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// The options of drape_photo.
struct PhotoToolOptions {
  std::vector<std::string> operands;  // one photograph, several, a folder or a table
  PhotoOptions photo;
  ScaleInput scale;  // in place of photo.px_per_m
  std::string warp = kUnknownWarp;
  int threads = 0;  // 0: all cores
  std::string out;
};

constexpr double kDegree = M_PI / 180;
constexpr const char* kRefused = "refused.png";

struct Developed : PhotoResult {
  std::string length;  // bending length of pooled drapes like this one, with its name; empty
                       // without a pool of these discs
};

Json SummaryJson(const std::string& photo, const PhotoToolOptions& options, const Developed& result,
                 const std::string& silhouette) {
  Json json = {{"photo", photo},
               {"silhouette", silhouette},
               {"camera_file", "camera.json"},
               {"projected", "projected.png"},
               {"overlay", "overlay.png"},
               {"specimen_in_overlay_px", result.specimen_box},
               {"marker", ToString(options.photo.marker)},
               {"dc", result.shape.drape_coefficient},
               {"dc_sd", result.coefficient_sd},
               {"dc_is", "estimate from the hem's estimated heights"},
               {"dc_without_camera_model", result.plane_coefficient},
               {"folds", result.shape.folds},
               {"bending_length", result.length},
               {"radius_min_m", result.shape.radius_min},
               {"radius_max_m", result.shape.radius_max},
               {"camera", CameraJson(result.camera)},
               {"focal_px_of_photo", result.focal},
               {"tilt_rad", result.tilt.norm()},
               {"marker_rms_px", result.marker_rms},
               {"marker_seen_share", result.marker_share},
               {"blur_m", result.blur},
               {"contrast_lab", result.contrast},
               {"warnings", result.warnings}};
  json.update(DiscsJson(MakeDiscs(options.photo)));
  return json;
}

std::string ResultText(const std::string& photo, const PhotoToolOptions& options,
                       const Developed& result) {
  const Camera& camera = result.camera;
  std::string text =
      photo + "\n" +
      Format(
          "  drape coefficient          %.1f +- %.1f %% (estimate of the vertical projection, "
          "if the given sizes are right; %.1f %% without a model of the camera)\n",
          100 * result.shape.drape_coefficient, 100 * result.coefficient_sd,
          100 * result.plane_coefficient) +
      Format("  folds                      %d\n", result.shape.folds) +
      Format("  radius                     %.1f … %.1f mm\n", 1e3 * result.shape.radius_min,
             1e3 * result.shape.radius_max);
  if (!result.length.empty()) text += "  " + result.length + ", by pooled drapes like it\n";
  if (camera.kind == CameraKind::kPinhole)
    text += Format(
        "  camera                     %.2f m above the support, tilted by %.1f degrees, "
        "%.0f px/m\n",
        camera.eye_height, result.tilt.norm() / kDegree, camera.pixels_per_metre());
  for (const std::string& warning : result.warnings) text += "  note: " + warning + "\n";
  return text + "see " + options.out + "/overlay.png; a fit of it:\n";
}

OptionTable PhotoTable(PhotoToolOptions& options) {
  return {
      .tool = "drape_photo",
      .summary =
          "makes the silhouette of a drape and its camera from a photograph, or from each of "
          "many, and sums them up",
      .example = "drape_photo photo.jpg --focal_35mm=26 --out=out/photo",
      .notes =
          "SAMPLES: several photographs, a folder, or a table samples.csv with columns file, "
          "fabric, "
          "sample, specimen, face (up, down), warp, mass (g/m2), diameter (m), date, operator, of "
          "which file is needed; the columns support, disc, focal_35mm, threshold, cloth_points "
          "and ground_points set these options for their row. Each photograph gets a folder in the "
          "output folder. samples.csv "
          "there is the table with the silhouettes and what was measured, for drape_fit "
          "--images=samples.csv#fabric; statistics.csv has mean, standard deviation, n and "
          "interval "
          "by fabric, sample, specimen and face. The same command continues.\n"
          "files: silhouette.png and camera.json, which also has the drape coefficient, its "
          "standard deviation, the warp and the warnings, for drape_fit --camera_file; "
          "projected.png, the "
          "estimated vertical projection, for programs that know only the camera of the "
          "published images; overlay.png; summary.json\n"
          "exit code 2: the photograph, or each of several, was refused; refused.png shows why, "
          "other files are unchanged\n",
      .options =
          Concatenate(FieldOptionList(options.photo), FieldOptionList(options.scale),
                      std::vector<Option>{PlainOption("warp", &options.warp, kWarpDoc),
                                          ThreadsOption(options.threads), OutOption(options.out)}),
      .common = {"marker", "specimen", "support", "disc", "tag", "focal_35mm", "px_per_m", "warp",
                 "out"},
      .operands = &options.operands,
      .operand_names = "PHOTO|SAMPLES"};
}

PhotoOptions WithScale(const PhotoToolOptions& options, const std::string& file) {
  PhotoOptions photo = options.photo;
  if (!options.scale.given()) return photo;
  if (photo.marker != PhotoMarker::kNone || photo.px_per_m > 0)
    throw InputError("option 'ruler' or 'dpi'",
                     "found with a marker or px_per_m, expected --marker=none alone");
  photo.px_per_m = options.scale.Find(file);
  return photo;
}

// Writes a silhouette of that name, camera.json, projected.png, overlay.png and summary.json to
// options.out. A photograph that is refused leaves earlier results as they were, writes
// refused.png, which shows why, and sets *refusal.
Developed Develop(const std::string& file, const PhotoToolOptions& options,
                  const std::string& silhouette, Json (*provenance)(), std::string* refusal) {
  ParseWarp(options.warp);
  const DrapeDiscs discs = MakeDiscs(options.photo);
  const auto pool = std::async(FindBuiltInPool, discs);  // unpacks it meanwhile
  const Photograph photo = ReadPhotograph(file);
  const OutputFolder out(options.out, {"summary.json", silhouette, "camera.json", "projected.png",
                                       "overlay.png", kRefused});
  Developed result{MeasurePhoto(photo, WithScale(options, file)), {}};
  if (result.fault != PhotoFault::kNone) {
    WritePng(result.overlay, out.Staged(kRefused));
    out.Publish();
    *refusal = std::string(ToString(result.fault)) + ": " + result.reason;
    return result;
  }
  auto overlay =
      std::async([&] { WritePng(result.overlay, out.Staged("overlay.png")); });  // takes longest
  if (const auto row = AnswerBendingLength(result.radius, discs)) result.length = row->Text();
  WritePng(result.silhouette, out.Staged(silhouette), discs);
  WritePng(result.projected, out.Staged("projected.png"), discs);
  Json camera = CameraJson(result.camera);
  camera.update(DiscsJson(discs));
  camera["warp"] = options.warp;
  camera["photograph"] = PhotographJson({.coefficient = result.shape.drape_coefficient,
                                         .coefficient_sd = result.coefficient_sd,
                                         .warnings = result.warnings});
  WriteFileAtomically(out.Staged("camera.json"), camera.dump(2) + "\n");
  Json summary = SummaryJson(file, options, result, silhouette);
  summary["provenance"] = provenance();
  WriteFileAtomically(out.Staged("summary.json"), summary.dump(2) + "\n");
  overlay.get();
  out.Publish();
  std::error_code ignored;
  std::filesystem::remove(options.out + "/" + kRefused, ignored);
  return result;
}

ToolOutcome RunOne(const PhotoToolOptions& options) {
  const std::string& file = options.operands[0];
  std::string refusal;
  const Developed result = Develop(file, options, "silhouette.png", MakeProvenance, &refusal);
  if (!refusal.empty())
    throw InputError(file, refusal + " (see " + options.out + "/" + kRefused + ")");
  return {.text = ResultText(file, options, result),
          .next = {"drape_fit", "--images=" + options.out + "/silhouette.png",
                   "--camera_file=" + options.out + "/camera.json"}};
}

// Columns of a table that set the option of their name for their row.
constexpr const char* kOptionColumns[] = {"support",   "disc",         "focal_35mm",
                                          "threshold", "cloth_points", "ground_points"};

// The options of a photograph of a table.
PhotoToolOptions RowOptions(const SampleRow& row, PhotoToolOptions options) {
  if (row.diameter > 0) options.photo.specimen = row.diameter;
  if (!row.of("warp").empty()) options.warp = row.of("warp");
  for (const char* key : kOptionColumns)
    if (!row.of(key).empty())
      PhotoTable(options).Set(key, row.of(key), row.file + ": column '" + key + "'");
  options.out += "/" + row.name;
  return options;
}

std::string SilhouetteName(const SampleRow& row) { return row.name + "/" + row.name + ".png"; }

Study MakeStudy(const PhotoToolOptions& options, const std::vector<SampleRow>& rows) {
  PhotoToolOptions copy = options;
  Study study{.name = "photo", .settings = OptionSettings(PhotoTable(copy), {"threads"})};
  for (const SampleRow& row : rows) {
    const PhotoToolOptions own = RowOptions(row, options);
    nlohmann::json input = {
        {"name", row.name}, {"specimen", own.photo.specimen}, {"warp", own.warp}};
    for (const char* key : kOptionColumns)
      if (!row.of(key).empty()) input[key] = row.of(key);
    study.cells.push_back(CheckedCell(row.name, input, [&] {
      ReadWholeFile(row.file);
      if (!options.photo.mask.empty()) ReadWholeFile(options.photo.mask);
    }));
  }
  study.run = [&](std::size_t k, const RunControl& control) -> std::optional<nlohmann::json> {
    if (control.cancelled()) return {};
    std::string failure;
    PhotoResult result;
    try {
      result = Develop(rows[k].file, RowOptions(rows[k], options), rows[k].name + ".png",
                       MakePartProvenance, &failure);
    } catch (const InputError& error) {
      failure = error.what();
    }
    if (!failure.empty()) return nlohmann::json{{"failure", failure}};
    return nlohmann::json{{"dc", result.shape.drape_coefficient},
                          {"dc_sd", result.coefficient_sd},
                          {"folds", result.shape.folds},
                          {"warnings", result.warnings}};
  };
  study.is_whole = [&](std::size_t k, const nlohmann::json& result) {
    return result.contains("failure") ||
           std::filesystem::exists(options.out + "/" + SilhouetteName(rows[k]));
  };
  return study;
}

MeasuredSample MakeSample(SampleRow row, const nlohmann::json& result) {
  row.cells["picture"] = std::exchange(row.file, SilhouetteName(row));
  row.cells["file"] = row.file;
  row.file = row.of("picture");
  if (result.contains("failure")) return {.row = std::move(row), .error = result.at("failure")};
  std::string notes;
  for (const std::string each : result.at("warnings")) notes += (notes.empty() ? "" : "; ") + each;
  return {.row = std::move(row),
          .coefficient = result.at("dc"),
          .coefficient_sd = result.at("dc_sd"),
          .nodes = result.at("folds"),
          .notes = notes};
}

// Each photograph of a table, a folder or a list.
ToolOutcome RunEach(const PhotoToolOptions& options, const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  const SampleTable table =
      operands.size() == 1 ? ReadSamples(operands[0]) : SamplesOfFiles(operands, "");
  const OutputFolder out(options.out, {"summary.json", "samples.csv", "statistics.csv"});
  const Study study = MakeStudy(options, table.rows);
  const StudyResult result =
      RunStudy(study, {.out = options.out, .threads = CountThreads(options.threads)}, control);
  if (result.cancelled) return {.cancelled = true};
  std::vector<MeasuredSample> pictures;
  for (std::size_t k = 0; k < table.rows.size(); ++k)
    pictures.push_back(MakeSample(table.rows[k], *result.results[k]));
  if (std::ranges::none_of(pictures, [](const auto& each) { return each.error.empty(); }))
    throw InputError(operands[0], "no photograph can be measured; " + pictures[0].row.file + ": " +
                                      pictures[0].error);
  Json summary = {{"samples", SamplesJson(pictures)}};
  WriteFileAtomically(out.Staged("samples.csv"), CsvOfObjects(summary["samples"]["pictures"]));
  WriteFileAtomically(out.Staged("statistics.csv"), CsvOfObjects(summary["samples"]["groups"]));
  const std::string text = SamplesText(summary["samples"]);
  WriteWithProvenance(out.Staged("summary.json"), std::move(summary));
  out.Publish();
  return {.text = text};
}

ToolOutcome Run(const PhotoToolOptions& options, const RunControl& control) {
  if (options.operands.empty())
    throw InputError("command line", "found no file, expected a photograph or samples");
  const std::string& first = options.operands[0];
  return options.operands.size() == 1 && !IsSampleTable(first) &&
                 !std::filesystem::is_directory(first)
             ? RunOne(options)
             : RunEach(options, control);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  mallopt(M_ARENA_MAX, 1);  // the memory of other threads grows by system calls
  return drape::ToolMain(argc, argv, drape::PhotoTable, drape::Run);
}
