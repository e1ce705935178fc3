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

// The published images are 256 px wide; others are assumed to show the same area.
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

Observation MakeObservation(std::string name, std::string file, GrayImage image,
                            const ObservationOptions& options) {
  Observation observation;
  observation.name = std::move(name);
  observation.file = std::move(file);
  observation.image = std::move(image);
  observation.camera = CameraForImage(observation.image, options.camera);
  Outline outline;
  const bool measured =
      (options.centre == CentreMode::kNominal ||
       CentreOnOutline(observation.image, &observation.camera)) &&
      OutlineFromImage(observation.image, observation.camera, options.angles, &outline);
  if (!measured)
    throw InputError(observation.file,
                     "no closed outline around the support's centre, expected the "
                     "silhouette of a drape");
  observation.radius = outline.radius;
  return observation;
}

GrayImage SilhouetteOfMesh(const Capture& capture, CameraKind kind) {
  ObjSurface surface = ReadPublishedMesh(capture.mesh).surface;
  surface.x = TurnedAboutZ(surface.x, capture.mesh_quarters * M_PI / 2);
  Camera camera;
  camera.kind = kind;
  return ObserveSurface(surface, camera, capture.mesh).image;
}

}  // namespace

Observation ReadImageObservation(const std::string& file, const ObservationOptions& options) {
  return MakeObservation(std::filesystem::path(file).stem().string(), file, ReadSilhouette(file),
                         options);
}

Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   const ObservationOptions& options) {
  const std::string name = "sample_" + std::to_string(capture.sample) + "_capture_" +
                           std::to_string(capture.capture) + "_" + ClothFaceName(capture.face);
  if (source == ObservationSource::kMeshes)
    return MakeObservation(name, capture.mesh, SilhouetteOfMesh(capture, options.camera), options);
  return MakeObservation(name, capture.image, ReadSilhouette(capture.image), options);
}

}  // namespace drape
