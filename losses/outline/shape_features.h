// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "losses/camera/camera.h"

namespace drape {

// A peak of a profile r(θ_k), θ_k = 2πk/K, and the lowest place between it and the peak before.
struct Fold {
  int valley = 0, peak = 0;  // k
};

// The peaks with a prominence of at least min_prominence [m] after smoothing by a Gaussian of
// standard deviation 2° (use K ≥ 180: a spacing wider than 2° is not smoothed), counter-clockwise
// from the lowest place of the profile [m], shape [K].
std::vector<Fold> FindFolds(const Eigen::VectorXd& radius, double min_prominence);

// Features of one radial profile r(θ_k) [m], θ_k = 2πk/K, shape [K] [MODEL, M49]. They do not
// depend on the rotation of the drape.

// The drape coefficient DC = (A − πr²)/(πR² − πr²) of the area A [m²] of the drape's vertical
// projection, R and r the radii of specimen and support [BS 5058], [ISO 9073-9]: 0 for the support,
// 1 for the flat cloth. Laboratories give it in %.
double DrapeCoefficient(double area, const DrapeDiscs& discs);

// The area ½∫r²dθ [m²] by the trapezoidal rule, which is exact for a circle and spectrally accurate
// for smooth profiles.
double ProfileArea(const Eigen::VectorXd& radius);

// The number of peaks with a prominence of at least min_prominence [m] after smoothing by a
// Gaussian of standard deviation 2° (use K ≥ 180: a spacing wider than 2° is not smoothed).
int CountFolds(const Eigen::VectorXd& radius, double min_prominence = 2.5e-3);

// Amplitude a [m] and phase of mode k of the profile: a cos(kθ − phase).
std::complex<double> ComputeMode(const Eigen::VectorXd& radius, int k);

// ½ Σ a_k² [m²] over k = 2 | 3–5 | 6–9 | 10–15 with a_k the amplitude of cos/sin kθ: the
// contribution of each band to the variance of r. K > 30.
inline constexpr int kNumBands = 4;
std::array<double, kNumBands> BandEnergies(const Eigen::VectorXd& radius);

// 4πA/L² of the polygon: 1 for a circle, less for a folded outline.
double IsoperimetricRatio(const Eigen::VectorXd& radius);

struct ShapeFeatures {
  double drape_coefficient = 0;
  int folds = 0;
  std::array<double, kNumBands> band_energy = {};  // [m²]
  double radius_min = 0;                           // [m]
  double radius_max = 0;                           // [m]
  double isoperimetric_ratio = 0;
};
ShapeFeatures MeasureShape(const Eigen::VectorXd& radius, const DrapeDiscs& discs);

// The features as numbers, under these names: the band energies [m²], the radii [m].
inline constexpr int kNumShapeFeatures = 5 + kNumBands;
inline constexpr std::array<const char*, kNumShapeFeatures> kShapeFeatureNames = {
    "dc",         "folds",      "band_2",     "band_3_5",           "band_6_9",
    "band_10_15", "radius_min", "radius_max", "isoperimetric_ratio"};
using ShapeFeatureVector = Eigen::Matrix<double, kNumShapeFeatures, 1>;
ShapeFeatureVector ListShapeFeatures(const ShapeFeatures& features);
// ∂features/∂r, shape [kNumShapeFeatures, K]. The number of folds is constant between its jumps;
// the extreme radii are differentiable where one angle alone has them.
Eigen::Matrix<double, kNumShapeFeatures, Eigen::Dynamic> ShapeFeatureJacobian(
    const Eigen::VectorXd& radius, const DrapeDiscs& discs);

// Converts a profile from pixels to metres in the support plane.
inline Eigen::VectorXd MetresFromPixels(const Eigen::VectorXd& radius_px, const Camera& camera) {
  return radius_px / camera.pixels_per_metre();
}

// The vertices of the polygon of a profile, shape [2, K], y up, in the unit of r.
Eigen::Matrix2Xd ProfilePolygon(const Eigen::VectorXd& radius);

}  // namespace drape
