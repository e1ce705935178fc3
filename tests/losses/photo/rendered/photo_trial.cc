// SPDX-License-Identifier: Apache-2.0
#include "tests/losses/photo/rendered/photo_trial.h"

#include <cmath>
#include <memory>

#include "cuda/make_backend.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/photo/camera_pose.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/disc.h"
#include "tests/losses/photo/rendered/photo_file.h"

namespace drape {
namespace {

constexpr int kAngles = 360;

// The vertices moved so that the camera that was found sees them where the true one did. An
// orthographic camera has no place that could be wrong.
Eigen::VectorXd AsSeen(const PhotoScene& scene, const PhotoResult& found,
                       const Eigen::VectorXd& x) {
  if (found.camera.kind == CameraKind::kOrthographic) return x;
  PhotoPose actual, found_pose;
  actual.tilt = scene.tilt;
  found_pose.tilt = found.tilt;
  const double focal = scene.focal_35mm * std::hypot(scene.width, scene.height) / 43.2666;
  const double zoom = focal / found.focal;
  const Eigen::Matrix3d turn = found_pose.WorldFromCamera() *
                               Eigen::Vector3d(zoom, zoom, 1).asDiagonal() *
                               actual.WorldFromCamera().transpose();
  const Eigen::Vector3d eye(found.camera.eye_x, found.camera.eye_y, found.camera.eye_height);
  Eigen::VectorXd moved(x.size());
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    moved.segment<3>(i) = eye + turn * (x.segment<3>(i) - scene.eye);
  return moved;
}

double EstimateCoefficient(const Outline& outline, const Camera& camera) {
  return MeasureShape(VerticalProfile(outline.radius, camera, {}), {}).drape_coefficient;
}

}  // namespace

double ComputeCoefficient(const Mesh& mesh, const Eigen::VectorXd& x) {
  constexpr int kSamples = 8;
  const Camera above;
  return DrapeCoefficient(CoverageArea(Rasterize(mesh, x, above, kSamples), above), {});
}

KnownDrape SimulateDrape(const std::string& fabric, int seed) {
  Material material =
      ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + fabric + ".json",
                   {.min_relative_stiffness = 0.1});
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 700}), CusickScene(),
                                                  MakeLaw("smooth"));
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support, RandomStartShape(seed, 3e-3));
  const RolloutInput input{&material.field, &start};
  const auto backend = MakeBackend("cpu", model, 1);
  const RolloutResult drape = backend->Rollouts({&input, 1}, {.h = 0.05, .steps = 60}, nullptr)[0];
  return {fabric, model->mesh, drape.end.x, ComputeCoefficient(model->mesh, drape.end.x)};
}

const KnownDrape& Wool() {
  static const KnownDrape drape = SimulateDrape("synthetic_wool", 1);
  return drape;
}

KnownDrape SimulateDrapeOfSix(unsigned number) {
  constexpr struct {
    const char* fabric;
    int seed;
  } kDrapes[kNumDrapes] = {{"synthetic_knit", 3},  {"cotton_white", 5}, {"synthetic_wool", 1},
                           {"synthetic_shirt", 2}, {"wool_red", 6},     {"cotton_pink", 4}};
  return SimulateDrape(kDrapes[number].fabric, kDrapes[number].seed);
}

PhotoTrial TryPhoto(const PhotoScene& scene, const KnownDrape& drape, const PhotoOptions& options,
                    const std::string& folder) {
  const std::string path = folder + "/photo.jpg";
  WritePhotoFile(scene, RenderPhoto(scene, {{&drape.mesh, drape.x, {0, 0}}}), path);
  PhotoTrial trial;
  trial.result = MeasurePhoto(ReadPhotograph(path), options);
  if (trial.result.fault != PhotoFault::kNone) return trial;
  const Camera& camera = trial.result.camera;
  const auto outline_of_mesh = [&](const Eigen::VectorXd& x, Outline* outline) {
    return OutlineFromImage(Rasterize(drape.mesh, x, camera, 4), camera, kAngles, outline);
  };
  Outline image, whole, seen;
  if (!OutlineFromImage(trial.result.silhouette, camera, kAngles, &image) ||
      !outline_of_mesh(drape.x, &whole) ||
      !outline_of_mesh(AsSeen(scene, trial.result, drape.x), &seen))
    return trial;
  trial.outline_rms = ProfileRms(image.radius, whole.radius);
  trial.outline_bias = (image.radius - seen.radius).mean();
  trial.outline_rms_mm = 1e3 * trial.outline_rms / camera.pixels_per_metre();
  const double by_seen = EstimateCoefficient(seen, camera),
               by_whole = EstimateCoefficient(whole, camera);
  trial.error_by_outline = 100 * (trial.result.shape.drape_coefficient - by_seen);
  trial.error_by_camera = 100 * (by_seen - by_whole);
  trial.error_by_heights = 100 * (by_whole - drape.coefficient);
  trial.error_of_estimate = 100 * (trial.result.shape.drape_coefficient - drape.coefficient);
  trial.error_of_plane = 100 * (trial.result.plane_coefficient - drape.coefficient);
  trial.height_error = camera.eye_height / scene.eye.z() - 1;
  trial.tilt_error = trial.result.tilt.norm() - scene.tilt.norm();
  return trial;
}

}  // namespace drape
