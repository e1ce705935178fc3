// SPDX-License-Identifier: Apache-2.0
#include "losses/image/cloth_mask.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/image/disc.h"
#include "losses/image/image.h"
#include "losses/image/photo_planes.h"
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
  for (int c = 0; c < 3; ++c) ground.coefficients(0, c) = Quantile(channel[c]);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> errors;
    for (size_t i = 0; i < places.size(); ++i)
      errors.push_back(static_cast<float>(cv::norm(cv::Vec3d(colors[i]) - ground.At(places[i]))));
    ground.noise = std::max(0.3, kNoiseOfFactor / std::sqrt(3.0) * Quantile(errors));
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

int64_t LargestPart(const std::vector<MaskPart>& parts) {
  int64_t largest = 0;
  for (const MaskPart& part : parts) largest = std::max(largest, part.pixels);
  return largest;
}

// The one piece of cloth, without holes, among the parts of a mask. Throws PhotoFailure where there
// is none, two, or one that is cut off.
cv::Mat1b PickCloth(const cv::Mat1b& mask, std::vector<std::string>* notes) {
  constexpr double kLeastShare = 0.0001;              // of the picture
  constexpr double kSecond = 1.0 / 2, kNoted = 0.02;  // of the cloth
  cv::Mat1i labels;
  const std::vector<MaskPart> parts = ListParts(FillHoles(mask), 8, &labels);
  if (static_cast<double>(LargestPart(parts)) < kLeastShare * double(mask.total()))
    throw PhotoFailure{PhotoFault::kNoCloth,
                       "nothing differs from the ground, expected one piece of cloth on a plain "
                       "ground"};
  const MaskPart& cloth = NearestPart(labels, parts);
  cv::Mat1b picked = FillHoles((labels == cloth.label) / 255);
  if (const std::string sides = TouchedSides(cloth.box, mask.size()); !sides.empty())
    throw PhotoFailure{PhotoFault::kCroppedCloth,
                       "the cloth touches the edge of the picture at the " + sides +
                           ", expected ground all around it",
                       {LongestOutline(picked)}};
  const MaskPart* other = nullptr;
  for (const MaskPart& part : parts)
    if (&part != &cloth && (other == nullptr || part.pixels > other->pixels)) other = &part;
  const double share = other ? double(other->pixels) / double(cloth.pixels) : 0.0;
  if (share > kSecond)
    throw PhotoFailure{PhotoFault::kTwoSpecimens,
                       "two pieces of similar size, expected one piece of cloth",
                       {LongestOutline(picked), LongestOutline((labels == other->label) / 255)}};
  if (share > kNoted)
    notes->push_back(
        Format("something else lies beside the cloth, as large as %.0f %% of it; "
               "it is left out",
               100 * share));
  return picked;
}

Feature WithOtsuThreshold(const cv::Mat1f& value) {
  double least = 0, most = 0;
  cv::minMaxLoc(value, &least, &most);
  Feature feature{value, 0.5 * (least + most)};
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
  std::transform(rest.begin(), rest.end(), distance.begin(), [](const cv::Vec3f& color) {
    return static_cast<float>(std::min(cv::norm(color), 100.0));
  });
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
      curve(0, i)[c] = static_cast<float>(std::min(1.0, t * Quantile(channel[c])));
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
    cv::Mat1f value;
    cv::transform(rest, value, w.t());
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
cv::Mat1b GrabCut(const PhotoPlanes& planes, const cv::Mat1b& mask, const ClothHints& hints) {
  constexpr double kSide = 350;
  constexpr int kRounds = 4;         // at most,
  constexpr double kSettled = 1e-3;  // until so few pixels change
  const double shrink = std::min(1.0, kSide / std::max(mask.rows, mask.cols));
  cv::Mat3b small;
  cv::Mat1b small_mask;
  cv::resize(planes.rgb, small, {}, shrink, shrink, cv::INTER_AREA);
  cv::resize(mask, small_mask, small.size(), 0, 0, cv::INTER_NEAREST);
  cv::Mat1b labels(small.size());
  labels.setTo(cv::GC_PR_BGD);
  labels.setTo(cv::GC_PR_FGD, small_mask);
  labels.setTo(cv::GC_BGD, BorderMask(small.size()));
  ApplyPoints(hints.cloth_points, planes.scale * shrink, cv::GC_FGD, "cloth_points", &labels);
  ApplyPoints(hints.ground_points, planes.scale * shrink, cv::GC_BGD, "ground_points", &labels);
  cv::Mat background, foreground;
  cv::theRNG().state = 1;
  for (int round = 0; round < kRounds; ++round) {
    const cv::Mat1b before = labels.clone();
    cv::grabCut(small, labels, {}, background, foreground, 1,
                round == 0 ? cv::GC_INIT_WITH_MASK : cv::GC_EVAL);
    if (cv::countNonZero(before != labels) <= kSettled * double(labels.total())) break;
  }
  cv::Mat1b changed;
  cv::resize((labels & 1) != small_mask, changed, mask.size(), 0, 0, cv::INTER_NEAREST);
  cv::bitwise_xor(mask, changed / 255, changed);  // elsewhere the outline stays fine
  return changed;
}

// The hull of all parts of a mask that are not small beside the largest: a disc of the
// ground's colour may hide so much of the cloth that only pieces of it are seen around the disc.
cv::Mat1b HullOfPieces(cv::Mat1b mask) {
  constexpr double kLeastPiece = 0.05;  // of the largest
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, RoundElement(3));
  cv::Mat1i labels;
  const std::vector<MaskPart> parts = ListParts(mask, 8, &labels);
  cv::Mat1b pieces = cv::Mat1b::zeros(mask.size());
  const double least = kLeastPiece * static_cast<double>(LargestPart(parts));
  for (const MaskPart& part : parts)
    if (static_cast<double>(part.pixels) >= least && TouchedSides(part.box, mask.size()).empty())
      pieces |= (labels == part.label) / 255;
  return FilledHull(pieces);
}

// The outline of the cloth by all features, and the disc inside it: in a smaller picture, since the
// outline moves to its place in RefineCloth.
ChosenOutline FindOutline(const PhotoPlanes& whole, const Ground& ground, cv::Mat1b* disc) {
  constexpr double kLeast = 2.0, kOfNoise = 3.0;  // [Lab units]
  constexpr double kSide = 1000;                  // [px]
  const cv::Size size = whole.lab.size();
  const double shrink = std::min(1.0, kSide / std::max(size.width, size.height));
  PhotoPlanes planes;
  cv::resize(whole.rgb, planes.rgb, {}, shrink, shrink, cv::INTER_AREA);
  cv::resize(whole.lab, planes.lab, {}, shrink, shrink, cv::INTER_AREA);
  const cv::Mat3f rest = WithoutGround(planes.lab, ground);
  auto second = std::async([&] { return ShadowedFeature(planes, rest, BorderMask(rest.size())); });
  Feature distance = DistanceFeature(rest);
  const Feature discriminant = DiscriminantFeature(rest, distance.Mask());
  Feature shadowed = second.get();
  distance.is_distance = shadowed.is_distance = true;
  const cv::Mat1b all = (distance.value > std::max(kLeast, kOfNoise * ground.noise)) / 255;
  *disc = cv::Mat1b::zeros(all.size());
  for (const cv::Mat1b& region : {shadowed.Mask(), all})
    if (const auto rim = FindDisc(planes, HullOfPieces(region))) {
      cv::ellipse(*disc, rim->ellipse, 1, cv::FILLED);
      break;
    }
  ChosenOutline chosen = ChooseOutline(planes.lab, {distance, shadowed, discriminant},
                                       shadowed.value, *disc, ground.noise);
  cv::resize(*disc, *disc, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(chosen.feature.value, chosen.feature.value, size);
  return chosen;
}

// Paints the ground over a dark frame, which lies around a lit field, and returns the ground.
Ground PaintFrameOver(const cv::Mat1b& lit, PhotoPlanes* planes) {
  constexpr double kMargin = 0.02, kBand = 0.03;  // of the field's side
  const cv::Mat1b field = LargestFilled(lit);
  const double side = std::sqrt(double(cv::countNonZero(field)));
  cv::Mat1f inside;
  cv::distanceTransform(field, inside, cv::DIST_L2, cv::DIST_MASK_5);
  const cv::Mat1b kept = (inside > kMargin * side) / 255;
  const Ground ground = FitGround(planes->lab, kept & (inside < (kMargin + kBand) * side) / 255);
  const cv::Mat3f painted = planes->lab - WithoutGround(planes->lab, ground);
  const cv::Mat1b frame = 1 - kept;
  cv::Mat3f light, stored;
  cv::cvtColor(painted, light, cv::COLOR_Lab2LRGB);
  cv::cvtColor(painted, stored, cv::COLOR_Lab2RGB);
  cv::Mat1f luma(lit.size());
  std::transform(stored.begin(), stored.end(), luma.begin(),
                 [](const cv::Vec3f& color) { return LumaLight(Eigen::Vector3f(color.val)); });
  const auto paint = [&](const auto& color, auto* plane) {
    *plane = plane->clone();
    color.copyTo(*plane, frame);
  };
  paint(painted, &planes->lab);
  paint(light, &planes->light);
  paint(luma, &planes->luma);
  paint(cv::Mat3b(255 * stored), &planes->rgb);
  return ground;
}

// The mask of a file, at the working size.
cv::Mat1b ReadMask(const std::string& path, const PhotoPlanes& planes) {
  const GrayImage picture = ReadImage(path);
  if (cv::Size(picture.width, picture.height) != planes.size)
    throw InputError(path,
                     Format("mask is %dx%d px, expected the photograph's %dx%d", picture.width,
                            picture.height, planes.size.width, planes.size.height));
  cv::Mat1f resized;
  cv::resize(CoveragePlane(picture), resized, planes.rgb.size(), 0, 0, cv::INTER_AREA);
  cv::Mat1b mask = (resized > 0.5f) / 255;
  if (const double share = cv::mean(mask)[0]; share == 0 || share == 1)
    throw InputError(path, "mask is of one colour, expected black where the cloth is, and white");
  return mask;
}

}  // namespace

std::vector<MaskPart> ListParts(const cv::Mat1b& mask, int neighbours, cv::Mat1i* labels) {
  cv::Mat stats, centroids;
  const int count =
      cv::connectedComponentsWithStats(mask, *labels, stats, centroids, neighbours, CV_32S);
  std::vector<MaskPart> parts;
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const auto* c = centroids.ptr<double>(i);
    parts.push_back(
        {i,
         s[cv::CC_STAT_AREA],
         {s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]},
         {c[0], c[1]}});
  }
  return parts;
}

const MaskPart& NearestPart(const cv::Mat1i& labels, const std::vector<MaskPart>& parts) {
  constexpr double kCandidate = 1.0 / 8;  // of the largest part
  const double least = kCandidate * static_cast<double>(LargestPart(parts));
  const double column = 0.5 * (labels.cols - 1), row = 0.5 * (labels.rows - 1);
  const MaskPart* nearest = &parts.front();
  double distance = HUGE_VAL;
  for (int r = 0; r < labels.rows; ++r)
    for (int c = 0; c < labels.cols; ++c) {
      if (labels(r, c) == 0 || std::hypot(c - column, r - row) >= distance) continue;
      const MaskPart& part = parts[size_t(labels(r, c)) - 1];
      if (static_cast<double>(part.pixels) < least) continue;
      nearest = &part;
      distance = std::hypot(c - column, r - row);
    }
  return *nearest;
}

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

cv::Mat1b FillHoles(const cv::Mat1b& mask) {
  cv::Mat1b padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::floodFill(padded, {0, 0}, 2);
  const cv::Mat1b filled = (padded != 2) / 255;
  return filled(cv::Rect(1, 1, mask.cols, mask.rows)).clone();
}

RoughCloth FindCloth(const ClothHints& hints, PhotoPlanes* planes) {
  constexpr double kUneven = 15.0;     // [Lab units] of the ground, from which on it is refused
  constexpr double kLeastShare = 0.8;  // of the outline that is an edge
  constexpr double kLeastDifference = 3.0;  // [Lab units] more than the pieces that noise makes
  const cv::Mat1b border = BorderMask(planes->lab.size());
  Ground ground = FitGround(planes->lab, border);
  RoughCloth rough;
  cv::Mat1b mask, disc = cv::Mat1b::zeros(border.size());
  if (!hints.mask.empty()) {
    mask = ReadMask(hints.mask, *planes);
  } else {
    if (ground.noise > kUneven && !hints.has_points())
      throw PhotoFailure{PhotoFault::kUnevenGround,
                         Format("the ground is uneven: its colour varies by %.0f Lab units along "
                                "the edge of the picture, expected at most %.0f",
                                ground.noise, kUneven)};
    ChosenOutline chosen = FindOutline(*planes, ground, &disc);
    if (chosen.is_frame && !hints.has_points()) {
      rough.notes.emplace_back("a frame around the ground is left out");
      rough.has_frame = true;
      ground = PaintFrameOver(chosen.feature.Mask(), planes);
      chosen = FindOutline(*planes, ground, &disc);
    }
    if (chosen.has_shadow) rough.notes.emplace_back("a shadow beside the cloth is left out");
    if (chosen.may_lack_shade)
      rough.notes.emplace_back(
          "cloth and ground are of one hue: a part of the cloth in shade may pass for a shadow");
    if (hints.threshold > 0) {
      const Feature distance = DistanceFeature(WithoutGround(planes->lab, ground));
      double most = 0;
      cv::minMaxLoc(distance.value, nullptr, &most);
      chosen.feature = {distance.value, hints.threshold * most};
      chosen.share = 1;
    }
    mask = chosen.feature.Mask();
    if (hints.has_points() || chosen.share < kLeastShare) mask = GrabCut(*planes, mask, hints);
    if (!hints.has_points() &&
        cv::norm(cv::mean(WithoutGround(planes->lab, ground), mask)) < kLeastDifference)
      throw PhotoFailure{PhotoFault::kNoCloth,
                         "nothing differs from the ground, expected one piece of cloth on a plain "
                         "ground"};
  }
  rough.ground_noise = ground.noise;
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, RoundElement(rough.has_lines() ? 4 : 2));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, RoundElement(2));
  rough.pieces = mask | disc;
  rough.mask = PickCloth(rough.pieces, &rough.notes);
  return rough;
}

}  // namespace drape
