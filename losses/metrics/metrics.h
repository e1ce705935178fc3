// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/metrics/distribution_metrics.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/shape_features.h"

namespace drape {

// The mean squared difference of the coverages of two images of equal size [MODEL, M50].
double MeanSquaredError(const GrayImage& a, const GrayImage& b);

// The intersection over union |A ∩ B| / |A ∪ B| of the pixels with coverage ≥ threshold; 1 when
// both are empty.
double IntersectionOverUnion(const GrayImage& a, const GrayImage& b, float threshold = 0.5f);

// The area Σ coverage / (px/m)² [m²], measured in the support plane.
double CoverageArea(const GrayImage& image, const Camera& camera);

// How a fitted drape compares with the image to which it was fitted, without rotation or flip.
struct SilhouetteMetrics {
  double mse = 0;
  double iou = 0;
  double profile_rms = 0;    // [px]
  double hausdorff = 0;      // of the outlines [m]
  double image_area_dc = 0;  // drape coefficient by the area of the coverage
  double fitted_area_dc = 0;
  ShapeFeatures image;  // from the profile
  ShapeFeatures fitted;
};

// image_radius and fitted_radius are complete profiles [px] of equal size K > 30; fitted_image is a
// raster of the fit, of the same size as the image.
SilhouetteMetrics CompareSilhouettes(const GrayImage& image, const Eigen::VectorXd& image_radius,
                                     const GrayImage& fitted_image,
                                     const Eigen::VectorXd& fitted_radius, const Camera& camera,
                                     const DrapeDiscs& discs);

// The form in which the reports of all programs write the quality of an image, a comparison, the
// stability of a drape and the score of a prediction. Keys contain the unit.
nlohmann::ordered_json QualityJson(const ImageQuality& quality);
nlohmann::ordered_json MetricsJson(const SilhouetteMetrics& metrics);
// lowest_eigenvalues: the result of LowestEigenvalues [s⁻²]; an empty one is written as nulls.
nlohmann::ordered_json StabilityJson(const Eigen::VectorXd& lowest_eigenvalues);
nlohmann::ordered_json ScoreJson(const DistributionScore& score);

}  // namespace drape
