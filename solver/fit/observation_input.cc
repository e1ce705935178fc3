// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation_input.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "losses/dataset/published_mesh.h"
#include "losses/metrics/observed_drape.h"
#include "losses/outline/centre.h"
#include "losses/outline/outline.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

// The published images are 256 px wide; others are taken to show as much.
Camera CameraForImage(const GrayImage& image, CameraKind kind) {
  Camera camera;
  camera.kind = kind;
  camera.scale *= double(image.width) / camera.width;
  camera.width = image.width;
  camera.height = image.height;
  camera.cx = 0.5 * (image.width - 1);
  camera.cy = 0.5 * (image.height - 1);
  return camera;
}

Observation Measured(std::string name, std::string file, GrayImage image,
                     const ObservationOptions& options) {
  Observation target;
  target.name = std::move(name);
  target.file = std::move(file);
  target.image = std::move(image);
  target.camera = CameraForImage(target.image, options.camera);
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
  return ObserveSurface(surface, camera, capture.mesh).image;
}

}  // namespace

CentreMode ParseCentreMode(const std::string& text) {
  if (text == "nominal") return CentreMode::kNominal;
  if (text == "outline") return CentreMode::kOutline;
  throw InputError("centre", "unknown name '" + text + "', expected nominal or outline");
}

ObservationSource ParseObservationSource(const std::string& text) {
  for (const ObservationSource source :
       {ObservationSource::kSilhouettes, ObservationSource::kMeshes})
    if (text == ToString(source)) return source;
  throw InputError("data_source", "unknown name '" + text + "', expected silhouettes or meshes");
}

const char* ToString(ObservationSource source) {
  return source == ObservationSource::kMeshes ? "meshes" : "silhouettes";
}

Observation ReadImageObservation(const std::string& file, const ObservationOptions& options) {
  return Measured(std::filesystem::path(file).stem().string(), file, ReadSilhouette(file), options);
}

Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   const ObservationOptions& options) {
  const std::string name = "sample_" + std::to_string(capture.sample) + "_capture_" +
                           std::to_string(capture.capture) + "_" + ClothFaceName(capture.face);
  if (source == ObservationSource::kMeshes)
    return Measured(name, capture.mesh, SilhouetteOfMesh(capture, options.camera), options);
  return Measured(name, capture.image, ReadSilhouette(capture.image), options);
}

}  // namespace drape
