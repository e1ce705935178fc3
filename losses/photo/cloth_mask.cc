// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/cloth_mask.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "losses/photo/disc.h"
#include "losses/photo/photo_planes.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// 1, x, y, x², xy, y² of a place, with x and y from −1 to 1.
using Monomials = cv::Vec<double, 6>;

// The ground's colour as a quadratic function of the place.
struct Ground {
  cv::Matx<double, 6, 3> coefficients;
  double noise = 0.0;  // robust standard deviation [Lab units]

  cv::Vec3d At(const Monomials& m) const {
    const cv::Matx<double, 1, 3> color = m.t() * coefficients;
    return {color(0), color(1), color(2)};
  }
};

constexpr double kNoiseOfFactor = 1.48;  // median absolute deviation to standard deviation

Monomials MonomialsAt(int column, int row, cv::Size size) {
  const double x = 2.0 * column / size.width - 1, y = 2.0 * row / size.height - 1;
  return {1, x, y, x * x, x * y, y * y};
}

// Least squares with Tukey's weights over the border's pixels.
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

// The colours less the colours of the ground.
cv::Mat3f WithoutGround(const cv::Mat3f& lab, const Ground& ground) {
  cv::Mat3f rest(lab.size());
  for (int row = 0; row < lab.rows; ++row)
    for (int col = 0; col < lab.cols; ++col)
      rest(row, col) = lab(row, col) - cv::Vec3f(ground.At(MonomialsAt(col, row, lab.size())));
  return rest;
}

cv::Mat1b FillHoles(const cv::Mat1b& mask) {
  cv::Mat1b padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::floodFill(padded, {0, 0}, 2);
  const cv::Mat1b filled = (padded != 2) / 255;
  return filled(cv::Rect(1, 1, mask.cols, mask.rows)).clone();
}

struct Part {
  int label = 0;
  double area = 0;
  cv::Rect box;
};

std::vector<Part> ListParts(const cv::Mat1b& mask, cv::Mat1i* labels) {
  cv::Mat stats, centroids;
  const int count = cv::connectedComponentsWithStats(mask, *labels, stats, centroids);
  std::vector<Part> parts;
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    parts.push_back(
        {i,
         double(s[cv::CC_STAT_AREA]),
         {s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]}});
  }
  return parts;
}

// The sides of the picture that a box touches.
std::string TouchedSides(const cv::Rect& box, cv::Size size) {
  std::string text;
  const auto add = [&](bool touches, const char* name) {
    if (touches) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(box.y <= 0, "top");
  add(box.br().y >= size.height, "bottom");
  add(box.x <= 0, "left");
  add(box.br().x >= size.width, "right");
  return text;
}

// Where a disc of the ground's colour hides so much of the cloth that only pieces of it are seen
// around the disc: the pieces and the disc. Nothing where they do not lie around one.
std::optional<cv::Mat1b> JoinAroundDisc(const PhotoPlanes& planes, const cv::Mat1i& labels,
                                        const std::vector<Part>& parts, double largest) {
  constexpr double kLeastPiece = 0.05;  // of the largest
  constexpr double kMostOutside = 0.1;  // of the pieces' area
  cv::Mat1b pieces = cv::Mat1b::zeros(labels.size());
  for (const Part& part : parts)
    if (part.area >= kLeastPiece * largest) pieces |= (labels == part.label) / 255;
  const std::optional<DiscRim> rim = FindDisc(planes, FilledHull(pieces));
  if (!rim) return std::nullopt;
  cv::Mat1b joined = pieces.clone();
  cv::RotatedRect wider = rim->ellipse;
  wider.size.width += 8;
  wider.size.height += 8;
  cv::ellipse(joined, wider, 1, cv::FILLED);
  cv::Mat1i parts_of_joined;
  double inside = 0, all = 0;
  for (const Part& part : ListParts(joined, &parts_of_joined)) {
    inside = std::max(inside, part.area);
    all += part.area;
  }
  if (all - inside > kMostOutside * cv::countNonZero(pieces)) return std::nullopt;
  cv::ellipse(pieces, rim->ellipse, 1, cv::FILLED);
  return pieces;
}

struct Picked {
  cv::Mat1b mask;
  cv::Rect box;
  double other = 0.0;  // area of the largest other part, of the cloth's
  int other_label = 0;
};
Picked PickNearest(const cv::Mat1i& labels, const std::vector<Part>& parts, double largest) {
  constexpr double kCandidate = 1.0 / 8;  // of the largest part
  const double column = 0.5 * (labels.cols - 1), row = 0.5 * (labels.rows - 1);
  const Part* cloth = nullptr;
  double nearest = HUGE_VAL;
  for (int r = 0; r < labels.rows; ++r)
    for (int c = 0; c < labels.cols; ++c) {
      const double distance = std::hypot(c - column, r - row);
      if (labels(r, c) == 0 || distance >= nearest) continue;
      const Part& part = parts[size_t(labels(r, c)) - 1];
      if (part.area < kCandidate * largest) continue;
      cloth = &part;
      nearest = distance;
    }
  Picked picked{FillHoles((labels == cloth->label) / 255), cloth->box};
  const double area = cv::countNonZero(picked.mask);
  for (const Part& part : parts)
    if (&part != cloth && part.area / area > picked.other) {
      picked.other = part.area / area;
      picked.other_label = part.label;
    }
  return picked;
}

// The one piece of cloth, without holes, among the parts of a mask: the part nearest to the
// picture's centre among those that are not small beside the largest, or the pieces around a disc
// that hides the rest. Throws PhotoFailure where there is none, two, or one that is cut off.
cv::Mat1b PickCloth(const PhotoPlanes& planes, const PhotoOptions& options, const cv::Mat1b& mask,
                    std::vector<std::string>* warnings) {
  constexpr double kLeastShare = 0.0001;              // of the picture
  constexpr double kSecond = 1.0 / 2, kNoted = 0.02;  // of the cloth
  constexpr double kBroken = 0.1;  // of the cloth, from which on it may be in pieces
  cv::Mat1i labels;
  const std::vector<Part> parts = ListParts(FillHoles(mask), &labels);
  double largest = 0;
  for (const Part& part : parts) largest = std::max(largest, part.area);
  if (largest < kLeastShare * double(mask.total()))
    throw PhotoFailure{PhotoFault::kNoCloth,
                       "nothing differs from the ground, expected one piece of cloth on a plain "
                       "ground"};
  const Picked picked = PickNearest(labels, parts, largest);
  if (const std::string sides = TouchedSides(picked.box, mask.size()); !sides.empty())
    throw PhotoFailure{PhotoFault::kCroppedCloth,
                       "the cloth touches the edge of the picture at the " + sides +
                           ", expected ground all around it",
                       {LongestOutline(picked.mask)}};
  if (picked.other > kBroken && options.marker == PhotoMarker::kDisc)
    if (const auto joined = JoinAroundDisc(planes, labels, parts, largest)) return *joined;
  if (picked.other > kSecond)
    throw PhotoFailure{
        PhotoFault::kTwoSpecimens,
        "two pieces of similar size, expected one piece of cloth",
        {LongestOutline(picked.mask), LongestOutline((labels == picked.other_label) / 255)}};
  if (picked.other > kNoted)
    warnings->push_back(
        Format("something else lies beside the cloth, as large as %.0f %% of it; "
               "it is left out",
               100 * picked.other));
  return picked.mask;
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

// The distance from the ground's colour, `rest` being the colours less it.
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
