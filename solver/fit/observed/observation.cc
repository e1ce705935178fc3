// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/observation.h"

#include <glog/logging.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <utility>

#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/readout/outline_readouts.h"

namespace drape {
namespace {

constexpr int kUp = 90, kCircle = 360;  // [degrees]

// Lays the cloth to the outline: with the warp along that of the image, or up, and of the four ways
// to do so with its longer radii at the larger angles.
void ChoosePose(int angles, Observation& observation) {
  const Eigen::VectorXd angle = Eigen::VectorXd::LinSpaced(angles, 0.0, 1.0);
  const auto lay = [&](const ClothPose& pose) {
    observation.pose = pose;
    observation.radius = observation.MeasureRadius(angles).value();  // MeasureImage found it closed
    return angle.dot(observation.radius);
  };
  std::map<double, ClothPose> by_score;
  const int turn = observation.warp.value_or(kUp) - kUp;
  for (const int degrees : {turn, turn + kCircle / 2})
    for (const bool mirrored : {false, true})
      by_score.emplace(lay({degrees, mirrored}), ClothPose{degrees, mirrored});
  lay(by_score.rbegin()->second);
}

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
  std::string warp = options.warp;
  if (warp == kUnknownWarp && options.camera.gives_camera()) warp = ReadWarp(camera_file);
  observation.warp = ParseWarp(warp);
  ChoosePose(options.angles, observation);
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
  const Eigen::Vector3d x = InImage(Eigen::Vector3d::UnitX()),
                        y = InImage(Eigen::Vector3d::UnitY()), eye(camera.eye_x, camera.eye_y, 0.0);
  scaled.eye_x = x.dot(eye);
  scaled.eye_y = y.dot(eye);
  return scaled;
}

std::shared_ptr<const Experiment> Observation::Measured(double sigma_px) const {
  if (experiment != nullptr) return experiment;
  const Camera above = outline_camera();
  const auto angles = static_cast<int>(radius.size());
  const auto readout = [above, angles](const ClothModel& model) {
    return std::make_shared<OutlineReadout>(model.mesh, above, angles);
  };
  const auto start = [above, profile = radius, discs = discs](const ClothModel& model,
                                                              double lift) {
    return FlapsFromOutline(model.mesh, SupportRadius(model.scene).value(),
                            VerticalProfile(profile, above, discs), lift);
  };
  return std::make_shared<const Experiment>(
      Experiment{.name = name,
                 .mesh = {},
                 .scene = {},
                 .measurements = {{.name = "outline of " + file,
                                   .readout = readout,
                                   .data = radius,
                                   .sigma = sigma_px,
                                   .is_contour = true}},
                 .start_at = start});
}

Observation Observation::Mirrored() const {
  Observation mirrored = *this;
  mirrored.pose.mirrored = !pose.mirrored;
  mirrored.radius.tail(radius.size() - 1) = radius.tail(radius.size() - 1).reverse();
  return mirrored;
}

std::optional<Eigen::VectorXd> Observation::MeasureRadius(int angles) const {
  Outline outline;
  const int rays = std::lcm(angles, kCircle);  // some of which are at the cloth's angles
  if (!OutlineFromImage(image, camera, rays, &outline)) return std::nullopt;
  Eigen::VectorXd radius(angles);
  for (int k = 0; k < angles; ++k) {
    const int ray = (pose.mirrored ? -k : k) * (rays / angles) + pose.degrees * (rays / kCircle);
    radius[k] = outline.radius[(ray % rays + rays) % rays];
  }
  return radius * (outline_camera().pixels_per_metre() / camera.pixels_per_metre());
}

Observation ReadImageObservation(const std::string& file, const ObservationOptions& options) {
  return MakeObservation(std::filesystem::path(file).stem().string(), file, ReadSilhouette(file),
                         options);
}

Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   ObservationOptions options) {
  if (options.warp == kUnknownWarp) options.warp = "up";
  const std::string name = "sample_" + std::to_string(capture.sample) + "_capture_" +
                           std::to_string(capture.capture) + "_" + ClothFaceName(capture.face);
  if (source == ObservationSource::kMeshes)
    return MakeObservation(name, capture.mesh, SilhouetteOfMesh(capture, options.camera.kind),
                           options);
  return MakeObservation(name, capture.image, ReadSilhouette(capture.image), options);
}

}  // namespace drape
