// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/marker/rim.h"

#include <algorithm>
#include <cmath>

#include "losses/camera/photo/picture/light.h"
#include "losses/camera/photo/picture/median.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;
using Eigen::Vector4f;
using Eigen::VectorXd;

constexpr int kRays = 720;
constexpr double kStep = 0.5;  // [px] between samples

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
  steps.misfit = Median(misfits);
  return steps;
}

}  // namespace

RimPoints LocateRim(const RgbImage& photo, const cv::RotatedRect& ellipse) {
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
  Steps best;
  for (const double blur : kBlurs) {
    const Steps steps = FindSteps(rays, reach, blur);
    if (!best.of_ray.empty() && steps.misfit >= best.misfit) continue;
    best = steps;
    rim.blur = blur;
  }
  const double contrast = Median(contrasts);
  for (size_t i = 0; i < rays.size(); ++i) {
    const StepFinder::Step& step = best.of_ray[i];
    if (step.at_limit || step.misfit > kMostMisfit * best.misfit ||
        contrasts[i] < kLeastContrast * contrast)
      continue;
    rim.points.push_back(rays[i].middle + step.place * rays[i].normal);
  }
  rim.share = double(rim.points.size()) / kRays;
  return rim;
}

}  // namespace drape
