// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/photo/photo.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// The options of drape_photo.
struct PhotoToolOptions {
  std::vector<std::string> operands;  // one photograph
  PhotoOptions photo;
  ScaleInput scale;  // in place of photo.px_per_m
  std::string warp = kUnknownWarp;
  std::string out;
};

constexpr double kDegree = M_PI / 180;
constexpr const char* kRefused = "refused.png";

Json SummaryJson(const std::string& photo, const PhotoToolOptions& options,
                 const PhotoResult& result) {
  Json json = {{"photo", photo},
               {"silhouette", "silhouette.png"},
               {"camera_file", "camera.json"},
               {"projected", "projected.png"},
               {"overlay", "overlay.png"},
               {"marker", ToString(options.photo.marker)},
               {"dc", result.shape.drape_coefficient},
               {"dc_sd", result.coefficient_sd},
               {"dc_is", "estimate from the hem's estimated heights"},
               {"dc_without_camera_model", result.plane_coefficient},
               {"folds", result.shape.folds},
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
                       const PhotoResult& result) {
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
  if (camera.kind == CameraKind::kPinhole)
    text += Format(
        "  camera                     %.2f m above the support, tilted by %.1f degrees, "
        "%.0f px/m\n",
        camera.eye_height, result.tilt.norm() / kDegree, camera.pixels_per_metre());
  for (const std::string& warning : result.warnings) text += "  note: " + warning + "\n";
  return text + "see " + options.out + "/overlay.png; a fit of it:\n";
}

std::string Operand(const PhotoToolOptions& options) {
  if (options.operands.size() != 1)
    throw InputError("command line",
                     Format("found %zu files, expected one photograph", options.operands.size()));
  return options.operands[0];
}

OptionTable PhotoTable(PhotoToolOptions& options) {
  return {
      .tool = "drape_photo",
      .summary = "makes the silhouette of a drape and its camera from a photograph",
      .example = "drape_photo photo.jpg --focal_35mm=26 --out=out/photo",
      .notes =
          "files: silhouette.png and camera.json, which also has the drape coefficient, its "
          "standard deviation, the warp and the warnings, for drape_fit --camera_file; "
          "projected.png, the "
          "estimated vertical projection, for programs that know only the camera of the "
          "published images; overlay.png; summary.json\n"
          "exit code 2: the photograph was refused; refused.png in the output folder shows why, "
          "its other files are unchanged\n",
      .options = Concatenate(FieldOptionList(options.photo), FieldOptionList(options.scale),
                             std::vector<Option>{PlainOption("warp", &options.warp, kWarpDoc),
                                                 OutOption(options.out)}),
      .common = {"marker", "specimen", "support", "disc", "tag", "focal_35mm", "px_per_m", "warp",
                 "out"},
      .operands = &options.operands,
      .operand_names = "PHOTO"};
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

// Writes silhouette.png, camera.json, projected.png, overlay.png and summary.json to options.out,
// and returns the lines for a terminal. Throws InputError: a photograph that is refused leaves
// earlier results as they were and writes refused.png, which shows why.
std::string RunPhoto(const PhotoToolOptions& options, const RunControl& control) {
  const std::string file = Operand(options);
  ParseWarp(options.warp);
  const Photograph photo = ReadPhotograph(file);
  control.Report(0.1, "photograph read");
  const OutputFolder out(options.out, {"summary.json", "silhouette.png", "camera.json",
                                       "projected.png", "overlay.png", kRefused});
  const PhotoResult result = MeasurePhoto(photo, WithScale(options, file));
  if (control.cancelled()) return "";
  if (result.fault != PhotoFault::kNone) {
    WritePng(result.overlay, out.Staged(kRefused));
    out.Publish();
    throw InputError(file, std::string(ToString(result.fault)) + ": " + result.reason + " (see " +
                               options.out + "/" + kRefused + ")");
  }
  const DrapeDiscs discs = MakeDiscs(options.photo);
  WritePng(result.silhouette, out.Staged("silhouette.png"), discs);
  WritePng(result.projected, out.Staged("projected.png"), discs);
  WritePng(result.overlay, out.Staged("overlay.png"));
  Json camera = CameraJson(result.camera);
  camera.update(DiscsJson(discs));
  camera["warp"] = options.warp;
  camera["photograph"] = PhotographJson({.coefficient = result.shape.drape_coefficient,
                                         .coefficient_sd = result.coefficient_sd,
                                         .warnings = result.warnings});
  WriteFileAtomically(out.Staged("camera.json"), camera.dump(2) + "\n");
  WriteWithProvenance(out.Staged("summary.json"), SummaryJson(file, options, result));
  out.Publish();
  std::error_code ignored;
  std::filesystem::remove(options.out + "/" + kRefused, ignored);
  return ResultText(file, options, result);
}

ToolOutcome Run(const PhotoToolOptions& options, const RunControl& control) {
  return {.text = RunPhoto(options, control),
          .next = {"drape_fit", "--images=" + options.out + "/silhouette.png",
                   "--camera_file=" + options.out + "/camera.json"},
          .cancelled = control.cancelled()};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::PhotoTable, drape::Run);
}
