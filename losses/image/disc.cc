// SPDX-License-Identifier: Apache-2.0
#include "losses/image/disc.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "losses/image/photo_planes.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;
using Eigen::Vector4f;
using Eigen::VectorXd;

constexpr int kRays = 720;
constexpr double kStep = 0.5;  // [px] between samples along a ray

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

// The circle of a mask's middle and area.
Circle MeasureSize(const cv::Mat1b& cloth) {
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
void CollectEdges(const cv::Mat3f& lab, const cv::Mat1b& cloth, const Circle& size, int ray,
                  std::vector<Edge>* edges) {
  constexpr int kReach = 6, kMostEdges = 6;
  constexpr double kInner = 0.45, kLeastStrength = 1.5;
  const double angle = 2 * M_PI * ray / kRays;
  const Vector2d direction(std::cos(angle), std::sin(angle));
  std::vector<cv::Vec3f> colors;
  std::vector<Vector2d> places;
  for (double t = kInner * size.radius;; t += kStep) {
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
    found.push_back({places[i] + shift * kStep * direction, ray, change[i]});
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

Circle BestCircle(const std::vector<Edge>& edges, const Circle& size) {
  constexpr int kTrials = 4000;
  constexpr double kTolerance = 0.028, kOffset = 0.35, kLeast = 0.5, kMost = 1.06;
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

// The edge nearest to the ellipse on each ray, where it is within the tolerance.
std::vector<Vector2d> PointsOn(const std::vector<Edge>& edges, const cv::RotatedRect& ellipse,
                               double tolerance) {
  std::vector<Vector2d> points;
  std::vector<double> nearest(kRays, tolerance);
  std::vector<const Edge*> chosen(kRays, nullptr);
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

// One ray across the rim.
struct Ray {
  Vector2d middle, normal;  // outwards
  std::vector<Vector4f> light;
  Vector3f inside = Vector3f::Zero(), outside = Vector3f::Zero();  // mean light away from the rim
  VectorXd samples;                                                // along it: 0 inside, 1 outside
};

Ray MakeRay(const RgbImage& photo, const cv::RotatedRect& ellipse, int number, double reach) {
  const double angle = 2 * M_PI * number / kRays, turn = ellipse.angle * M_PI / 180;
  const double a = 0.5 * ellipse.size.width, b = 0.5 * ellipse.size.height;
  Eigen::Matrix2d rotation;
  rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  Ray ray;
  ray.middle = Vector2d(ellipse.center.x, ellipse.center.y) +
               rotation * Vector2d(a * std::cos(angle), b * std::sin(angle));
  ray.normal = (rotation * Vector2d(b * std::cos(angle), a * std::sin(angle))).normalized();
  const Eigen::Index count = StepFinder::CountSamples(reach, kStep);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = (static_cast<double>(i) - 0.5 * static_cast<double>(count - 1)) * kStep;
    ray.light.push_back(LightAt(photo, ray.middle + t * ray.normal));
  }
  const size_t third = ray.light.size() / 3;
  for (size_t i = 0; i < third; ++i) {
    ray.inside += ray.light[i].head<3>() / float(third);
    ray.outside += ray.light[ray.light.size() - 1 - i].head<3>() / float(third);
  }
  return ray;
}

// The samples of each ray by the light on either side of the rim in its neighbourhood.
void FindShares(std::vector<Ray>* rays) {
  constexpr int kNeighbours = 8;  // on either side
  const int n = static_cast<int>(rays->size());
  for (int i = 0; i < n; ++i) {
    Vector3f inside = Vector3f::Zero(), outside = Vector3f::Zero();
    for (int k = -kNeighbours; k <= kNeighbours; ++k) {
      const Ray& ray = (*rays)[size_t(i + k + n) % rays->size()];
      inside += ray.inside / float(2 * kNeighbours + 1);
      outside += ray.outside / float(2 * kNeighbours + 1);
    }
    Ray& ray = (*rays)[size_t(i)];
    ray.samples.resize(static_cast<Eigen::Index>(ray.light.size()));
    for (size_t k = 0; k < ray.light.size(); ++k)
      ray.samples[static_cast<Eigen::Index>(k)] =
          ShareOfMixture(ray.light[k], inside, outside - inside);
  }
}

// The sample on a ray that differs most from the light on either side, if it does so by more than
// these differ from each other.
std::optional<size_t> FindLine(const Ray& ray) {
  float most = 0.6f * (ray.outside - ray.inside).norm();
  std::optional<size_t> line;
  for (size_t i = 0; i < ray.light.size(); ++i) {
    const Vector3f light = ray.light[i].head<3>();
    const float apart = std::min((light - ray.inside).norm(), (light - ray.outside).norm());
    if (apart > most) line = i;
    most = std::max(most, apart);
  }
  return line;
}

// The places of the lines; the samples become those of their outer edges, where a clear disc ends.
std::vector<Vector2d> TakeLines(std::vector<Ray>* rays) {
  std::vector<Vector2d> places;
  for (Ray& ray : *rays) {
    ray.samples.setZero();
    const std::optional<size_t> line = FindLine(ray);
    if (!line) continue;
    const Vector3f from = ray.light[*line].head<3>(), to = ray.light.back().head<3>();
    for (size_t k = *line; k < ray.light.size(); ++k)
      ray.samples[Eigen::Index(k)] = ShareOfMixture(ray.light[k], from, to - from);
    const double steps = double(*line) - 0.5 * double(ray.light.size() - 1);
    places.push_back(ray.middle + steps * kStep * ray.normal);
  }
  return places;
}

struct Steps {
  std::vector<StepFinder::Step> of_ray;
  double misfit = 0.0;  // median
};
Steps FindSteps(const std::vector<Ray>& rays, double reach, double sigma) {
  const StepFinder finder(reach, kStep, sigma);
  Steps steps;
  std::vector<double> misfits;
  for (const Ray& ray : rays) {
    steps.of_ray.push_back(finder.Find(ray.samples));
    misfits.push_back(steps.of_ray.back().misfit);
  }
  steps.misfit = Quantile(misfits);
  return steps;
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
  if (cv::countNonZero(cloth) == 0) return std::nullopt;
  const Circle size = MeasureSize(cloth);
  std::vector<Edge> edges;
  for (int ray = 0; ray < kRays; ++ray) CollectEdges(planes.lab, cloth, size, ray, &edges);
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
  rim.share = double(rim.points.size()) / kRays;
  if (rim.share < kLeastShare) return std::nullopt;
  return rim;
}

cv::Mat1f RenderEllipse(cv::Size size, const cv::RotatedRect& ellipse, double blur) {
  constexpr double kReach = 4.0;  // standard deviations
  const double reach = kReach * blur,
               outer = 0.5 * std::max(ellipse.size.width, ellipse.size.height) + reach,
               inner = 0.5 * std::min(ellipse.size.width, ellipse.size.height) - reach;
  cv::Mat1f coverage(size);
  for (int row = 0; row < size.height; ++row)
    for (int col = 0; col < size.width; ++col) {
      const Vector2d p(col, row);
      const double r = (p - Vector2d(ellipse.center.x, ellipse.center.y)).norm();
      const bool is_far = r > outer || r < inner;  // from the rim, as most are
      const double t = is_far ? std::copysign(kReach, r - inner) : DistanceFrom(ellipse, p) / blur;
      coverage(row, col) = t >= kReach    ? 0.0f
                           : t <= -kReach ? 1.0f
                                          : static_cast<float>(0.5 * std::erfc(t / std::sqrt(2.0)));
    }
  return coverage;
}

RimPoints LocateRim(const RgbImage& photo, const cv::RotatedRect& ellipse, bool is_on_line) {
  constexpr double kLeastReach = 7.0;     // [px]
  constexpr double kReach = 0.03;         // of the radius
  constexpr double kMostMisfit = 3.0;     // of the median
  constexpr double kLeastContrast = 0.3;  // of the median
  constexpr double kBlurs[] = {0.4, 0.55, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0, 2.4, 2.9, 3.5};
  const double reach =
      std::max(kLeastReach, kReach * 0.25 * (ellipse.size.width + ellipse.size.height));
  std::vector<Ray> rays;
  std::vector<float> contrasts;
  for (int i = 0; i < kRays; ++i) {
    rays.push_back(MakeRay(photo, ellipse, i, reach));
    contrasts.push_back((rays.back().outside - rays.back().inside).norm());
  }
  FindShares(&rays);
  RimPoints rim;
  rim.is_line = is_on_line || std::count_if(rays.begin(), rays.end(), [](const Ray& ray) {
                                return FindLine(ray).has_value();
                              }) > kRays / 2;
  if (rim.is_line) {
    const std::vector<Vector2d> places = TakeLines(&rays);
    if (!is_on_line) return LocateRim(photo, FitEllipse(places), true);
  }
  Steps best;
  for (const double blur : kBlurs) {
    const Steps steps = FindSteps(rays, reach, blur);
    if (!best.of_ray.empty() && steps.misfit >= best.misfit) continue;
    best = steps;
    rim.blur = blur;
  }
  const double contrast = Quantile(contrasts);
  for (size_t i = 0; i < rays.size(); ++i) {
    const StepFinder::Step& step = best.of_ray[i];
    if (step.at_limit || step.misfit > kMostMisfit * best.misfit ||
        (!rim.is_line && contrasts[i] < kLeastContrast * contrast))
      continue;
    rim.points.push_back(rays[i].middle + step.place * rays[i].normal);
  }
  rim.share = double(rim.points.size()) / kRays;
  return rim;
}

void LocateFinely(const RgbImage& photo, const PhotoPlanes& planes, const cv::Mat1b& mask,
                  DiscRim* rim) {
  constexpr double kLeastShare = 0.4, kLeastClear = 0.25;
  constexpr float kClear = 6.0f;  // [px]
  const double scale = planes.scale;
  const auto to_photo = [&](float v) { return static_cast<float>((v + 0.5) / scale - 0.5); };
  cv::RotatedRect ellipse = rim->ellipse;
  ellipse.center = {to_photo(ellipse.center.x), to_photo(ellipse.center.y)};
  ellipse.size = {float(ellipse.size.width / scale), float(ellipse.size.height / scale)};
  const RimPoints fine = LocateRim(photo, ellipse);
  rim->is_line = fine.is_line;
  if (fine.share < kLeastShare) return;
  const cv::Mat1b disc = RenderEllipse(mask.size(), rim->ellipse, rim->blur) > 0.5f;
  cv::Mat1f inside;
  cv::distanceTransform(mask | disc, inside, cv::DIST_L2, cv::DIST_MASK_5);
  std::vector<Eigen::Vector2d> all, clear;
  for (const Eigen::Vector2d& p : fine.points) {
    all.push_back((p.array() + 0.5) * scale - 0.5);
    const Eigen::Vector2i pixel = all.back().array().round().cast<int>();
    if (inside(pixel.y(), pixel.x()) >= kClear) clear.push_back(all.back());
  }
  rim->points = double(clear.size()) > kLeastClear * double(all.size()) ? clear : all;
  rim->ellipse = FitEllipse(rim->points);
  rim->blur = planes.WorkingBlur(fine.blur);
}

}  // namespace drape
