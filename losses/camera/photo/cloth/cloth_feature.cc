// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/cloth/cloth_feature.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/camera/photo/picture/median.h"

namespace drape {
namespace {

Feature WithOtsuThreshold(const cv::Mat1f& value) {
  double least = 0, most = 0;
  cv::minMaxLoc(value, &least, &most);
  Feature feature{value, 0.5 * (least + most), 0.0};
  if (most <= least) return feature;
  cv::Mat1b levels;
  value.convertTo(levels, CV_8U, 255 / (most - least), -255 * least / (most - least));
  cv::Mat unused;
  const double level = cv::threshold(levels, unused, 0, 255, cv::THRESH_OTSU);
  feature.threshold = least + (level + 0.5) * (most - least) / 255;
  cv::Scalar mean, sd, mean_in, mean_out;
  cv::meanStdDev(value, mean, sd);
  const cv::Mat1b mask = feature.Mask();
  mean_in = cv::mean(value, mask);
  mean_out = cv::mean(value, 1 - mask);
  const double share = cv::mean(mask)[0];
  feature.separation =
      share * (1 - share) * std::pow(mean_in[0] - mean_out[0], 2) / std::max(sd[0] * sd[0], 1e-12);
  return feature;
}

struct ClassMoments {
  cv::Vec3d mean;
  cv::Matx33d covariance;
};
ClassMoments ComputeMoments(const cv::Mat3f& rest, const cv::Mat1b& mask, uint8_t value) {
  cv::Vec3d sum;
  cv::Matx33d squares;
  double count = 0;
  for (int row = 0; row < rest.rows; row += 2)
    for (int col = 0; col < rest.cols; col += 2)
      if (mask(row, col) == value) {
        const cv::Vec3d c = rest(row, col);
        sum += c;
        squares += c * c.t();
        ++count;
      }
  if (count == 0) return {};
  const cv::Vec3d mean = sum / count;
  return {mean, squares * (1 / count) - mean * mean.t()};
}

}  // namespace

Feature DistanceFeature(const cv::Mat3f& rest) {
  cv::Mat1f distance(rest.size());
  for (int row = 0; row < rest.rows; ++row)
    for (int col = 0; col < rest.cols; ++col)
      distance(row, col) = static_cast<float>(std::min(cv::norm(rest(row, col)), 100.0));
  return WithOtsuThreshold(distance);
}

Feature ShadowedFeature(const PhotoPlanes& planes, const cv::Mat3f& rest, const cv::Mat1b& border) {
  constexpr double kDarkest = 0.5, kLightest = 1.15;
  constexpr int kSamples = 9;
  std::vector<float> channel[3];
  for (int row = 0; row < rest.rows; row += 3)
    for (int col = 0; col < rest.cols; col += 3)
      if (border(row, col))
        for (int c = 0; c < 3; ++c) channel[c].push_back(planes.rgb(row, col)[c] / 255.0f);
  cv::Mat3f curve(1, kSamples + 1);
  for (int i = 0; i <= kSamples; ++i) {  // the last one is the ground itself
    const double t = i == kSamples ? 1.0 : kDarkest + (kLightest - kDarkest) * i / (kSamples - 1);
    for (int c = 0; c < 3; ++c)
      curve(0, i)[c] = static_cast<float>(std::min(1.0, t * Median(channel[c])));
  }
  cv::cvtColor(curve, curve, cv::COLOR_RGB2Lab);
  for (int i = 0; i < kSamples; ++i) curve(0, i) -= curve(0, kSamples);
  cv::Mat1f distance(rest.size());
  for (int row = 0; row < rest.rows; ++row)
    for (int col = 0; col < rest.cols; ++col) {
      float nearest = 1e4f;
      for (int i = 0; i + 1 < kSamples; ++i) {
        const cv::Vec3f a = rest(row, col) - curve(0, i), e = curve(0, i + 1) - curve(0, i);
        const float t = std::clamp(a.dot(e) / std::max(e.dot(e), 1e-6f), 0.0f, 1.0f);
        const cv::Vec3f apart = a - t * e;
        nearest = std::min(nearest, apart.dot(apart));
      }
      distance(row, col) = std::sqrt(nearest);
    }
  return WithOtsuThreshold(distance);
}

Feature DiscriminantFeature(const cv::Mat3f& rest, cv::Mat1b mask) {
  constexpr int kRounds = 3;
  Feature best;
  for (int round = 0; round < kRounds; ++round) {
    const ClassMoments cloth = ComputeMoments(rest, mask, 1),
                       ground = ComputeMoments(rest, mask, 0);
    const cv::Matx33d within = cloth.covariance + ground.covariance + cv::Matx33d::eye();
    const cv::Vec3d w = within.inv(cv::DECOMP_CHOLESKY) * (cloth.mean - ground.mean);
    cv::Mat1f value(rest.size());
    for (int row = 0; row < rest.rows; ++row)
      for (int col = 0; col < rest.cols; ++col)
        value(row, col) = static_cast<float>(w.dot(cv::Vec3d(rest(row, col))));
    const Feature feature = WithOtsuThreshold(value);
    if (feature.separation > best.separation) best = feature;
    mask = feature.Mask();
  }
  return best;
}

}  // namespace drape
