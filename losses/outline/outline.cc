// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/outline.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr double kRayStep = 0.25;  // [px]
constexpr double kLevel = 0.5;

double SampleCoverage(const GrayImage& image, double column, double row) {
  const int c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
  if (c < 0 || r < 0 || c >= image.width - 1 || r >= image.height - 1) return 0;
  const double u = column - c, v = row - r;
  return (1 - v) * ((1 - u) * image.at(c, r) + u * image.at(c + 1, r)) +
         v * ((1 - u) * image.at(c, r + 1) + u * image.at(c + 1, r + 1));
}

double SampleRay(const GrayImage& image, const Camera& camera, const Vector2d& direction,
                 double radius) {
  return SampleCoverage(image, camera.cx + radius * direction.x(),
                        camera.cy - radius * direction.y());
}

// The radius of the outermost level crossing [px], or 0.
double OutermostCrossing(const GrayImage& image, const Camera& camera, const Vector2d& direction) {
  const double reach = std::hypot(std::max(camera.cx, image.width - camera.cx),
                                  std::max(camera.cy, image.height - camera.cy));
  double previous = 0;
  for (int i = static_cast<int>(std::ceil(reach / kRayStep)); i >= 0; --i) {
    const double radius = kRayStep * i;
    const double value = SampleRay(image, camera, direction, radius);
    if (value >= kLevel) return radius + kRayStep * (value - kLevel) / (value - previous);
    previous = value;
  }
  return 0;
}

bool CollectMissing(Outline* outline) {
  outline->missing.clear();
  for (int k = 0; k < outline->num_angles(); ++k) {
    if (outline->radius[k] <= 0) outline->missing.push_back(k);
  }
  return outline->missing.empty();
}

// Projects the hem [px], about the camera centre and y up. Returns false where a point is not
// finite or not in front of the camera.
bool ProjectHem(const std::vector<int>& hem, const Eigen::VectorXd& x, const Camera& camera,
                std::vector<Vector2d>* points) {
  points->clear();
  for (const int vertex : hem) {
    const double* place = &x[3 * vertex];
    double image[2];
    camera.Project(place, image);
    const Vector2d point{image[0] - camera.cx, camera.cy - image[1]};
    if (!(camera.IsInFront(place) && point.allFinite() && std::isfinite(place[2]))) return false;
    points->push_back(point);
  }
  return true;
}

// The outermost crossing of a ray so far.
struct RayCrossing {
  int segment = -1;  // of the hem, from its point `segment` to the next one; -1: none
  double t = 0;      // position on it
  double radius = 0;
};

// Records the segment a→b of the hem if it is the outermost crossing so far. A vertex lies on the
// same side of a ray in both of its segments (half-open rule), so that no ray passes between two
// segments.
void CrossRay(const Vector2d& ray, const Vector2d& a, const Vector2d& b, int segment,
              RayCrossing* outermost) {
  const double side_a = Determinant(ray, a), side_b = Determinant(ray, b);
  if ((side_a > 0) == (side_b > 0)) return;
  const double t = side_a / (side_a - side_b);
  const double radius = ray.dot(a + t * (b - a));
  if (radius > outermost->radius) *outermost = {segment, t, radius};
}

// ∂r of the crossing at a + t(b − a), with edge = b − a [MODEL, M47]: the normal of the segment
// over its component along the ray, distributed to the ends at x_a and x_b [m].
void RadiusByEnds(const Camera& camera, const Vector2d& ray, const Vector2d& edge, double t,
                  const double* x_a, const double* x_b, double d_radius[6]) {
  const double across = Determinant(ray, edge);
  const Vector2d by_image{edge.y() / across, edge.x() / across};  // rows of the image run down
  camera.AdjProject(x_a, (1 - t) * by_image, d_radius);
  camera.AdjProject(x_b, t * by_image, d_radius + 3);
}

// The range of angle indices (not wrapped) of the rays that the segment a→b may cross, wider by one
// at each end.
std::pair<int, int> AngleRange(const Vector2d& a, const Vector2d& b, int num_angles) {
  const double start = std::atan2(a.y(), a.x());
  const double end = start + std::atan2(Determinant(a, b), a.dot(b));
  const double per_radian = num_angles / (2 * M_PI);
  return {static_cast<int>(std::floor(std::min(start, end) * per_radian)),
          static_cast<int>(std::ceil(std::max(start, end) * per_radian))};
}

// Updates the crossings of the rays that a segment may cross.
void CrossSegment(const std::vector<Vector2d>& hem, int segment,
                  std::vector<RayCrossing>* crossings) {
  const int num_angles = static_cast<int>(crossings->size());
  const Vector2d &a = hem[segment], &b = hem[(segment + 1) % hem.size()];
  const auto [first, last] = AngleRange(a, b, num_angles);
  for (int index = first; index <= last; ++index) {
    const int k = ((index % num_angles) + num_angles) % num_angles;
    CrossRay(RayDirection(k, num_angles), a, b, segment, &(*crossings)[k]);
  }
}

constexpr double kSmoothingAngle = 2 * M_PI / 180;  // [rad] standard deviation

// Smooths by a circular Gaussian that is cut at 4 standard deviations.
Eigen::VectorXd Smooth(const Eigen::VectorXd& radius) {
  const int n = static_cast<int>(radius.size());
  const double spacing = 2 * M_PI / n;
  const int reach = static_cast<int>(4 * kSmoothingAngle / spacing);
  Eigen::VectorXd smooth = Eigen::VectorXd::Zero(n);
  double sum = 0;
  for (int d = -reach; d <= reach; ++d) {
    const double weight = std::exp(-0.5 * std::pow(d * spacing / kSmoothingAngle, 2));
    sum += weight;
    for (int k = 0; k < n; ++k) smooth[k] += weight * radius[((k + d) % n + n) % n];
  }
  return smooth / sum;
}

constexpr int kBandEdges[kNumBands][2] = {{2, 2}, {3, 5}, {6, 9}, {10, 15}};

// cos kθ + i·sin kθ at angle i of n.
std::complex<double> Wave(int k, int i, int n) { return std::polar(1.0, 2 * M_PI * k * i / n); }

constexpr double kShortening = 0.09;
constexpr int kRounds = 12;
// Shares of the support's radius, as seen at its height. Up to kBend the outline is mostly the bend
// of the cloth over the support, which hides the hem; from kHem on it is the hem. kLeastHems: the
// share of hems up to kBend.
constexpr double kBend = 1.02, kHem = 1.065;
constexpr double kLeastHems = 0.2;

// The profile of a closed polygon about the origin at K equal angles.
Eigen::VectorXd ProfileOfPolygon(const std::vector<Vector2d>& polygon, int num_angles) {
  Eigen::VectorXd radius(num_angles);
  for (int k = 0; k < num_angles; ++k) {
    const Vector2d ray = RayDirection(k, num_angles);
    RayCrossing outermost;
    for (size_t i = 0; i < polygon.size(); ++i)
      CrossRay(ray, polygon[i], polygon[(i + 1) % polygon.size()], static_cast<int>(i), &outermost);
    radius[k] = outermost.radius;
  }
  return radius;
}

}  // namespace

bool OutlineFromImage(const GrayImage& image, const Camera& camera, int num_angles,
                      Outline* outline) {
  CHECK_GT(num_angles, 0);
  outline->hits.clear();
  outline->radius.resize(num_angles);
  for (int k = 0; k < num_angles; ++k) {
    outline->radius[k] = OutermostCrossing(image, camera, RayDirection(k, num_angles));
  }
  return CollectMissing(outline);
}

double FirstExit(const GrayImage& image, const Camera& camera, const Vector2d& direction) {
  double radius = 0;
  while (SampleRay(image, camera, direction, radius) >= kLevel) radius += kRayStep;
  return radius;
}

bool OutlineFromMesh(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                     int num_angles, Outline* outline) {
  CHECK_GT(num_angles, 0);
  CHECK(!mesh.boundary_loops.empty()) << "a mesh without a boundary has no hem";
  const std::vector<int>& hem = mesh.boundary_loops[0];
  outline->radius.setZero(num_angles);
  outline->hits.assign(num_angles, {});
  std::vector<Vector2d> points;
  std::vector<RayCrossing> crossings(num_angles);
  if (ProjectHem(hem, x, camera, &points)) {
    for (size_t i = 0; i < hem.size(); ++i) CrossSegment(points, i, &crossings);
  }
  for (int k = 0; k < num_angles; ++k) {
    const RayCrossing& crossing = crossings[k];
    if (crossing.segment < 0) continue;
    const int next = (crossing.segment + 1) % hem.size();
    OutlineHit& hit = outline->hits[k];
    outline->radius[k] = crossing.radius;
    hit.vertex[0] = hem[crossing.segment];
    hit.vertex[1] = hem[next];
    RadiusByEnds(camera, RayDirection(k, num_angles), points[next] - points[crossing.segment],
                 crossing.t, &x[3 * hit.vertex[0]], &x[3 * hit.vertex[1]], hit.d_radius);
  }
  return CollectMissing(outline);
}

Eigen::SparseMatrix<double, Eigen::RowMajor> OutlineJacobian(const Outline& outline,
                                                             int num_vertices) {
  CHECK_EQ(outline.hits.size(), size_t(outline.radius.size()))
      << "an outline of an image has no Jacobian";
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < outline.num_angles(); ++k) {
    const OutlineHit& hit = outline.hits[k];
    if (hit.vertex[0] < 0) continue;
    for (int i = 0; i < 6; ++i)
      entries.emplace_back(k, 3 * hit.vertex[i / 3] + i % 3, hit.d_radius[i]);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> jacobian(outline.num_angles(), 3 * num_vertices);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

double DistanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d e = b - a;
  const double length2 = e.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(e) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * e).norm();
}

double ProfileRms(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  CHECK_EQ(a.size(), b.size());
  CHECK_GT(a.size(), 0);
  return (a - b).norm() / std::sqrt(double(a.size()));
}

bool CentreOnOutline(const GrayImage& image, Camera* camera) {
  constexpr int kAngles = 360, kMaxRounds = 20;
  constexpr double kTolerance = 1e-4;  // [px]
  for (int round = 0; round < kMaxRounds; ++round) {
    Outline outline;
    if (!OutlineFromImage(image, *camera, kAngles, &outline)) return false;
    double along = 0.0, up = 0.0;
    for (int k = 0; k < kAngles; ++k) {
      const double theta = 2.0 * std::numbers::pi * k / kAngles;
      along += 2.0 / kAngles * outline.radius[k] * std::cos(theta);
      up += 2.0 / kAngles * outline.radius[k] * std::sin(theta);
    }
    camera->cx += along;
    camera->cy -= up;
    if (std::hypot(along, up) < kTolerance) break;
  }
  return true;
}

void CentreOnFarCloth(const GrayImage& image, Camera* camera) {
  double area = 0.0, column = 0.0, row = 0.0;
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      area += image.at(c, r);
      column += static_cast<double>(image.at(c, r)) * c;
      row += static_cast<double>(image.at(c, r)) * r;
    }
  }
  column /= area;
  row /= area;
  const double mean_radius = std::sqrt(area / std::numbers::pi);
  if (!(std::hypot(column - camera->cx, row - camera->cy) > mean_radius / 3)) return;
  camera->cx = column;
  camera->cy = row;
}

// Makes one turn from the lowest point with hysteresis: a rise by the prominence above the lowest
// point since the last fold, followed by a fall by it, is one peak of that prominence.
std::vector<Fold> FindFolds(const Eigen::VectorXd& radius, double prominence) {
  const Eigen::VectorXd r = Smooth(radius);
  const int n = static_cast<int>(r.size());
  int start = 0, extreme = 0;
  r.minCoeff(&start);
  extreme = start;
  bool rising = false;  // a rise by the prominence has occurred
  std::vector<Fold> folds;
  int valley = start;
  for (int i = 1; i <= n; ++i) {
    const int k = (start + i) % n;
    const double sign = rising ? 1.0 : -1.0;
    if (sign * r[k] > sign * r[extreme]) extreme = k;
    if (sign * (r[extreme] - r[k]) < prominence) continue;
    if (rising)
      folds.push_back({valley, extreme});
    else
      valley = extreme;
    rising = !rising;
    extreme = k;
  }
  return folds;
}

std::complex<double> ComputeMode(const Eigen::VectorXd& radius, int k) {
  const int n = static_cast<int>(radius.size());
  std::complex<double> sum = 0;
  for (int i = 0; i < n; ++i) sum += radius[i] * Wave(k, i, n);
  return 2.0 / n * sum;
}

double DrapeCoefficient(double area, const DrapeDiscs& discs) {
  const double support = M_PI * discs.support * discs.support;
  return (area - support) / (M_PI * discs.specimen * discs.specimen - support);
}

double ProfileArea(const Eigen::VectorXd& radius) {
  return M_PI * radius.squaredNorm() / radius.size();
}

int CountFolds(const Eigen::VectorXd& radius, double prominence) {
  return static_cast<int>(FindFolds(radius, prominence).size());
}

std::array<double, kNumBands> BandEnergies(const Eigen::VectorXd& radius) {
  const int n = static_cast<int>(radius.size());
  CHECK_GT(n, 2 * kBandEdges[kNumBands - 1][1]);
  std::array<double, kNumBands> energy = {};
  for (int band = 0; band < kNumBands; ++band) {
    for (int k = kBandEdges[band][0]; k <= kBandEdges[band][1]; ++k)
      energy[band] += 0.5 * std::norm(ComputeMode(radius, k));
  }
  return energy;
}

Eigen::Matrix2Xd ProfilePolygon(const Eigen::VectorXd& radius) {
  const int num_angles = static_cast<int>(radius.size());
  Eigen::Matrix2Xd polygon(2, num_angles);
  for (int k = 0; k < num_angles; ++k) polygon.col(k) = radius[k] * RayDirection(k, num_angles);
  return polygon;
}

double IsoperimetricRatio(const Eigen::VectorXd& radius) {
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius);
  double area = 0, length = 0;
  for (Eigen::Index k = 0; k < polygon.cols(); ++k) {
    const Vector2d a = polygon.col(k), b = polygon.col((k + 1) % polygon.cols());
    area += 0.5 * Determinant(a, b);
    length += (b - a).norm();
  }
  return 4 * M_PI * area / (length * length);
}

ShapeFeatures MeasureShape(const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  ShapeFeatures features;
  features.drape_coefficient = DrapeCoefficient(ProfileArea(radius), discs);
  features.folds = CountFolds(radius);
  features.band_energy = BandEnergies(radius);
  features.radius_min = radius.minCoeff();
  features.radius_max = radius.maxCoeff();
  features.isoperimetric_ratio = IsoperimetricRatio(radius);
  return features;
}

ShapeFeatureVector ListShapeFeatures(const ShapeFeatures& features) {
  const auto& bands = features.band_energy;
  ShapeFeatureVector list;
  list << features.drape_coefficient, features.folds, bands[0], bands[1], bands[2], bands[3],
      features.radius_min, features.radius_max, features.isoperimetric_ratio;
  return list;
}

namespace {

// ∂(½ Σ a_k² of a band)/∂r.
Eigen::VectorXd BandEnergyGradient(const Eigen::VectorXd& radius, int band) {
  const int n = static_cast<int>(radius.size());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (int k = kBandEdges[band][0]; k <= kBandEdges[band][1]; ++k) {
    const std::complex<double> mode = ComputeMode(radius, k);
    for (int i = 0; i < n; ++i) gradient[i] += 2.0 / n * (std::conj(mode) * Wave(k, i, n)).real();
  }
  return gradient;
}

// ∂(4πA/L²)/∂r.
Eigen::VectorXd IsoperimetricGradient(const Eigen::VectorXd& radius) {
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius);
  const Eigen::Matrix2Xd along = ProfilePolygon(Eigen::VectorXd::Ones(radius.size()));
  const Eigen::Index n = polygon.cols();
  Eigen::VectorXd by_area = Eigen::VectorXd::Zero(n), by_length = by_area;  // ∂A/∂r, ∂L/∂r
  double area = 0, length = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index next = (k + 1) % n;
    const Vector2d a = polygon.col(k), b = polygon.col(next), edge = (b - a).normalized();
    area += 0.5 * Determinant(a, b);
    length += (b - a).norm();
    by_area[k] += 0.5 * Determinant(along.col(k), b);
    by_area[next] += 0.5 * Determinant(a, along.col(next));
    by_length[k] -= edge.dot(along.col(k));
    by_length[next] += edge.dot(along.col(next));
  }
  return 4 * M_PI / (length * length) * (by_area - 2 * area / length * by_length);
}

}  // namespace

Eigen::Matrix<double, kNumShapeFeatures, Eigen::Dynamic> ShapeFeatureJacobian(
    const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  const Eigen::Index n = radius.size();
  Eigen::Matrix<double, kNumShapeFeatures, Eigen::Dynamic> jacobian(kNumShapeFeatures, n);
  jacobian.setZero();
  // The coefficient is linear in the area, whose gradient is 2π/n·r.
  const double by_area = DrapeCoefficient(1.0, discs) - DrapeCoefficient(0.0, discs);
  jacobian.row(0) = by_area * 2 * M_PI / static_cast<double>(n) * radius;
  for (int band = 0; band < kNumBands; ++band)
    jacobian.row(2 + band) = BandEnergyGradient(radius, band);
  Eigen::Index least = 0, most = 0;
  radius.minCoeff(&least);
  radius.maxCoeff(&most);
  jacobian(2 + kNumBands, least) = 1.0;
  jacobian(3 + kNumBands, most) = 1.0;
  jacobian.row(4 + kNumBands) = IsoperimetricGradient(radius);
  return jacobian;
}

double EstimatedHemHeight(double r, const DrapeDiscs& discs) {
  const double free_length = discs.specimen - discs.support;
  const double u = std::clamp((r - discs.support) / free_length, 0.0, 1.0);
  const double chord = 1.0 - kShortening * u * (1.0 - u);
  return -free_length * std::sqrt(std::max(chord * chord - u * u, 0.0));
}

Vector2d EstimatedOutermost(const std::function<Vector2d(double)>& point_at,
                            const DrapeDiscs& discs) {
  const Vector2d bend = point_at(0.0);
  double z = 0.5 * EstimatedHemHeight(discs.support, discs);
  Vector2d hem = point_at(z);
  for (int round = 0; round < kRounds; ++round) {
    z = 0.5 * (z + EstimatedHemHeight(hem.norm(), discs));
    hem = point_at(z);
  }
  const double from_bend = (bend.norm() / discs.support - kBend) / (kHem - kBend);
  const double hems = kLeastHems + (1 - kLeastHems) * std::clamp(from_bend, 0.0, 1.0);
  return bend + hems * (hem - bend);
}

Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs) {
  CHECK_GE(radius_px.size(), 8);
  if (camera.kind == CameraKind::kOrthographic) return MetresFromPixels(radius_px, camera);
  const int num_angles = static_cast<int>(radius_px.size());
  std::vector<Vector2d> hem;
  for (int k = 0; k < num_angles; ++k) {
    const Vector2d ray = RayDirection(k, num_angles);
    const Vector2d image(camera.cx + radius_px[k] * ray.x(), camera.cy - radius_px[k] * ray.y());
    hem.push_back(
        EstimatedOutermost([&](double z) { return camera.WorldFromImage(image, z); }, discs));
  }
  return ProfileOfPolygon(hem, num_angles);
}

}  // namespace drape
