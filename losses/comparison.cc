// SPDX-License-Identifier: Apache-2.0
#include "losses/comparison.h"

#include <cmath>

#include "losses/hausdorff.h"
#include "losses/metrics.h"
#include "losses/outline_match.h"
#include "losses/published_mesh.h"

namespace drape {

DrapeDistance DistanceOf(const SeenDrape& a, const SeenDrape& b) {
  return {
      .mse = MeanSquaredError(a.image, b.image),
      .iou = IntersectionOverUnion(a.image, b.image),
      .profile_rms = ProfileRms(a.radius, b.radius),
      .outline_hausdorff = HausdorffOfPolygons(ProfilePolygon(a.radius), ProfilePolygon(b.radius))};
}

Alignment AlignDrapes(const SeenDrape& a, const SeenDrape& b) {
  const OutlineMatch match = RefineRotation(
      a.radius, b.radius, MatchOutlines(a.radius, b.radius, OutlineFreedom::kRotationAndMirror));
  return {std::remainder(match.rotation, 2 * M_PI), match.mirrored};
}

DrapeComparison CompareDrapes(const SeenDrape& a, const SeenDrape& b, const Camera& camera) {
  DrapeComparison comparison{DistanceOf(a, b), {}, AlignDrapes(a, b)};
  const auto& [rotation, mirrored] = comparison.alignment;
  const GrayImage turned = TurnedImage(b.image, camera, rotation, mirrored);
  comparison.aligned = DistanceOf(a, SeeImage(turned, camera, "turned image"));
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
