// SPDX-License-Identifier: Apache-2.0
#include "solver/target_input.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "losses/centre.h"
#include "losses/outline.h"
#include "losses/published_mesh.h"
#include "losses/seen_drape.h"
#include "physics/errors.h"

namespace drape {
namespace {

// The published images are 256 px wide; others are taken to show as much.
Camera CameraOf(const GrayImage& image, CameraKind kind) {
  Camera camera;
  camera.kind = kind;
  camera.scale *= double(image.width) / camera.width;
  camera.width = image.width;
  camera.height = image.height;
  camera.cx = 0.5 * (image.width - 1);
  camera.cy = 0.5 * (image.height - 1);
  return camera;
}

Target Measured(std::string name, std::string file, GrayImage image, const TargetOptions& options) {
  Target target;
  target.name = std::move(name);
  target.file = std::move(file);
  target.image = std::move(image);
  target.camera = CameraOf(target.image, options.camera);
  Outline outline;
  const bool measured =
      (options.centre == CentreMode::kNominal || CentreOnOutline(target.image, &target.camera)) &&
      OutlineFromImage(target.image, target.camera, options.angles, &outline);
  if (!measured)
    throw InputError(target.file,
                     "no closed outline around the support's centre, expected the "
                     "silhouette of a drape");
  target.radius = outline.radius;
  return target;
}

GrayImage SilhouetteOfMesh(const Capture& capture, CameraKind kind) {
  ObjSurface surface = ReadPublishedMesh(capture.mesh).surface;
  surface.x = TurnedAboutZ(surface.x, capture.mesh_quarters * M_PI / 2);
  Camera camera;
  camera.kind = kind;
  return SeeSurface(surface, camera, capture.mesh).image;
}

}  // namespace

CentreMode ParseCentreMode(const std::string& text) {
  if (text == "nominal") return CentreMode::kNominal;
  if (text == "outline") return CentreMode::kOutline;
  throw InputError("centre", "unknown name '" + text + "', expected nominal or outline");
}

TargetSource ParseTargetSource(const std::string& text) {
  for (const TargetSource source : {TargetSource::kSilhouettes, TargetSource::kMeshes})
    if (text == ToString(source)) return source;
  throw InputError("targets", "unknown name '" + text + "', expected silhouettes or meshes");
}

const char* ToString(TargetSource source) {
  return source == TargetSource::kMeshes ? "meshes" : "silhouettes";
}

Target ReadImageTarget(const std::string& file, const TargetOptions& options) {
  return Measured(std::filesystem::path(file).stem().string(), file, ReadSilhouette(file), options);
}

Target ReadCaptureTarget(const Capture& capture, TargetSource source,
                         const TargetOptions& options) {
  const std::string name = "sample_" + std::to_string(capture.sample) + "_capture_" +
                           std::to_string(capture.capture) + "_" + ClothFaceName(capture.face);
  if (source == TargetSource::kMeshes)
    return Measured(name, capture.mesh, SilhouetteOfMesh(capture, options.camera), options);
  return Measured(name, capture.image, ReadSilhouette(capture.image), options);
}

}  // namespace drape
