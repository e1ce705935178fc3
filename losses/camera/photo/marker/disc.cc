// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/marker/disc.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr int kEdgeRays = 720;
constexpr double kEdgeStep = 0.5;  // [px] along a ray

// Where the colour changes along a ray.
struct Edge {
  Vector2d place;
  int ray;
  double strength;  // [Lab units]
};

struct Circle {
  Vector2d middle;
  double radius = 0.0;
};

struct ClothSize {
  Vector2d middle;
  double radius = 0.0;  // mean [px]
};

ClothSize MeasureSize(const cv::Mat1b& cloth) {
  const cv::Moments m = cv::moments(cloth, true);
  return {{m.m10 / m.m00, m.m01 / m.m00}, std::sqrt(m.m00 / M_PI)};
}

cv::Vec3f Sample(const cv::Mat3f& lab, const Vector2d& p) {
  const int c = static_cast<int>(p.x()), r = static_cast<int>(p.y());
  const auto u = static_cast<float>(p.x() - c), v = static_cast<float>(p.y() - r);
  return (1 - v) * ((1 - u) * lab(r, c) + u * lab(r, c + 1)) +
         v * ((1 - u) * lab(r + 1, c) + u * lab(r + 1, c + 1));
}

// The strongest changes of colour along one ray: maxima of the norm of its derivative, by
// differences of the means over kReach steps on either side.
void CollectEdges(const cv::Mat3f& lab, const cv::Mat1b& cloth, const ClothSize& size, int ray,
                  std::vector<Edge>* edges) {
  constexpr int kReach = 6, kMostEdges = 6;
  constexpr double kInner = 0.45, kLeastStrength = 1.5;
  const double angle = 2 * M_PI * ray / kEdgeRays;
  const Vector2d direction(std::cos(angle), std::sin(angle));
  std::vector<cv::Vec3f> colors;
  std::vector<Vector2d> places;
  for (double t = kInner * size.radius;; t += kEdgeStep) {
    const Vector2d p = size.middle + t * direction;
    if (p.x() < 1 || p.y() < 1 || p.x() > lab.cols - 3 || p.y() > lab.rows - 3 ||
        !cloth(static_cast<int>(p.y()), static_cast<int>(p.x())))
      break;
    colors.push_back(Sample(lab, p));
    places.push_back(p);
  }
  const int n = static_cast<int>(colors.size());
  std::vector<double> change(std::max(n, 0), 0.0);
  for (int i = kReach; i + kReach < n; ++i) {
    cv::Vec3f difference;
    for (int k = 1; k <= kReach; ++k) difference += colors[i + k] - colors[i - k];
    change[i] = cv::norm(difference) / kReach;
  }
  std::vector<Edge> found;
  for (int i = kReach + 1; i + kReach + 1 < n; ++i) {
    if (change[i] < kLeastStrength || change[i] < change[i - 1] || change[i] <= change[i + 1])
      continue;
    const double bend = change[i - 1] - 2 * change[i] + change[i + 1];
    const double shift = bend < 0 ? 0.5 * (change[i - 1] - change[i + 1]) / bend : 0.0;
    found.push_back({places[i] + shift * kEdgeStep * direction, ray, change[i]});
  }
  std::sort(found.begin(), found.end(),
            [](const Edge& a, const Edge& b) { return a.strength > b.strength; });
  if (found.size() > kMostEdges) found.resize(kMostEdges);
  edges->insert(edges->end(), found.begin(), found.end());
}

bool CircleThrough(const Vector2d& a, const Vector2d& b, const Vector2d& c, Circle* circle) {
  Eigen::Matrix2d lines;
  lines << (b - a).transpose(), (c - a).transpose();
  if (std::abs(lines.determinant()) < 1) return false;
  const Vector2d right(0.5 * (b.squaredNorm() - a.squaredNorm()),
                       0.5 * (c.squaredNorm() - a.squaredNorm()));
  circle->middle = lines.inverse() * right;
  circle->radius = (a - circle->middle).norm();
  return true;
}

// The weight of the rays on which an edge is within the tolerance of the circle: an edge counts
// more the stronger it is, up to kFull.
double Support(const std::vector<Edge>& edges, const Circle& circle, double tolerance) {
  constexpr double kFull = 8.0;
  double sum = 0.0, of_ray = 0.0;
  int ray = -1;
  for (const Edge& edge : edges) {
    if (edge.ray != ray) {
      sum += of_ray;
      of_ray = 0.0;
      ray = edge.ray;
    }
    if (std::abs((edge.place - circle.middle).norm() - circle.radius) < tolerance)
      of_ray = std::max(of_ray, 0.5 + 0.5 * std::min(1.0, edge.strength / kFull));
  }
  return sum + of_ray;
}

Circle BestCircle(const std::vector<Edge>& edges, const ClothSize& size) {
  constexpr int kTrials = 4000;
  constexpr double kTolerance = 0.035, kOffset = 0.35, kLeast = 0.5, kMost = 1.06;
  std::mt19937 random(11);
  std::uniform_int_distribution<size_t> pick(0, edges.size() - 1);
  Circle best;
  double most = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Circle circle;
    if (!CircleThrough(edges[pick(random)].place, edges[pick(random)].place,
                       edges[pick(random)].place, &circle))
      continue;
    if ((circle.middle - size.middle).norm() > kOffset * size.radius ||
        circle.radius < kLeast * size.radius || circle.radius > kMost * size.radius)
      continue;
    const double support = Support(edges, circle, kTolerance * circle.radius);
    if (support <= most) continue;
    most = support;
    best = circle;
  }
  return best;
}

// The distance of a point from an ellipse along its direction from the middle [px], nearly.
double DistanceFrom(const cv::RotatedRect& ellipse, const Vector2d& p) {
  const double turn = ellipse.angle * M_PI / 180;
  const Vector2d d = p - Vector2d(ellipse.center.x, ellipse.center.y);
  const double u = (d.x() * std::cos(turn) + d.y() * std::sin(turn)) / (0.5 * ellipse.size.width);
  const double v = (-d.x() * std::sin(turn) + d.y() * std::cos(turn)) / (0.5 * ellipse.size.height);
  return (1 - 1 / std::max(std::hypot(u, v), 1e-6)) * d.norm();
}

// On each ray the edge nearest to the ellipse, where it is within the tolerance.
std::vector<Vector2d> PointsOn(const std::vector<Edge>& edges, const cv::RotatedRect& ellipse,
                               double tolerance) {
  std::vector<Vector2d> points;
  std::vector<double> nearest(kEdgeRays, tolerance);
  std::vector<const Edge*> chosen(kEdgeRays, nullptr);
  for (const Edge& edge : edges) {
    const double distance = std::abs(DistanceFrom(ellipse, edge.place));
    if (distance >= nearest[edge.ray]) continue;
    nearest[edge.ray] = distance;
    chosen[edge.ray] = &edge;
  }
  for (const Edge* edge : chosen)
    if (edge) points.push_back(edge->place);
  return points;
}

}  // namespace

cv::RotatedRect FitEllipse(const std::vector<Vector2d>& points) {
  std::vector<cv::Point2f> places;
  for (const Vector2d& p : points)
    places.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  return cv::fitEllipseAMS(places);
}

std::optional<DiscRim> FindDisc(const PhotoPlanes& planes, const cv::Mat1b& cloth) {
  constexpr double kLeastShare = 0.5;
  constexpr size_t kLeastPoints = 30;
  constexpr double kTolerances[] = {0.04, 0.015, 0.008, 0.005};  // of the radius
  const ClothSize size = MeasureSize(cloth);
  std::vector<Edge> edges;
  for (int ray = 0; ray < kEdgeRays; ++ray) CollectEdges(planes.lab, cloth, size, ray, &edges);
  if (edges.size() < kLeastPoints) return std::nullopt;
  const Circle circle = BestCircle(edges, size);
  if (circle.radius <= 0) return std::nullopt;
  const auto diameter = static_cast<float>(2 * circle.radius);
  DiscRim rim;
  rim.ellipse = {{static_cast<float>(circle.middle.x()), static_cast<float>(circle.middle.y())},
                 {diameter, diameter},
                 0};
  for (const double tolerance : kTolerances) {
    rim.points = PointsOn(edges, rim.ellipse, std::max(1.2, tolerance * circle.radius));
    if (rim.points.size() < kLeastPoints) return std::nullopt;
    rim.ellipse = FitEllipse(rim.points);
  }
  rim.share = double(rim.points.size()) / kEdgeRays;
  if (rim.share < kLeastShare) return std::nullopt;
  return rim;
}

cv::Mat1f RenderEllipse(cv::Size size, const cv::RotatedRect& ellipse, double blur) {
  constexpr double kReach = 4.0;  // standard deviations
  cv::Mat1f coverage(size);
  for (int row = 0; row < size.height; ++row)
    for (int col = 0; col < size.width; ++col) {
      const Vector2d p(col, row);
      const double t = DistanceFrom(ellipse, p) / blur;
      coverage(row, col) = t > kReach    ? 0.0f
                           : t < -kReach ? 1.0f
                                         : static_cast<float>(0.5 * std::erfc(t / std::sqrt(2.0)));
    }
  return coverage;
}

}  // namespace drape
