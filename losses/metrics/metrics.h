// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "physics/mesh/obj_io.h"

namespace drape {

inline constexpr int kObservedAngles = 360;

// A drape as a camera sees it: the input of all metrics of drapes and of their distributions.
struct ObservedDrape {
  GrayImage image;
  Eigen::VectorXd radius;  // r(θ) of the outline [m], shape [kObservedAngles] (VerticalProfile)
  ShapeFeatures shape;     // of that profile
  DrapeDiscs discs;
};

// Observes an image of the size of the camera, or the image of a surface. Throws InputError (prefix
// `where`) when the sizes differ, the surface is not in front of the camera, or the outline has
// gaps.
ObservedDrape ObserveImage(const GrayImage& image, const Camera& camera, const DrapeDiscs& discs,
                           const std::string& where);
ObservedDrape ObserveSurface(const ObjSurface& surface, const Camera& camera,
                             const DrapeDiscs& discs, const std::string& where);

// Observes a flat disc of that radius [m] about the camera centre, as a drape of the discs.
ObservedDrape ObserveDisc(double radius, const Camera& camera, const DrapeDiscs& discs);

// Returns the image mirrored (y → −y) if requested and then turned counter-clockwise about the
// camera centre by `rotation` [rad]; bilinear between pixels, white outside the image.
GrayImage TurnedImage(const GrayImage& image, const Camera& camera, double rotation, bool mirrored);

// Returns the image moved so that the centre of camera `from` is at the centre of `to`; bilinear
// between pixels, white outside the image.
GrayImage MovedImage(const GrayImage& image, const Camera& from, const Camera& to);

// The pixel-wise mean of at least one image; all images have equal sizes.
class MeanImage {
 public:
  void Add(const GrayImage& image);
  GrayImage Mean() const;

 private:
  GrayImage first_;  // for its size
  Eigen::VectorXd sum_;
  int count_ = 0;
};

// How well a predicted distribution of drapes predicts held-out drapes [MODEL, M51].

// The rotation-invariant features that are scored, in this order.
inline constexpr int kNumFeatures = 2 + kNumBands;
inline constexpr std::array<const char*, kNumFeatures> kFeatureNames = {
    "dc", "folds", "band_2", "band_3_5", "band_6_9", "band_10_15"};
using FeatureVector = Eigen::Matrix<double, kNumFeatures, 1>;
FeatureVector ComputeFeatures(const ShapeFeatures& shape);  // bands in m²
// The features of several drapes, shape [kNumFeatures, drapes].
Eigen::MatrixXd ComputeFeatures(const std::vector<const ObservedDrape*>& drapes);

// The scale of each feature in the energy score: the scatter between samples of one fabric and
// face, pooled over fabrics 1–5 (240 images), so that the scores of different fabrics are
// comparable.
inline const FeatureVector kFeatureScales{0.027, 0.8, 4.9e-6, 9.7e-6, 1.1e-5, 5.5e-6};

// The fraction of observations inside central intervals, and the mean width of these.
struct IntervalSkill {
  double nominal = 0;  // the probability that the samples can reach (ComputeInterval)
  double coverage = 0;
  double width = 0;
};

struct FeatureScore {
  double observed_mean = 0;
  double predicted_mean = 0, predicted_sd = 0;
  double crps = 0;
  IntervalSkill half, ninety;  // intervals of 50 % and 90 %
};

// Scores as means over all observed drapes.
struct DistributionScore {
  int observed = 0;
  double mean_image_mse = 0;  // of the predictive mean image; NaN of features alone
  std::array<FeatureScore, kNumFeatures> features = {};
  double feature_energy = 0;  // energy score of the features, each divided by its scale
  // The energy score of the outlines r(θ) without alignment, by their root mean square distance
  // [m]. They are not aligned because a score by a distance that is minimised over rotations need
  // not favour the true distribution. NaN of features alone.
  double outline_energy = 0;
};

// Accumulates predictions, each of them an ensemble of at least two drapes, and the drapes observed
// for them.
class DistributionScorer {
 public:
  using Drapes = std::vector<const ObservedDrape*>;

  explicit DistributionScorer(const FeatureVector& scales = kFeatureScales) : scales_(scales) {}

  void Add(const Drapes& samples, const Drapes& observed);
  // A prediction of features alone, shapes [kNumFeatures, ≥ 2] and [kNumFeatures, observed]; then
  // the score is of features alone.
  void AddFeatures(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);
  DistributionScore Score() const;  // CHECKs that a drape was observed

 private:
  void SumFeatures(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);
  void AddFeature(int feature, const Eigen::VectorXd& samples, double observed);

  FeatureVector scales_;
  DistributionScore sum_;
  bool features_alone_ = false;
};

// How well an ensemble of samples from a predicted distribution predicts an observation
// [MODEL, M51]. A lower score is better, and its expectation is smallest for the true distribution.
// Both scores are the fair versions [Ferro 2014], so that ensembles of different sizes are
// comparable.

// The continuous ranked probability score, in the unit of the numbers: mean |X_i − y| − Σ_{i<j}
// |X_i − X_j| / (m(m−1)) over m ≥ 2 samples.
double EnsembleCrps(std::vector<double> samples, double observed);

// The energy score, which is the same for vectors with Euclidean distances
// [Gneiting 2007, section 4.3], for each column of `observed`, shape [d, n]. samples: shape [d, m],
// m ≥ 2.
Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);

// The mean and standard deviation of values.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;  // n − 1; 0 for one value
};
Spread SpreadOfValues(const std::vector<double>& values);

// The central interval by the quantiles at ranks p(m+1). Another sample of the same distribution
// lies in it with exactly the probability `nominal`, which is the requested one, or (m−1)/(m+1)
// when the samples are too few to reach it. m ≥ 2, 0 < probability < 1.
struct CentralInterval {
  double low = 0, high = 0;
  double nominal = 0;

  bool Contains(double value) const { return low <= value && value <= high; }
};
CentralInterval ComputeInterval(std::vector<double> samples, double probability);

// The distances of two drapes, without alignment [MODEL, M50].
struct DrapeDistance {
  double mse = 0;  // mean squared error of the coverages
  double iou = 0;
  double profile_rms = 0;        // [m]
  double outline_hausdorff = 0;  // [m]
};

// The motion of the second drape that best aligns its outline with the first outline: mirrored (y →
// −y) if `mirrored`, then turned counter-clockwise about the camera centre by `rotation` [rad].
struct Alignment {
  double rotation = 0;  // in [−π, π]
  bool mirrored = false;
};

struct DrapeComparison {
  DrapeDistance raw;
  DrapeDistance aligned;  // after the alignment of the second image
  Alignment alignment;
};

// The two drapes must be of the same discs and seen by the same camera.
DrapeDistance ComputeDistance(const ObservedDrape& a, const ObservedDrape& b);

DrapeComparison CompareDrapes(const ObservedDrape& a, const ObservedDrape& b, const Camera& camera);

// The symmetric Hausdorff distance of two closed polygons (their curves, not their areas), shape
// [2, N] and [2, M], in the unit of the points. It is taken over all points of the curves, not only
// the vertices, and is exact to `tolerance`.
double HausdorffOfPolygons(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b,
                           double tolerance = 1e-7);

// The symmetric Hausdorff distance [m] of two sets of triangles, to within `tolerance` [m] (CGAL).
// The sets are cut apart where they are no manifold; triangles of zero area and vertices without a
// triangle are ignored. Throws InputError (prefix `where`) when a coordinate is not finite and when
// nothing is left.
double HausdorffOfSurfaces(const ObjSurface& a, const ObjSurface& b, const std::string& where,
                           double tolerance = 1e-4);

// The symmetric Hausdorff distances of two surfaces to within `tolerance` [m] (CGAL), with the
// second surface unmoved and after `alignment`. Throws InputError (prefix `where`) for a position
// that is not finite.
struct SurfaceDistance {
  double raw = 0;      // [m]
  double aligned = 0;  // [m]
};
SurfaceDistance CompareSurfaces(const ObjSurface& a, const ObjSurface& b,
                                const Alignment& alignment, const std::string& where,
                                double tolerance = 1e-4);

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
