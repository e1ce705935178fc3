// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/picture/photo_planes.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/photo/picture/light.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kWorkingSide = 2000;     // [px]
constexpr double kBorderShare = 0.04;  // of the shorter side
constexpr double kSaturated = 250;     // grey level without detail
constexpr double kSmoothing = 0.7;     // [px]

}  // namespace

PhotoPlanes MakePlanes(const RgbImage& image) {
  constexpr double kMostLight = 65535;
  PhotoPlanes planes;
  const cv::Mat3b photo(image.height, image.width,
                        reinterpret_cast<cv::Vec3b*>(const_cast<uint8_t*>(image.rgb.data())));
  planes.scale = std::min(1.0, double(kWorkingSide) / std::max(image.width, image.height));
  cv::resize(photo, planes.rgb, {}, planes.scale, planes.scale, cv::INTER_AREA);
  cv::Mat1w table(1, 256);
  std::transform(LightOfStored().begin(), LightOfStored().end(), table.begin(),
                 [](float light) { return cv::saturate_cast<uint16_t>(kMostLight * light); });
  const auto reduce = [&](const auto& stored, auto* result) {
    cv::Mat light;
    cv::LUT(stored, table, light);
    cv::resize(light, light, {}, planes.scale, planes.scale, cv::INTER_AREA);
    light.convertTo(*result, CV_32F, 1 / kMostLight);
    cv::GaussianBlur(*result, *result, {}, kSmoothing);
  };
  reduce(photo, &planes.light);
  cv::Mat1b luma;
  cv::cvtColor(photo, luma, cv::COLOR_RGB2GRAY);
  reduce(luma, &planes.luma);
  cv::cvtColor(planes.light, planes.lab, cv::COLOR_LRGB2Lab);
  const cv::Mat1b border = BorderMask(planes.rgb.size());
  cv::Mat1b least;
  cv::inRange(planes.rgb, cv::Scalar::all(kSaturated), cv::Scalar::all(255), least);
  planes.saturated = cv::mean(least, border)[0] / 255;
  return planes;
}

double PhotoPlanes::WorkingBlur(double blur_of_photo) const {
  return std::hypot(scale * blur_of_photo, kSmoothing);
}

void CheckExposure(const PhotoPlanes& planes) {
  constexpr double kDarkest = 15;  // L* of the lightest hundredth
  std::vector<float> lightness;
  for (int row = 0; row < planes.lab.rows; row += 4)
    for (int col = 0; col < planes.lab.cols; col += 4) lightness.push_back(planes.lab(row, col)[0]);
  const auto high = lightness.begin() + static_cast<long>(0.98 * double(lightness.size()));
  std::nth_element(lightness.begin(), high, lightness.end());
  if (*high < kDarkest)
    throw PhotoFailure{PhotoFault::kDark,
                       Format("the photograph is too dark: its lightest parts have a lightness of "
                              "%.0f %%, expected at least %.0f",
                              *high, kDarkest)};
}

cv::Mat1b FilledHull(const cv::Mat1b& mask) {
  std::vector<cv::Point> places, hull;
  cv::findNonZero(mask, places);
  cv::Mat1b inside = cv::Mat1b::zeros(mask.size());
  if (places.empty()) return inside;
  cv::convexHull(places, hull);
  cv::fillConvexPoly(inside, hull, 1);
  return inside;
}

std::vector<cv::Point> LongestOutline(const cv::Mat1b& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (outlines.empty()) return {};
  return *std::max_element(outlines.begin(), outlines.end(),
                           [](const auto& a, const auto& b) { return a.size() < b.size(); });
}

cv::Mat1b BorderMask(cv::Size size) {
  const int width = std::max(2, static_cast<int>(kBorderShare * std::min(size.width, size.height)));
  cv::Mat1b border(size, 1);
  border(cv::Rect(width, width, size.width - 2 * width, size.height - 2 * width)) = 0;
  return border;
}

cv::Mat1b RoundElement(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

}  // namespace drape
