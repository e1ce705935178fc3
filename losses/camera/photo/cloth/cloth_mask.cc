// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/cloth/cloth_mask.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/camera/photo/cloth/cloth_feature.h"
#include "losses/camera/photo/cloth/cloth_parts.h"
#include "losses/camera/photo/cloth/ground.h"
#include "losses/image/image.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

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

RoughCloth FindCloth(const PhotoPlanes& planes, const PhotoOptions& options) {
  constexpr double kUneven = 9.0;  // [Lab units] of the ground, from which on it is refused
  constexpr double kLeastSeparation = 0.6;  // of the variance
  constexpr double kShadowed = 1.25;        // by how much worse that feature may separate
  constexpr double kLeastDifference = 3.0;  // [Lab units] more than the pieces that noise makes
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
    if (!has_points && cv::norm(cv::mean(rest, mask)) < kLeastDifference)
      throw PhotoFailure{PhotoFault::kNoCloth,
                         "nothing differs from the ground, expected one piece of cloth on a plain "
                         "ground"};
  }
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, RoundElement(2));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, RoundElement(2));
  rough.pieces = mask;
  rough.mask = PickCloth(planes, options, mask, &rough.warnings);
  return rough;
}

}  // namespace drape
