// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/camera_pose.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <future>
#include <memory>

#include "losses/image/photo_planes.h"

namespace drape {
namespace {

struct Deleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

double ComputeArea(const apriltag_detection_t& tag) {
  double area = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double *a = tag.p[i], *b = tag.p[(i + 1) % 4];
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(area);
}

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kRimFloor = 0.03;    // [px] systematic error of the rim's shape
constexpr double kRimNoise = 0.15;    // [px] least standard deviation of a point of the rim
constexpr double kCornerNoise = 0.2;  // [px]
constexpr double kHarmonic = 1e-3;    // [m]

// tilt (2), eye (3), and with a tag its turn and its centre in the world (2).
constexpr int kPoseParameters = 5, kTagParameters = 3;

PhotoPose MakePose(const PoseInput& input, const VectorXd& p) {
  return {input.focal, input.principal, p.head<2>(), p.segment<3>(2)};
}

Vector2d TagCorner(const PoseInput& input, const VectorXd& p, int corner) {
  constexpr int kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const Vector2d own = 0.5 * input.tag_side * Vector2d(kSigns[corner][0], kSigns[corner][1]);
  return Eigen::Rotation2Dd(p[5]) * own + p.segment<2>(6);
}

// (1/π)∫ r e^{iθ} dθ of the hem [m].
Vector2d FirstHarmonic(const PoseInput& input, const PhotoPose& pose) {
  Vector2d sum = Vector2d::Zero();
  std::vector<Vector2d> hem;
  for (const Vector2d& image : input.outline) {
    const Vector2d above = pose.WorldFromImage(image, 0),
                   along = pose.WorldFromImage(image, 1) - above;
    hem.push_back(EstimatedOutermost([&](double z) { return above + z * along; }, input.discs));
  }
  for (size_t i = 0; i < hem.size(); ++i) {
    const Vector2d &a = hem[i], &b = hem[(i + 1) % hem.size()];
    sum += 0.5 * (a + b) * std::atan2(Determinant(a, b), a.dot(b));
  }
  return sum / M_PI;
}

VectorXd Residuals(const PoseInput& input, const VectorXd& p, double rim_sigma) {
  const PhotoPose pose = MakePose(input, p);
  const size_t corners = input.tag ? 8 : 0;
  VectorXd r(input.rim.size() + corners + 2);
  Eigen::Index next = 0;
  const double above_rim = pose.eye.z() - input.rim_height;
  for (const Vector2d& point : input.rim)
    r[next++] = (pose.WorldFromImage(point, input.rim_height).norm() - input.rim_radius) *
                input.focal / above_rim / rim_sigma;
  if (input.tag) {
    for (int i = 0; i < 4; ++i, next += 2) {
      const Vector2d corner = TagCorner(input, p, i);
      r.segment<2>(next) =
          (pose.ImageFromWorld({corner.x(), corner.y(), input.tag_height}) - (*input.tag)[i]) /
          kCornerNoise;
    }
  }
  r.tail<2>() = FirstHarmonic(input, pose) / kHarmonic;
  return r;
}

struct Minimum {
  VectorXd p;
  double cost = HUGE_VAL;
  Eigen::MatrixXd hessian;
};

Eigen::MatrixXd Jacobian(const PoseInput& input, const VectorXd& p, double rim_sigma) {
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd jacobian;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    VectorXd up = p, down = p;
    up[i] += kStep;
    down[i] -= kStep;
    const VectorXd column =
        (Residuals(input, up, rim_sigma) - Residuals(input, down, rim_sigma)) / (2 * kStep);
    if (i == 0) jacobian.resize(column.size(), p.size());
    jacobian.col(i) = column;
  }
  return jacobian;
}

// Levenberg-Marquardt from p.
Minimum Minimise(const PoseInput& input, const VectorXd& p, double rim_sigma) {
  constexpr int kIterations = 40;
  constexpr double kMostDamping = 1e8, kTolerance = 1e-8;
  Minimum best{p, Residuals(input, p, rim_sigma).squaredNorm(), {}};
  double damping = 1e-3;
  for (int i = 0; i < kIterations && damping < kMostDamping; ++i) {
    const Eigen::MatrixXd jacobian = Jacobian(input, best.p, rim_sigma);
    const VectorXd gradient = jacobian.transpose() * Residuals(input, best.p, rim_sigma);
    best.hessian = jacobian.transpose() * jacobian;
    bool improved = false;
    while (!improved && damping < kMostDamping) {
      Eigen::MatrixXd damped = best.hessian;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd trial = best.p - damped.ldlt().solve(gradient);
      const double cost =
          trial[4] > 0 ? Residuals(input, trial, rim_sigma).squaredNorm() : HUGE_VAL;
      improved = cost < best.cost;
      damping *= improved ? 0.2 : 5.0;
      if (!improved) continue;
      const double gain = best.cost - cost;
      best.p = trial;
      best.cost = cost;
      if (gain < kTolerance * (1 + cost)) return best;
    }
  }
  return best;
}

// A camera that looks straight down on a marker of known size.
VectorXd MakeStart(const PoseInput& input) {
  Vector2d middle = Vector2d::Zero();
  double size_px = 0.0, size = 0.0, height = 0.0;
  if (input.tag) {
    for (const Vector2d& corner : *input.tag) middle += corner / 4;
    for (int i = 0; i < 4; ++i) size_px += ((*input.tag)[(i + 1) % 4] - (*input.tag)[i]).norm() / 4;
    size = input.tag_side;
    height = input.tag_height;
  } else {
    for (const Vector2d& point : input.rim) middle += point / double(input.rim.size());
    for (const Vector2d& point : input.rim)
      size_px += (point - middle).norm() / double(input.rim.size());
    size = input.rim_radius;
    height = input.rim_height;
  }
  Vector2d support = Vector2d::Zero();
  for (const Vector2d& point : input.outline) support += point / double(input.outline.size());
  VectorXd p = VectorXd::Zero(kPoseParameters + (input.tag ? kTagParameters : 0));
  p[4] = height + input.focal * size / size_px;
  const Vector2d axis = (support - input.principal) * p[4] / input.focal;
  p[2] = -axis.x();
  p[3] = axis.y();
  if (!input.tag) return p;
  const Vector2d side = (*input.tag)[1] - (*input.tag)[0];
  p[5] = std::atan2(-side.y(), side.x());
  p.tail<2>() = MakePose(input, p).WorldFromImage(middle, height);
  return p;
}

// [px]
double RimRms(const PoseInput& input, const VectorXd& p) {
  const auto points = static_cast<Eigen::Index>(input.rim.size());
  return std::sqrt(Residuals(input, p, 1.0).head(points).squaredNorm() /
                   std::max(1.0, static_cast<double>(points)));
}

// Without points that lie far off the rim: a crease, a highlight, a finger.
void RemoveOutliers(const VectorXd& p, PoseInput* input) {
  constexpr double kMost = 5.0;    // median deviations
  constexpr double kSlack = 0.05;  // [px]
  if (input->rim.empty()) return;
  const VectorXd residuals = Residuals(*input, p, 1.0);
  std::vector<double> sizes;
  for (size_t i = 0; i < input->rim.size(); ++i)
    sizes.push_back(std::abs(residuals[static_cast<Eigen::Index>(i)]));
  const double most = kSlack + kMost * Quantile(sizes);
  std::vector<Vector2d> kept;
  for (size_t i = 0; i < sizes.size(); ++i)
    if (sizes[i] <= most) kept.push_back(input->rim[i]);
  input->rim = kept;
}

double TagRms(const PoseInput& input, const VectorXd& p) {
  const VectorXd r = Residuals(input, p, 1.0);
  return kCornerNoise *
         std::sqrt(r.segment<8>(static_cast<Eigen::Index>(input.rim.size())).squaredNorm() / 4);
}

}  // namespace

std::optional<std::array<Eigen::Vector2d, 4>> FindTag(const PhotoPlanes& planes) {
  constexpr int kMostErrors = 1;  // bits that are corrected
  constexpr float kLeastMargin = 20;
  // Linear light: in stored values the edges of a blurred tag lie in its black, and the tag looks
  // smaller by .6 %.
  cv::Mat1b gray;
  planes.luma.convertTo(gray, CV_8U, 255);
  const std::unique_ptr<apriltag_family_t, Deleter> family(tag36h11_create());
  const std::unique_ptr<apriltag_detector_t, Deleter> detector(apriltag_detector_create());
  apriltag_detector_add_family_bits(detector.get(), family.get(), kMostErrors);
  detector->quad_decimate = 1;
  image_u8_t image{gray.cols, gray.rows, static_cast<int32_t>(gray.step[0]), gray.data};
  const std::unique_ptr<zarray_t, Deleter> found(apriltag_detector_detect(detector.get(), &image));
  const apriltag_detection_t* best = nullptr;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* tag = nullptr;
    zarray_get(found.get(), i, &tag);
    if (tag->decision_margin < kLeastMargin) continue;
    if (best == nullptr || ComputeArea(*tag) > ComputeArea(*best)) best = tag;
  }
  if (best == nullptr) return std::nullopt;
  std::array<Eigen::Vector2d, 4> corners;
  // The library's pixel centres are at halves.
  for (size_t i = 0; i < 4; ++i) corners[i] = {best->p[i][0] - 0.5, best->p[i][1] - 0.5};
  return corners;
}

Eigen::Matrix3d PhotoPose::WorldFromCamera() const {
  const double angle = tilt.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, Vector3d(tilt.x(), tilt.y(), 0) / angle).toRotationMatrix();
}

Vector2d PhotoPose::WorldFromImage(const Vector2d& image, double z) const {
  const Vector3d ray = WorldFromCamera() * Vector3d((image.x() - principal.x()) / focal,
                                                    -(image.y() - principal.y()) / focal, -1);
  return eye.head<2>() + ray.head<2>() * (eye.z() - z) / -ray.z();
}

Vector2d PhotoPose::ImageFromWorld(const Vector3d& x) const {
  const Vector3d own = WorldFromCamera().transpose() * (x - eye);
  return principal + focal * Vector2d(own.x(), -own.y()) / -own.z();
}

std::optional<FoundPose> FindPose(const PoseInput& whole) {
  constexpr int kDirections = 6;
  constexpr double kStartTilt = 0.1;  // [rad] the circle alone has no gradient at 0
  PoseInput input = whole;
  const VectorXd start = MakeStart(input);
  std::vector<std::future<Minimum>> minima;  // side by side
  for (int i = 0; i < kDirections; ++i) {
    VectorXd p = start;
    const double angle = 2 * M_PI * i / kDirections;
    p[0] = kStartTilt * std::cos(angle);
    p[1] = kStartTilt * std::sin(angle);
    // The eye moves so that the support stays where it is seen.
    p[2] += p[4] * p[1];
    p[3] -= p[4] * p[0];
    minima.push_back(std::async([&input, p] { return Minimise(input, p, 1.0); }));
  }
  Minimum best;
  for (auto& each : minima)
    if (const Minimum found = each.get(); found.cost < best.cost) best = found;
  if (!std::isfinite(best.cost)) return std::nullopt;
  RemoveOutliers(best.p, &input);
  const double noise = std::max(RimRms(input, best.p), kRimNoise);
  best = Minimise(input, best.p,
                  std::hypot(noise, kRimFloor * std::sqrt(0.5 * double(input.rim.size()))));
  if (!std::isfinite(best.cost) || best.hessian.size() == 0) return std::nullopt;
  const Eigen::MatrixXd covariance =
      best.hessian.ldlt().solve(Eigen::MatrixXd::Identity(best.p.size(), best.p.size()));
  FoundPose found{MakePose(input, best.p),
                  input.rim.empty() ? TagRms(input, best.p) : RimRms(input, best.p),
                  std::sqrt(std::max(covariance(0, 0), covariance(1, 1))),
                  std::sqrt(covariance(4, 4)) / best.p[4],
                  FirstHarmonic(input, MakePose(input, best.p)).norm()};
  return found;
}

}  // namespace drape
