// SPDX-License-Identifier: Apache-2.0
#include "tests/losses/camera/photo/photo_trial.h"

#include <cmath>
#include <memory>

#include "cuda/make_backend.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/raster.h"
#include "physics/cloth/start_shape.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/disc.h"
#include "tests/losses/camera/photo/photo_file.h"

namespace drape {
namespace {

constexpr int kAngles = 360;

// By the area of the vertical projection of the whole cloth.
double ComputeCoefficient(const Mesh& mesh, const Eigen::VectorXd& x) {
  constexpr int kSamples = 8;
  const Camera above;
  return DrapeCoefficient(CoverageArea(Rasterize(mesh, x, above, kSamples), above), {});
}

// The coefficient of an outline of which the mesh tells the heights: each point is moved to that of
// the hem that the camera sees there.
double CoefficientWithHeights(const Outline& image, const Outline& whole, const Outline& seen,
                              const Eigen::VectorXd& x, const Camera& camera) {
  constexpr double kHidden = 1.5;  // [px]
  double area = 0.0;
  Eigen::Vector2d first, last;
  for (int k = 0; k < kAngles; ++k) {
    const OutlineHit& hit = seen.hits[k];
    // Where the support hides the hem, its rim is seen.
    const bool hidden = whole.radius[k] > seen.radius[k] + kHidden;
    const double z = hidden ? 0.0 : 0.5 * (x[3 * hit.vertex[0] + 2] + x[3 * hit.vertex[1] + 2]);
    const Vec2 ray = RayDirection(k, kAngles);
    const Eigen::Vector2d point = camera.WorldFromImage(
        {camera.cx + image.radius[k] * ray.x, camera.cy - image.radius[k] * ray.y}, z);
    if (k == 0) {
      first = point;
    } else {
      area += 0.5 * (last.x() * point.y() - last.y() * point.x());
    }
    last = point;
  }
  area += 0.5 * (last.x() * first.y() - last.y() * first.x());
  return DrapeCoefficient(area, {});
}

}  // namespace

KnownDrape SimulateDrape(const std::string& fabric, int seed) {
  Material material =
      ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + fabric + ".json",
                   {NegativeEntries::kRaise});
  RaiseSmallEntries(material.field, 0.1);
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 700}), CusickScene(),
                                                  MakeLaw("smooth"));
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support, RandomStartShape(seed, 3e-3));
  const RolloutInput input{&material.field, &start};
  const auto backend = MakeBackend("cpu", model, 1);
  const RolloutResult drape = backend->Rollouts({&input, 1}, {.h = 0.05, .steps = 60}, nullptr)[0];
  return {fabric, model->mesh, drape.end.x, ComputeCoefficient(model->mesh, drape.end.x)};
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
  Outline image, whole, seen;
  if (!OutlineFromImage(trial.result.silhouette, camera, kAngles, &image) ||
      !OutlineFromImage(Rasterize(drape.mesh, drape.x, camera, 4), camera, kAngles, &whole) ||
      !OutlineFromMesh(drape.mesh, drape.x, camera, kAngles, &seen))
    return trial;
  trial.outline_rms = ProfileRms(image.radius, whole.radius);
  trial.outline_bias = (image.radius - whole.radius).mean();
  trial.outline_rms_mm = 1e3 * trial.outline_rms / camera.pixels_per_metre();
  trial.error_with_heights =
      100 * (CoefficientWithHeights(image, whole, seen, drape.x, camera) - drape.coefficient);
  trial.error_of_estimate = 100 * (trial.result.shape.drape_coefficient - drape.coefficient);
  trial.error_of_plane = 100 * (trial.result.plane_coefficient - drape.coefficient);
  trial.height_error = camera.eye_height / scene.eye.z() - 1;
  trial.tilt_error = trial.result.tilt - scene.tilt.norm();
  return trial;
}

}  // namespace drape
