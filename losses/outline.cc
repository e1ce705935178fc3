// SPDX-License-Identifier: Apache-2.0
#include "losses/outline.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr double kRayStep = 0.25;  // [px]
constexpr double kLevel = 0.5;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Vector2d RayDirection(int k, int num_angles) {
  const double angle = 2 * M_PI * k / num_angles;
  return {std::cos(angle), std::sin(angle)};
}

double SampleCoverage(const GrayImage& image, double column, double row) {
  const int c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
  if (c < 0 || r < 0 || c >= image.width - 1 || r >= image.height - 1) return 0;
  const double u = column - c, v = row - r;
  return (1 - v) * ((1 - u) * image.at(c, r) + u * image.at(c + 1, r)) +
         v * ((1 - u) * image.at(c, r + 1) + u * image.at(c + 1, r + 1));
}

// Radius of the outermost level crossing, or 0.
double OutermostCrossing(const GrayImage& image, const Camera& camera, const Vector2d& direction) {
  const double reach = std::hypot(std::max(camera.cx, image.width - camera.cx),
                                  std::max(camera.cy, image.height - camera.cy));
  double previous = 0;
  for (int i = static_cast<int>(std::ceil(reach / kRayStep)); i >= 0; --i) {
    const double radius = kRayStep * i;
    const double value = SampleCoverage(image, camera.cx + radius * direction.x(),
                                        camera.cy - radius * direction.y());
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

// Hem in pixels about the camera's centre, y up; false when it cannot be projected.
bool ProjectHem(const std::vector<int>& hem, const Eigen::VectorXd& x, const Camera& camera,
                std::vector<Vector2d>* points) {
  Eigen::VectorXd hem_x(3 * hem.size());
  for (size_t i = 0; i < hem.size(); ++i) hem_x.segment<3>(3 * i) = x.segment<3>(3 * hem[i]);
  Eigen::Matrix2Xd image_points;
  if (!ProjectVertices(hem_x, camera, &image_points)) return false;
  points->resize(hem.size());
  for (size_t i = 0; i < hem.size(); ++i) {
    (*points)[i] = {image_points(0, i) - camera.cx, camera.cy - image_points(1, i)};
  }
  return true;
}

// Range of angle indices (not wrapped) that segment a→b may cross, one wider at each end.
std::pair<int, int> AngleRange(const Vector2d& a, const Vector2d& b, int num_angles) {
  const double start = std::atan2(a.y(), a.x());
  const double end = start + std::atan2(Cross(a, b), a.dot(b));
  const double per_radian = num_angles / (2 * M_PI);
  return {static_cast<int>(std::floor(std::min(start, end) * per_radian)),
          static_cast<int>(std::ceil(std::max(start, end) * per_radian))};
}

// ∂r of the ray's crossing at a + t(b−a): the segment's normal over its component along the ray.
void FillHit(const Camera& camera, const Eigen::VectorXd& x, const Vector2d& ray,
             const Vector2d& edge, double t, OutlineHit* hit) {
  const Vector2d normal = Vector2d(edge.y(), -edge.x()) / Cross(ray, edge);
  const Eigen::RowVector2d d_image(normal.x(), -normal.y());  // rows of the image run down
  for (int end = 0; end < 2; ++end) {
    const double weight = end == 0 ? 1 - t : t;
    Eigen::Map<Eigen::RowVector3d>(hit->d_radius + 3 * end) =
        weight * d_image * camera.ImageFromWorldJacobian(&x[3 * hit->vertex[end]]);
  }
}

struct Crossing {
  int segment = -1;
  double t = 0;
};

// Keeps the outermost crossing of each ray. A vertex lies on the same side of a ray in both of its
// segments (half-open rule), so no ray slips through between two of them.
void CrossSegment(const std::vector<Vector2d>& hem, int segment, Eigen::VectorXd* radius,
                  std::vector<Crossing>* crossings) {
  const int num_angles = static_cast<int>(radius->size());
  const Vector2d &a = hem[segment], &b = hem[(segment + 1) % hem.size()];
  const auto [first, last] = AngleRange(a, b, num_angles);
  for (int index = first; index <= last; ++index) {
    const int k = ((index % num_angles) + num_angles) % num_angles;
    const Vector2d ray = RayDirection(k, num_angles);
    const double side_a = Cross(ray, a), side_b = Cross(ray, b);
    if ((side_a > 0) == (side_b > 0)) continue;
    const double t = side_a / (side_a - side_b);
    const double r = ray.dot(a + t * (b - a));
    if (r > (*radius)[k]) {
      (*radius)[k] = r;
      (*crossings)[k] = {segment, t};
    }
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

bool OutlineFromMesh(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                     int num_angles, Outline* outline) {
  CHECK_GT(num_angles, 0);
  CHECK(!mesh.boundary_loops.empty()) << "a mesh without a boundary has no hem";
  const std::vector<int>& hem = mesh.boundary_loops[0];
  outline->radius.setZero(num_angles);
  outline->hits.assign(num_angles, {});
  std::vector<Vector2d> points;
  std::vector<Crossing> crossings(num_angles);
  if (ProjectHem(hem, x, camera, &points)) {
    for (size_t i = 0; i < hem.size(); ++i) CrossSegment(points, i, &outline->radius, &crossings);
  }
  for (int k = 0; k < num_angles; ++k) {
    const auto [segment, t] = crossings[k];
    if (segment < 0) continue;
    const int next = (segment + 1) % hem.size();
    OutlineHit& hit = outline->hits[k];
    hit.vertex[0] = hem[segment];
    hit.vertex[1] = hem[next];
    FillHit(camera, x, RayDirection(k, num_angles), points[next] - points[segment], t, &hit);
  }
  return CollectMissing(outline);
}

namespace {

// Calls visit(k, row of x, ∂r_k/∂x_row) for all nonzeros of the Jacobian.
template <typename Visit>
void ForEachEntry(const Outline& outline, const Visit& visit) {
  CHECK_EQ(outline.hits.size(), size_t(outline.radius.size())) << "outline of an image";
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

Eigen::MatrixXd OutlineSeeds(const Outline& outline, int num_vertices) {
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(3 * num_vertices, outline.num_angles());
  ForEachEntry(outline, [&](int k, int i, double value) { seeds(i, k) = value; });
  return seeds;
}

void AdjOutline(const Outline& outline, const Eigen::VectorXd& radius_adjoint,
                Eigen::VectorXd* gradient) {
  CHECK_EQ(radius_adjoint.size(), outline.num_angles());
  ForEachEntry(outline,
               [&](int k, int i, double value) { (*gradient)[i] += value * radius_adjoint[k]; });
}

}  // namespace drape
