// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/util/options/field.h"

namespace drape {

// The segment of the projected hem between two vertices through which the ray of one angle leaves.
struct OutlineHit {
  int vertex[2] = {-1, -1};  // −1: the ray met nothing
  double d_radius[6] = {};   // ∂r/∂(x of vertex[0], x of vertex[1]) [px/m]
};

// The direction of ray k of num_angles.
inline Eigen::Vector2d RayDirection(int k, int num_angles) {
  const double angle = 2 * M_PI * k / num_angles;
  return {std::cos(angle), std::sin(angle)};
}

// The radial profile r(θ_k) [px] about the camera centre, θ_k = 2πk/K, counter-clockwise as seen in
// the image (θ = 0 is +column, θ = π/2 is up) [MODEL, M47].
struct Outline {
  Eigen::VectorXd radius;        // [px], shape [K]; 0 at a missing angle
  std::vector<OutlineHit> hits;  // shape [K] from a mesh, empty from an image
  std::vector<int> missing;      // indices k of rays that met no cloth

  int num_angles() const { return static_cast<int>(radius.size()); }
};

// The outermost 0.5 level of the coverage on each ray: bilinear samples every 0.25 px from outside
// inwards, with the crossing by linear interpolation. Returns false when an angle is missing.
bool OutlineFromImage(const GrayImage& image, const Camera& camera, int num_angles,
                      Outline* outline);

// The distance from the camera's centre at which the coverage first falls below 0.5 along a ray, by
// samples every 0.25 px [px]; 0 when the centre is not on the cloth.
double FirstExit(const GrayImage& image, const Camera& camera, const Eigen::Vector2d& direction);

// The outermost crossing of each ray with the projected hem (mesh.boundary_loops[0]) of positions x
// [m], shape [3V]. A fold that bulges over the hem is not seen here, only by RenderSoft. Returns
// false when an angle is missing, and with all angles missing when a coordinate is not finite or a
// vertex of the hem is behind the camera.
bool OutlineFromMesh(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                     int num_angles, Outline* outline);

// The Jacobian J = ∂r/∂x [px/m], shape [K, 3V], of an outline of a mesh with V vertices
// [MODEL, M47].
Eigen::SparseMatrix<double, Eigen::RowMajor> OutlineJacobian(const Outline& outline,
                                                             int num_vertices);

// The distance of a point from the segment from a to b.
double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b);

// The root mean square of a − b, in their unit. Both have the same non-zero size.
double ProfileRms(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

// Where the support's centre is in an image.
enum class CentreMode {
  kNominal,  // at the image's centre, or where the user says
  kOutline   // where the outline has no first harmonic: the published images are off by up to 11 px
};
constexpr auto EnumNames(CentreMode) {
  return MakeNames<CentreMode>(
      {{CentreMode::kNominal, "nominal"}, {CentreMode::kOutline, "outline"}});
}

// Moves the camera to the point about which the outline of the image has no first harmonic, Σ r(θ)
// e^{iθ} = 0. This point is the centre of the support in an image of a drape whose folds favour no
// side. The centres of the published images deviate from the nominal one by up to 11 px (median 2).
// The search starts at the camera's centre. Returns false when the outline is not complete; the
// camera may then have moved.
bool CentreOnOutline(const GrayImage& image, Camera* camera);

// Moves the camera's centre to the centroid of the coverage where it is farther from it than a
// third of the cloth's mean radius: from there the outline may not be seen as a whole. No published
// image is off by more than a fifth.
void CentreOnFarCloth(const GrayImage& image, Camera* camera);

// A peak of a profile r(θ_k), θ_k = 2πk/K, and the lowest place between it and the peak before.
struct Fold {
  int valley = 0, peak = 0;  // k
};

inline constexpr double kFoldProminence = 2.5e-3;  // [m]
// The peaks with at least this prominence [m] after smoothing by a Gaussian of standard deviation
// 2° (use K ≥ 180: a spacing wider than 2° is not smoothed), counter-clockwise from the lowest
// place of the profile [m], shape [K].
std::vector<Fold> FindFolds(const Eigen::VectorXd& radius, double prominence = kFoldProminence);

// Features of one radial profile r(θ_k) [m], θ_k = 2πk/K, shape [K] [MODEL, M49]. They do not
// depend on the rotation of the drape.

// The drape coefficient DC = (A − πr²)/(πR² − πr²) of the area A [m²] of the drape's vertical
// projection, R and r the radii of specimen and support [BS 5058], [ISO 9073-9]: 0 for the support,
// 1 for the flat cloth. Laboratories give it in %.
double DrapeCoefficient(double area, const DrapeDiscs& discs);

// The area ½∫r²dθ [m²] by the trapezoidal rule, which is exact for a circle and spectrally accurate
// for smooth profiles.
double ProfileArea(const Eigen::VectorXd& radius);

// The number of peaks that FindFolds finds.
int CountFolds(const Eigen::VectorXd& radius, double prominence = kFoldProminence);

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

// The height z ≤ 0 [m] at which the hem of a drape hangs where it is r [m] from the axis: cloth
// hardly stretches, so the hem is about its free length L = specimen − support from the support's
// edge. The distance is L·(1 − 0.09·u·(1 − u)), u = (r − support)/L: the shortening by folds,
// fitted to 18 simulated drapes of nine fabrics (drape coefficients of .10 to .92), to 2 mm rms at
// most (4 % of L) at any r. Outside [support, specimen], r is taken as the nearer end.
double EstimatedHemHeight(double r, const DrapeDiscs& discs);

// Where the cloth ends, seen from above, at a point of the outline in a picture [m]. point_at(z):
// the point of the plane at height z that is seen there. Far from the support that is the hem, by
// iteration of its height. Near its rim it is the hem, or the cloth's bend over the rim, which
// hides a hem that is up to 6 % farther out, and the mean of both is reported: of 8 simulated
// drapes (finer and others than those of PHOTOS.md), a fifth are hems up to 1.02 radii of the
// support, all from 1.065 on.
Eigen::Vector2d EstimatedOutermost(const std::function<Eigen::Vector2d(double)>& point_at,
                                   const DrapeDiscs& discs);

// The vertical projection of the outline that a camera sees: its radial profile [m] about the
// support's centre, at the angles of `radius_px` [px], shape [K], K ≥ 8. Of an orthographic camera
// it is MetresFromPixels. A pinhole shows a hem below the support too small; each point is moved to
// the estimated height of the hem there (EstimatedOutermost). For an eye at 1 m the drape
// coefficient of an exact outline is within 0.4 points of that of the drape.
Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs);

}  // namespace drape
