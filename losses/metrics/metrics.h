// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/shape_features.h"

namespace drape {

// Mean squared difference of the coverages of two images of equal size.
double MeanSquaredError(const GrayImage& a, const GrayImage& b);

// |A ∩ B| / |A ∪ B| of the pixels with coverage ≥ threshold; 1 when both are empty.
double IntersectionOverUnion(const GrayImage& a, const GrayImage& b, float threshold = 0.5f);

// Σ coverage / (px/m)² [m²], measured in the support plane.
double CoverageArea(const GrayImage& image, const Camera& camera);

// How a fitted drape compares with the image that it was fitted to (raw: neither rotated nor
// flipped).
struct SilhouetteMetrics {
  double mse = 0;
  double iou = 0;
  double profile_rms = 0;    // [px]
  double hausdorff = 0;      // of the outlines [m]
  double image_area_dc = 0;  // drape coefficient by the area of the coverage
  double fitted_area_dc = 0;
  ShapeFeatures image;  // by the profile
  ShapeFeatures fitted;
};

// image_radius, fitted_radius: complete profiles [px] of equal size K > 30; fitted_image: a raster
// of the fit, of the image's size.
SilhouetteMetrics CompareSilhouettes(const GrayImage& image, const Eigen::VectorXd& image_radius,
                                     const GrayImage& fitted_image,
                                     const Eigen::VectorXd& fitted_radius, const Camera& camera);

}  // namespace drape
