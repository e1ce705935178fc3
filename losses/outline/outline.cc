// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/outline.h"

#include <glog/logging.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace drape {
namespace {

constexpr double kRayStep = 0.25;  // [px]
constexpr double kLevel = 0.5;

double SampleCoverage(const GrayImage& image, double column, double row) {
  const int c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
  if (c < 0 || r < 0 || c >= image.width - 1 || r >= image.height - 1) return 0;
  const double u = column - c, v = row - r;
  return (1 - v) * ((1 - u) * image.at(c, r) + u * image.at(c + 1, r)) +
         v * ((1 - u) * image.at(c, r + 1) + u * image.at(c + 1, r + 1));
}

double SampleRay(const GrayImage& image, const Camera& camera, const Vec2& direction,
                 double radius) {
  return SampleCoverage(image, camera.cx + radius * direction.x, camera.cy - radius * direction.y);
}

// The radius of the outermost level crossing [px], or 0.
double OutermostCrossing(const GrayImage& image, const Camera& camera, const Vec2& direction) {
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

bool ProjectHem(const std::vector<int>& hem, const Eigen::VectorXd& x, const Camera& camera,
                std::vector<Vec2>* points) {
  const Projection projection = camera.projection();
  points->resize(hem.size());
  for (size_t i = 0; i < hem.size(); ++i)
    if (!ProjectHemPoint(projection, &x[3 * hem[i]], &(*points)[i])) return false;
  return true;
}

// The range of angle indices (not wrapped) of the rays that the segment a→b may cross, wider by one
// at each end.
std::pair<int, int> AngleRange(const Vec2& a, const Vec2& b, int num_angles) {
  const double start = std::atan2(a.y, a.x);
  const double end = start + std::atan2(Cross(a, b), Dot(a, b));
  const double per_radian = num_angles / (2 * M_PI);
  return {static_cast<int>(std::floor(std::min(start, end) * per_radian)),
          static_cast<int>(std::ceil(std::max(start, end) * per_radian))};
}

// Updates the crossings of the rays that a segment may cross.
void CrossSegment(const std::vector<Vec2>& hem, int segment, std::vector<RayCrossing>* crossings) {
  const int num_angles = static_cast<int>(crossings->size());
  const Vec2 &a = hem[segment], &b = hem[(segment + 1) % hem.size()];
  const auto [first, last] = AngleRange(a, b, num_angles);
  for (int index = first; index <= last; ++index) {
    const int k = ((index % num_angles) + num_angles) % num_angles;
    CrossRay(RayDirection(k, num_angles), a, b, segment, &(*crossings)[k]);
  }
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

double FirstExit(const GrayImage& image, const Camera& camera, const Vec2& direction) {
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
  std::vector<Vec2> points;
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
    RadiusByEnds(camera.projection(), RayDirection(k, num_angles),
                 points[next] - points[crossing.segment], crossing.t, &x[3 * hit.vertex[0]],
                 &x[3 * hit.vertex[1]], hit.d_radius);
  }
  return CollectMissing(outline);
}

namespace {

// Calls visit(k, row of x, ∂r_k/∂x_row) for all non-zeros of the Jacobian.
template <typename Visit>
void ForEachEntry(const Outline& outline, const Visit& visit) {
  CHECK_EQ(outline.hits.size(), size_t(outline.radius.size()))
      << "an outline of an image has no Jacobian";
  for (int k = 0; k < outline.num_angles(); ++k) {
    const OutlineHit& hit = outline.hits[k];
    if (hit.vertex[0] < 0) continue;
    for (int i = 0; i < 6; ++i) visit(k, 3 * hit.vertex[i / 3] + i % 3, hit.d_radius[i]);
  }
}

}  // namespace

Eigen::SparseMatrix<double, Eigen::RowMajor> OutlineJacobian(const Outline& outline,
                                                             int num_vertices) {
  std::vector<Eigen::Triplet<double>> entries;
  ForEachEntry(outline, [&](int k, int i, double value) { entries.emplace_back(k, i, value); });
  Eigen::SparseMatrix<double, Eigen::RowMajor> jacobian(outline.num_angles(), 3 * num_vertices);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

RowMatrix OutlineJacobianTimes(const Outline& outline, const RowMatrix& dx_dp) {
  RowMatrix dr_dp = RowMatrix::Zero(outline.num_angles(), dx_dp.cols());
  ForEachEntry(outline, [&](int k, int i, double value) { dr_dp.row(k) += value * dx_dp.row(i); });
  return dr_dp;
}

Eigen::MatrixXd OutlineAdjointSeeds(const Outline& outline, int num_vertices) {
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(3 * num_vertices, outline.num_angles());
  ForEachEntry(outline, [&](int k, int i, double value) { seeds(i, k) = value; });
  return seeds;
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

}  // namespace drape
