// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation.h"

#include <glog/logging.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"

namespace drape {
namespace {

Observation MakeObservation(std::string name, std::string file, Silhouette silhouette,
                            const ObservationOptions& options) {
  const std::string camera_file = options.camera.FileFor(file);
  const DrapeDiscs discs = FindDiscs(options.discs, {file, camera_file});
  MeasuredImage measured =
      MeasureImage(std::move(silhouette), options.camera, options.centre, discs, file);
  Observation observation{.name = std::move(name),
                          .file = std::move(file),
                          .image = std::move(measured.image),
                          .camera = measured.camera,
                          .radius = {},
                          .discs = discs,
                          .quality = std::move(measured.quality),
                          .photograph = {}};
  if (options.camera.gives_camera()) observation.photograph = ReadPhotographNotes(camera_file);
  const auto radius = observation.MeasureRadius(options.angles);
  CHECK(radius.has_value());  // MeasureImage found a closed outline
  observation.radius = *radius;
  return observation;
}

Silhouette SilhouetteOfMesh(const Capture& capture, CameraKind kind) {
  ObjSurface surface = ReadPublishedMesh(capture.mesh).surface;
  surface.x = TurnedAboutZ(surface.x, capture.mesh_quarters * M_PI / 2);
  Camera camera;
  camera.kind = kind;
  return {ObserveSurface(surface, camera, DrapeDiscs(), capture.mesh).image, {}};
}

}  // namespace

Camera Observation::outline_camera() const {
  Camera scaled = camera;
  const Camera published;
  if (camera.kind == CameraKind::kOrthographic) {
    scaled.scale = published.scale;
  } else if (camera.width != published.width || camera.height != published.height) {
    const double longer = published.scale / camera.pixels_per_metre();  // the published pinhole
    scaled.field_of_view = 2 * std::atan(std::tan(0.5 * camera.field_of_view) / longer);
  }
  return scaled;
}

std::optional<Eigen::VectorXd> Observation::MeasureRadius(int angles) const {
  Outline outline;
  if (!OutlineFromImage(image, camera, angles, &outline)) return std::nullopt;
  return outline.radius * (outline_camera().pixels_per_metre() / camera.pixels_per_metre());
}

Observation ReadImageObservation(const std::string& file, const ObservationOptions& options) {
  return MakeObservation(std::filesystem::path(file).stem().string(), file, ReadSilhouette(file),
                         options);
}

Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   const ObservationOptions& options) {
  const std::string name = "sample_" + std::to_string(capture.sample) + "_capture_" +
                           std::to_string(capture.capture) + "_" + ClothFaceName(capture.face);
  if (source == ObservationSource::kMeshes)
    return MakeObservation(name, capture.mesh, SilhouetteOfMesh(capture, options.camera.kind),
                           options);
  return MakeObservation(name, capture.image, ReadSilhouette(capture.image), options);
}

}  // namespace drape
