// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/cloth_mask.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/camera/photo/cloth_parts.h"
#include "losses/image/image.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kWorkingSide = 2000;       // [px]
constexpr double kBorderShare = 0.04;    // of the shorter side
constexpr double kSaturated = 250;       // grey level without detail
constexpr double kNoiseOfFactor = 1.48;  // median absolute deviation to standard deviation

double Median(std::vector<float> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Mat1b BorderMask(cv::Size size) {
  const int width = std::max(2, static_cast<int>(kBorderShare * std::min(size.width, size.height)));
  cv::Mat1b border(size, 1);
  border(cv::Rect(width, width, size.width - 2 * width, size.height - 2 * width)) = 0;
  return border;
}

// 1, x, y, x², xy, y² of a place, with x and y from −1 to 1.
using Monomials = cv::Vec<double, 6>;
Monomials MonomialsAt(int column, int row, cv::Size size) {
  const double x = 2.0 * column / size.width - 1, y = 2.0 * row / size.height - 1;
  return {1, x, y, x * x, x * y, y * y};
}

// The ground's colour as a quadratic function of the place, least squares with Tukey's weights
// over the border's pixels.
struct Ground {
  cv::Matx<double, 6, 3> coefficients;
  double noise = 0.0;

  cv::Vec3d At(const Monomials& m) const {
    const cv::Matx<double, 1, 3> color = m.t() * coefficients;
    return {color(0), color(1), color(2)};
  }
};

Ground FitGround(const cv::Mat3f& lab, const cv::Mat1b& border) {
  constexpr int kStride = 3, kRounds = 6;
  constexpr double kReach = 4.0;  // standard deviations
  std::vector<Monomials> places;
  std::vector<cv::Vec3f> colors;
  std::vector<float> channel[3];
  for (int row = 0; row < lab.rows; row += kStride)
    for (int col = 0; col < lab.cols; col += kStride)
      if (border(row, col)) {
        places.push_back(MonomialsAt(col, row, lab.size()));
        colors.push_back(lab(row, col));
        for (int c = 0; c < 3; ++c) channel[c].push_back(colors.back()[c]);
      }
  Ground ground;
  for (int c = 0; c < 3; ++c) ground.coefficients(0, c) = Median(channel[c]);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> errors;
    for (size_t i = 0; i < places.size(); ++i)
      errors.push_back(static_cast<float>(cv::norm(cv::Vec3d(colors[i]) - ground.At(places[i]))));
    ground.noise = std::max(0.3, kNoiseOfFactor / std::sqrt(3.0) * Median(errors));
    if (round + 1 == kRounds) break;
    const double reach = kReach * std::sqrt(3.0) * ground.noise;
    cv::Matx<double, 6, 6> normal = cv::Matx<double, 6, 6>::eye() * 1e-6;
    cv::Matx<double, 6, 3> right;
    for (size_t i = 0; i < places.size(); ++i) {
      const double u = errors[i] / reach, weight = u < 1 ? (1 - u * u) * (1 - u * u) : 0;
      normal += weight * places[i] * places[i].t();
      right +=
          weight * places[i] * cv::Matx<double, 1, 3>(colors[i][0], colors[i][1], colors[i][2]);
    }
    ground.coefficients = normal.inv(cv::DECOMP_CHOLESKY) * right;
  }
  return ground;
}

cv::Mat3f WithoutGround(const cv::Mat3f& lab, const Ground& ground) {
  cv::Mat3f rest(lab.size());
  for (int row = 0; row < lab.rows; ++row)
    for (int col = 0; col < lab.cols; ++col)
      rest(row, col) = lab(row, col) - cv::Vec3f(ground.At(MonomialsAt(col, row, lab.size())));
  return rest;
}

// A measure of being cloth, and where it separates.
struct Feature {
  cv::Mat1f value;
  double threshold = 0.0, separation = 0.0;  // of the variance, between the two classes

  cv::Mat1b Mask() const { return (value > threshold) / 255; }
};

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

Feature DistanceFeature(const cv::Mat3f& rest) {
  cv::Mat1f distance(rest.size());
  for (int row = 0; row < rest.rows; ++row)
    for (int col = 0; col < rest.cols; ++col)
      distance(row, col) = static_cast<float>(std::min(cv::norm(rest(row, col)), 100.0));
  return WithOtsuThreshold(distance);
}

// The distance from what the ground can be, in light and in shadow: a shadow multiplies the stored
// red, green and blue by one number, which moves the colour along a curve.
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

// Fisher's linear discriminant of the two sides of a mask, and of the sides that it makes, …
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

cv::Mat1b Disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

void ApplyPoints(const std::vector<int>& points, double scale, uint8_t value, const char* key,
                 cv::Mat1b* labels) {
  constexpr double kRadius = 0.006;  // of the longer side
  if (points.size() % 2 != 0)
    throw InputError(std::string("option '") + key + "'",
                     "found an odd count of numbers, expected "
                     "columns and rows in pairs");
  for (size_t i = 0; i < points.size(); i += 2) {
    const cv::Point place(static_cast<int>(points[i] * scale),
                          static_cast<int>(points[i + 1] * scale));
    if (!cv::Rect({}, labels->size()).contains(place))
      throw InputError(
          std::string("option '") + key + "'",
          Format("found (%d, %d), expected a point of the picture", points[i], points[i + 1]));
    cv::circle(*labels, place, static_cast<int>(kRadius * std::max(labels->rows, labels->cols)),
               value, cv::FILLED);
  }
}

// GrabCut from the mask, on a small copy of the picture.
cv::Mat1b GrabCut(const PhotoPlanes& planes, const cv::Mat1b& mask, const PhotoOptions& options) {
  constexpr double kSide = 500;
  constexpr int kRounds = 4;
  const double shrink = std::min(1.0, kSide / std::max(mask.rows, mask.cols));
  cv::Mat3b small;
  cv::Mat1b small_mask;
  cv::resize(planes.rgb, small, {}, shrink, shrink, cv::INTER_AREA);
  cv::resize(mask, small_mask, small.size(), 0, 0, cv::INTER_NEAREST);
  cv::Mat1b labels(small.size());
  labels.setTo(cv::GC_PR_BGD);
  labels.setTo(cv::GC_PR_FGD, small_mask);
  labels.setTo(cv::GC_BGD, BorderMask(small.size()));
  ApplyPoints(options.cloth_points, planes.scale * shrink, cv::GC_FGD, "cloth_points", &labels);
  ApplyPoints(options.ground_points, planes.scale * shrink, cv::GC_BGD, "ground_points", &labels);
  cv::Mat background, foreground;
  cv::theRNG().state = 1;
  cv::grabCut(small, labels, {}, background, foreground, kRounds, cv::GC_INIT_WITH_MASK);
  const cv::Mat1b found = (labels & 1);
  cv::Mat1b large;
  cv::resize(found, large, mask.size(), 0, 0, cv::INTER_NEAREST);
  return large;
}

cv::Mat1b ReadMask(const std::string& path, cv::Size size) {
  const GrayImage picture = ReadImage(path);
  const double aspect = double(picture.width) / picture.height,
               expected = double(size.width) / size.height;
  if (std::abs(aspect / expected - 1) > 0.01)
    throw InputError(path, Format("mask is %dx%d px, expected the shape of the photograph",
                                  picture.width, picture.height));
  const cv::Mat1f coverage(picture.height, picture.width,
                           const_cast<float*>(picture.coverage.data()));
  cv::Mat1f resized;
  cv::resize(coverage, resized, size, 0, 0, cv::INTER_AREA);
  return (resized > 0.5f) / 255;
}

}  // namespace

PhotoPlanes MakePlanes(const RgbImage& image) {
  constexpr double kSmoothing = 0.7;  // [px]
  PhotoPlanes planes;
  const cv::Mat3b photo(image.height, image.width,
                        reinterpret_cast<cv::Vec3b*>(const_cast<uint8_t*>(image.rgb.data())));
  planes.scale = std::min(1.0, double(kWorkingSide) / std::max(image.width, image.height));
  cv::resize(photo, planes.rgb, {}, planes.scale, planes.scale, cv::INTER_AREA);
  cv::Mat3f colors;
  planes.rgb.convertTo(colors, CV_32F, 1 / 255.0);
  cv::GaussianBlur(colors, colors, {}, kSmoothing);
  cv::cvtColor(colors, planes.lab, cv::COLOR_RGB2Lab);
  const cv::Mat1b border = BorderMask(planes.rgb.size());
  cv::Mat1b least;
  cv::inRange(planes.rgb, cv::Scalar::all(kSaturated), cv::Scalar::all(255), least);
  planes.saturated = cv::mean(least, border)[0] / 255;
  return planes;
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

RoughCloth FindCloth(const PhotoPlanes& planes, const PhotoOptions& options) {
  constexpr double kUneven = 9.0;  // [Lab units] of the ground, from which on it is refused
  constexpr double kLeastSeparation = 0.6;  // of the variance
  constexpr double kShadowed = 1.25;        // by how much worse that feature may separate
  const cv::Mat1b border = BorderMask(planes.lab.size());
  const Ground ground = FitGround(planes.lab, border);
  RoughCloth rough;
  rough.ground_noise = ground.noise;
  cv::Mat1b mask;
  if (!options.mask.empty()) {
    mask = ReadMask(options.mask, planes.lab.size());
  } else {
    const bool has_points = !options.cloth_points.empty() || !options.ground_points.empty();
    if (ground.noise > kUneven && !has_points)
      throw PhotoFailure{PhotoFault::kUnevenGround,
                         Format("the ground is uneven: its colour varies by %.0f Lab units along "
                                "the edge of the picture, expected at most %.0f",
                                ground.noise, kUneven)};
    const cv::Mat3f rest = WithoutGround(planes.lab, ground);
    const Feature distance = DistanceFeature(rest);
    Feature feature = DiscriminantFeature(rest, distance.Mask());
    if (distance.separation > feature.separation) feature = distance;
    const Feature shadowed = ShadowedFeature(planes, rest, border);
    if (kShadowed * shadowed.separation > feature.separation) feature = shadowed;
    if (options.threshold > 0) {
      double most = 0;
      cv::minMaxLoc(distance.value, nullptr, &most);
      feature = {distance.value, options.threshold * most, 1.0};
    }
    mask = feature.Mask();
    if (has_points || feature.separation < kLeastSeparation) mask = GrabCut(planes, mask, options);
  }
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, Disc(2));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, Disc(2));
  rough.mask = PickCloth(planes, options, mask, &rough.warnings);
  return rough;
}

}  // namespace drape
