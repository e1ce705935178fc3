// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/comparison.h"

#include <glog/logging.h>

#include <cmath>

#include "losses/camera/camera.h"
#include "losses/metrics/hausdorff.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"

namespace drape {

DrapeDistance ComputeDistance(const ObservedDrape& a, const ObservedDrape& b) {
  CHECK(a.discs == b.discs) << ToString(a.discs) << ", " << ToString(b.discs);
  return {
      .mse = MeanSquaredError(a.image, b.image),
      .iou = IntersectionOverUnion(a.image, b.image),
      .profile_rms = ProfileRms(a.radius, b.radius),
      .outline_hausdorff = HausdorffOfPolygons(ProfilePolygon(a.radius), ProfilePolygon(b.radius))};
}

Alignment AlignDrapes(const ObservedDrape& a, const ObservedDrape& b) {
  const OutlineMatch match = RefineRotation(
      a.radius, b.radius, MatchOutlines(a.radius, b.radius, OutlineFreedom::kRotationAndMirror));
  return {std::remainder(match.rotation, 2 * M_PI), match.mirrored};
}

DrapeComparison CompareDrapes(const ObservedDrape& a, const ObservedDrape& b,
                              const Camera& camera) {
  DrapeComparison comparison{ComputeDistance(a, b), {}, AlignDrapes(a, b)};
  const auto& [rotation, mirrored] = comparison.alignment;
  const GrayImage turned = TurnedImage(b.image, camera, rotation, mirrored);
  comparison.aligned = ComputeDistance(a, ObserveImage(turned, camera, b.discs, "turned image"));
  return comparison;
}

SurfaceDistance CompareSurfaces(const ObjSurface& a, const ObjSurface& b,
                                const Alignment& alignment, const std::string& where,
                                double tolerance) {
  const ObjSurface turned{TurnedAboutZ(b.x, alignment.rotation, alignment.mirrored), b.triangles};
  return {HausdorffOfSurfaces(a, b, where, tolerance),
          HausdorffOfSurfaces(a, turned, where, tolerance)};
}

}  // namespace drape
