// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "losses/silhouette/silhouette.h"
#include "physics/util/errors.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

constexpr double kDegree = M_PI / 180;

// A drape without a mirror symmetry.
ObjSurface Surface() {
  const Mesh disc = MakeDisc(6, 240, 0.15);
  ObjSurface surface{Deform(disc, {.folds = 6, .amplitude = 0.1}), ListTriangles(disc)};
  for (Eigen::Index i = 0; i < surface.x.size(); i += 3) {
    const double angle = std::atan2(surface.x[i + 1], surface.x[i]);
    const double factor = 1 + 0.05 * std::cos(2 * angle) + 0.03 * std::sin(3 * angle - 0.5);
    surface.x.segment<2>(i) *= factor;
  }
  return surface;
}

ObjSurface Moved(double rotation, bool mirrored) {
  ObjSurface surface = Surface();
  surface.x = TurnedAboutZ(surface.x, rotation, mirrored);
  return surface;
}

TEST(ObserveSurface, IsObserveImageOfItsRaster) {
  const ObservedDrape seen = ObserveSurface(Surface(), Camera(), {}, "s");
  EXPECT_EQ(seen.image.coverage, Rasterize(Surface(), Camera(), 4).coverage);
  EXPECT_EQ(seen.radius, ObserveImage(seen.image, Camera(), {}, "i").radius);
  EXPECT_EQ(seen.shape.folds, 6);
}

TEST(ObserveDisc, HasTheAreaOfTheCircle) {
  const ObservedDrape disc = ObserveDisc(0.12, Camera(), {});
  EXPECT_NEAR(CoverageArea(disc.image, Camera()), M_PI * 0.12 * 0.12, 1e-5);
  EXPECT_NEAR((disc.radius.array() - 0.12).abs().maxCoeff(), 0, 3e-4);
}

TEST(ObserveImage, RejectsAnotherSizeAndGaps) {
  EXPECT_THROW(ObserveImage(GrayImage(128, 256), Camera(), {}, "i"), InputError);
  EXPECT_THROW(ObserveImage(GrayImage(256, 256), Camera(), {}, "i"), InputError);
  ObjSurface flown = Surface();
  flown.x[0] = 1e9;
  EXPECT_THROW(ObserveSurface(flown, Camera(), {}, "s"), InputError);
}

TEST(TurnedImage, IsTheImageOfTheTurnedSurface) {
  for (const bool mirrored : {false, true}) {
    const double turn = 37.3 * kDegree;
    const GrayImage turned =
        TurnedImage(ObserveSurface(Surface(), Camera(), {}, "s").image, Camera(), turn, mirrored);
    const GrayImage expected = ObserveSurface(Moved(turn, mirrored), Camera(), {}, "s").image;
    EXPECT_LT(MeanSquaredError(turned, expected), 3e-4);
    EXPECT_GT(IntersectionOverUnion(turned, expected), 0.995);
  }
}

TEST(CompareDrapes, FindsRotationAndFlip) {
  const Camera camera;
  const ObservedDrape here = ObserveSurface(Surface(), camera, {}, "a");
  for (const bool mirrored : {false, true}) {
    for (const double degrees : {0.0, 37.3, 200.6}) {
      const ObservedDrape there =
          ObserveSurface(Moved(degrees * kDegree, mirrored), camera, {}, "b");
      const DrapeComparison c = CompareDrapes(here, there, camera);
      // The rotation is undone by −φ; that of a mirrored drape by φ, since the mirror reverses it.
      const double expected = (mirrored ? degrees : -degrees) * kDegree;
      EXPECT_EQ(c.alignment.mirrored, mirrored);
      EXPECT_NEAR(std::remainder(c.alignment.rotation - expected, 2 * M_PI), 0, 0.05 * kDegree);
      EXPECT_LT(c.aligned.mse, 4e-4);
      EXPECT_LT(c.aligned.outline_hausdorff, 8e-4);
      if (degrees == 0 && !mirrored) continue;
      EXPECT_GT(c.raw.mse, 0.01);
      EXPECT_LT(c.raw.iou, 0.97);
      EXPECT_GT(c.raw.outline_hausdorff, 5e-3);
      EXPECT_GT(c.raw.profile_rms, 5 * c.aligned.profile_rms);
    }
  }
}

TEST(CompareSurfaces, RawAndAligned) {
  const ObjSurface turned = Moved(40 * kDegree, true);
  const SurfaceDistance d =
      CompareSurfaces(Surface(), turned, {40 * kDegree, true}, "meshes", 2e-4);
  EXPECT_GT(d.raw, 5e-3);
  EXPECT_LT(d.aligned, 3e-4);
}

}  // namespace
}  // namespace drape
