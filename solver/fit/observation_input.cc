// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation_input.h"

#include <glog/logging.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "losses/dataset/published_mesh.h"
#include "losses/metrics/observed_drape.h"
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
