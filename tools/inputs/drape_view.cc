// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/drape_view.h"

#include <cmath>

#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"

namespace drape {
namespace {

constexpr int kAngles = 360, kSupersample = 4;
constexpr double kFarthest = 1e6;  // [px] from the corner: what has flown off is no drape

// A coarse mesh may hang a little inside the support's circle.
constexpr double kSlack = 0.03;  // of the drape coefficient

constexpr double kLeastExtent = 8.0;  // [px]

Eigen::Vector2d Extent(const Eigen::Matrix2Xd& image_points) {
  return image_points.rowwise().maxCoeff() - image_points.rowwise().minCoeff();
}

bool IsInPicture(const Eigen::Matrix2Xd& image_points, const Camera& camera) {
  const Eigen::Array2d least = image_points.rowwise().minCoeff();
  const Eigen::Array2d most = image_points.rowwise().maxCoeff();
  return least.minCoeff() >= -0.5 && most.x() <= camera.width - 0.5 &&
         most.y() <= camera.height - 0.5;
}

// The area of the drape's vertical projection [m²], which a pinhole's silhouette is not.
double VerticalArea(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    const DrapeDiscs& discs, const GrayImage& silhouette) {
  if (camera.kind == CameraKind::kOrthographic) return CoverageArea(silhouette, camera);
  const Camera above = CameraAbove(discs);
  return CoverageArea(Rasterize(mesh, x, above, kSupersample), above);
}

}  // namespace

std::optional<DrapeView> ViewDrape(const ClothModel& model, const Eigen::VectorXd& x,
                                   const Camera& camera, const DrapeDiscs& discs,
                                   const GrayImage* image) {
  const Mesh& mesh = model.mesh;
  Eigen::Matrix2Xd image_points;
  if (!ProjectVertices(x, camera, &image_points)) return {};
  if (image_points.cwiseAbs().maxCoeff() > kFarthest) return {};
  DrapeView view;
  view.silhouette = Rasterize(mesh, x, camera, kSupersample);
  if (!IsInPicture(image_points, camera)) {
    view.fault = "not all in the picture";
  } else if (Extent(image_points).minCoeff() < kLeastExtent) {
    view.fault = "too small in the picture";
  } else if (HasDiscs(model, discs)) {
    const double coefficient =
        DrapeCoefficient(VerticalArea(mesh, x, camera, discs, view.silhouette), discs);
    if (coefficient > -kSlack && coefficient < 1.0 + kSlack) {
      view.drape_coefficient = coefficient;
    } else {
      view.fault = "tangled";
    }
  }
  if (!view.fault.empty()) return view;
  Outline fitted, measured;
  if (!OutlineFromMesh(mesh, x, camera, kAngles, &fitted)) return view;
  view.folds = CountFolds(VerticalProfile(fitted.radius, camera, discs));
  if (image != nullptr && OutlineFromImage(*image, camera, kAngles, &measured)) {
    view.metrics =
        CompareSilhouettes(*image, measured.radius, view.silhouette, fitted.radius, camera, discs);
  }
  return view;
}

}  // namespace drape
