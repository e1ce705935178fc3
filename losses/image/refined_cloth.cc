// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <future>
#include <opencv2/imgproc.hpp>

#include "losses/image/cloth_mask.h"
#include "losses/image/photo_planes.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kBand = 5;                // [px] on either side, in which the outline may move
constexpr double kWindowShare = 0.02;   // of the longer side: the neighbourhood
constexpr int kApart = 4;               // [px] from the outline, where colours are unmixed
constexpr int kMixed = 3;               // [px] from the disc, where colours are mixed with its own
constexpr int kStrip = 8;               // [px] from the disc, where the cloth may be a thin strip
constexpr double kLeastContrast = 5.0;  // [Lab units]
constexpr double kContrastOfNoise = 2.5;  // standard deviations of the ground

int WindowSide(const cv::Mat& picture) {
  return 2 * static_cast<int>(kWindowShare * std::max(picture.rows, picture.cols) / 2) + 1;
}

// The mean colour in the neighbourhood of each pixel over the pixels of a mask, and the mask's
// share of the neighbourhood; the mean of all of them where there are none.
struct LocalMean {
  cv::Mat3f color;
  cv::Mat1f weight;

  LocalMean(const cv::Mat3f& colors, const cv::Mat1b& mask, int window)
      : color(cv::Mat3f::zeros(colors.size())) {
    constexpr float kLeastWeight = 0.004f;
    colors.copyTo(color, mask);
    mask.convertTo(weight, CV_32F);
    cv::blur(color, color, {window, window});
    cv::blur(weight, weight, {window, window});
    const cv::Scalar all = cv::mean(colors, mask);
    const cv::Vec3f mean(static_cast<float>(all[0]), static_cast<float>(all[1]),
                         static_cast<float>(all[2]));
    for (int row = 0; row < colors.rows; ++row)
      for (int col = 0; col < colors.cols; ++col) {
        const float w = weight(row, col);
        color(row, col) = w > kLeastWeight ? color(row, col) / w : mean;
      }
  }
};

// The colours that cloth and ground have near each pixel of the outline.
struct Sides {
  cv::Mat3f cloth, ground;
};
// Computes both at the same time.
template <class Cloth, class Ground>
Sides MakeSides(const Cloth& cloth, const Ground& ground) {
  std::future<cv::Mat3f> other = std::async(ground);
  return {cloth(), other.get()};
}
Sides WideSides(const cv::Mat3f& colors, const cv::Mat1b& mask, const cv::Mat1b& disc, int window) {
  const cv::Mat1b inner = Eroded(mask, kApart).mul(1 - Dilated(disc, kApart));
  return MakeSides([&] { return LocalMean(colors, inner, window).color; },
                   [&] { return LocalMean(colors, 1 - Dilated(mask, kApart), window).color; });
}

// The colour that one side has at the outline: its mean over a ring along the outline, extrapolated
// by that over the next ring, since folds and shadows have a shade of their own there; `wide` where
// the side is too narrow for rings. `distance`: from the outline into the side [px].
cv::Mat3f ColorAtOutline(const cv::Mat3f& colors, const cv::Mat1f& distance, const cv::Mat1b& side,
                         const cv::Mat3f& wide) {
  constexpr double kRing[] = {3.0, 7.0, 11.0};
  constexpr float kLeastWeight = 0.1f;
  constexpr int kWindow = 15;
  constexpr double kBeyond = (kRing[1] + kRing[0]) / (kRing[2] - kRing[0]);
  const cv::Mat1b near_ring = ((distance >= kRing[0]) & (distance < kRing[1])) / 255;
  const cv::Mat1b far_ring = ((distance >= kRing[1]) & (distance < kRing[2])) / 255;
  const LocalMean nearer(colors, near_ring.mul(side), kWindow);
  const LocalMean farther(colors, far_ring.mul(side), kWindow);
  cv::Mat3f result = wide.clone();
  for (int row = 0; row < colors.rows; ++row)
    for (int col = 0; col < colors.cols; ++col) {
      if (nearer.weight(row, col) < kLeastWeight) continue;
      const cv::Vec3f& here = nearer.color(row, col);
      result(row, col) = here;
      if (farther.weight(row, col) >= kLeastWeight)
        result(row, col) += static_cast<float>(kBeyond) * (here - farther.color(row, col));
    }
  return result;
}
Sides NearSides(const cv::Mat3f& colors, const cv::Mat1b& mask, const cv::Mat1b& disc, int window) {
  const Sides wide = WideSides(colors, mask, disc, window);
  const auto find = [&](const cv::Mat1b& part, const cv::Mat1b& side, const cv::Mat3f& color) {
    cv::Mat1f distance;
    cv::distanceTransform(part, distance, cv::DIST_L2, cv::DIST_MASK_5);
    return ColorAtOutline(colors, distance, side, color);
  };
  return MakeSides([&] { return find(mask, mask.mul(1 - Dilated(disc, kApart)), wide.cloth); },
                   [&] { return find(1 - mask, 1 - mask, wide.ground); });
}

// Each pixel near the outline has the light of disc, cloth and ground by their shares, also
// where a lens has blurred a strip of cloth between disc and ground; the disc's share is known. The
// share of disc and cloth together, 0 … 1.
cv::Mat1f ShareOfLight(const PhotoPlanes& planes, const Sides& sides, const cv::Mat1f& disc,
                       const cv::Mat3f& disc_light, const cv::Mat1b& band) {
  const auto color = [](const cv::Vec3f& light) { return Eigen::Vector3f(light.val); };
  cv::Mat1f share = cv::Mat1f::zeros(band.size());
  for (int row = 0; row < band.rows; ++row)
    for (int col = 0; col < band.cols; ++col) {
      if (!band(row, col)) continue;
      const Eigen::Vector3f ground = color(sides.ground(row, col));
      const float d = disc(row, col);
      Eigen::Vector4f seen;
      seen << color(planes.light(row, col)), planes.luma(row, col);
      share(row, col) =
          d + ShareOfMixture(seen, ground + d * (color(disc_light(row, col)) - ground),
                             color(sides.cloth(row, col)) - ground);
    }
  return share;
}

// How far each pixel of the picture is from the ground's colour to the cloth's, 0 … 1, near the
// outline of a mask, and their contrast there.
struct Position {
  cv::Mat1f share, contrast;
};
Position Locate(const cv::Mat3f& colors, const Sides& sides) {
  constexpr float kLeastSquared = 1e-6f;
  Position position{cv::Mat1f(colors.size()), cv::Mat1f(colors.size())};
  for (int row = 0; row < colors.rows; ++row)
    for (int col = 0; col < colors.cols; ++col) {
      const cv::Vec3f& ground = sides.ground(row, col);
      const cv::Vec3f across = sides.cloth(row, col) - ground;
      const float squared = std::max(across.dot(across), kLeastSquared);
      position.share(row, col) = (colors(row, col) - ground).dot(across) / squared;
      position.contrast(row, col) = std::sqrt(squared);
    }
  return position;
}

// The same by the nearest of the colours that either side has in the neighbourhood, for a print, of
// which a part is more like the ground than like its mean, and for a ruled ground.
Position LocateInPattern(const cv::Mat3f& colors, const cv::Mat1b& mask, const cv::Mat1b& disc) {
  constexpr int kReach = 21, kStride = 3;   // [px]
  constexpr double kMixedShare = 1 / 16.0;  // of the nearest
  const cv::Mat1b cloth = Eroded(mask, kApart).mul(1 - Dilated(disc, kApart));
  const cv::Mat1b side = (1 - Dilated(mask, kApart)) + 2 * cloth;
  const cv::Mat1b band = Dilated(mask, kBand) - Eroded(mask, kBand);
  Position position{cv::Mat1f(mask), cv::Mat1f::zeros(mask.size())};
  for (int row = 0; row < mask.rows; ++row)
    for (int col = 0; col < mask.cols; ++col) {
      if (!band(row, col)) continue;
      std::vector<float> apart[3];  // from neither, the ground, the cloth
      for (int r = std::max(row - kReach, 0); r < std::min(row + kReach, mask.rows); r += kStride)
        for (int c = std::max(col - kReach, 0); c < std::min(col + kReach, mask.cols); c += kStride)
          apart[side(r, c)].push_back(float(cv::norm(colors(r, c) - colors(row, col))));
      if (apart[1].empty() || apart[2].empty()) continue;
      const float ground = Quantile(apart[1], kMixedShare);
      position.contrast(row, col) = ground + Quantile(apart[2], kMixedShare);
      position.share(row, col) = ground / std::max(position.contrast(row, col), 1e-6f);
    }
  return position;
}

// Whether the mean colours fail to tell cloth and ground apart. The light of a ground's lines
// counts, too; the cloth's has shades.
bool HasPattern(const PhotoPlanes& planes, const cv::Mat1b& mask, const cv::Mat1b& disc,
                int window) {
  constexpr double kMost = 0.015;  // of the pixels on a side
  constexpr int kFar = 15;         // [px] from the outline
  const cv::Mat1b inner = Eroded(mask, kApart) - Eroded(mask, kFar);
  const cv::Mat1b outer = Dilated(mask, kFar) - Dilated(mask, kApart);
  const auto share = [&](const cv::Mat3f& colors) {
    return Locate(colors, WideSides(colors, mask, disc, window)).share;
  };
  std::future<cv::Mat1f> by_light = std::async(share, planes.light);
  const cv::Mat1f by_color = share(planes.lab);
  const cv::Mat1f most = cv::max(by_color, by_light.get());
  return cv::mean(by_color < 0.5f, inner.mul(1 - Dilated(disc, kApart)))[0] > 255 * kMost ||
         cv::mean(most > 0.5f, outer)[0] > 255 * kMost;
}

// Around the disc its colour is mixed with the cloth's, which may look like the ground: no
// gap is left there between disc and cloth.
cv::Mat1b ClosedAroundDisc(const cv::Mat1b& mask, const cv::Mat1b& disc) {
  cv::Mat1b closed, result = mask.clone();
  cv::morphologyEx(mask, closed, cv::MORPH_CLOSE, RoundElement(kMixed));
  closed.copyTo(result, Dilated(disc, kMixed));
  return result;
}

// The standard deviation of the Gaussian that blurs the step from 0 to 1 along an outline [px].
double MeasureBlur(const cv::Mat1f& share, const std::vector<cv::Point>& outline) {
  cv::Mat1f dx, dy;
  cv::Sobel(share, dx, CV_32F, 1, 0, 3, 1 / 8.0);
  cv::Sobel(share, dy, CV_32F, 0, 1, 3, 1 / 8.0);
  std::vector<float> widths;
  for (const cv::Point& p : outline) {
    const float steepness = std::max(std::hypot(dx(p), dy(p)), 1e-3f);
    widths.push_back(static_cast<float>(1 / (steepness * std::sqrt(2 * M_PI))));
  }
  return Quantile(widths, 0.6);
}

void CheckContrast(const RefinedCloth& cloth, double least, const std::vector<cv::Point>& weak) {
  constexpr double kMostWeak = 0.12;
  if (cloth.weak <= kMostWeak) return;
  std::vector<std::vector<cv::Point>> marks;
  for (const cv::Point& p : weak) marks.push_back({p});
  throw PhotoFailure{PhotoFault::kLowContrast,
                     Format("cloth and ground are too alike along %.0f %% of the outline: the "
                            "contrast is below %.0f Lab units (median %.0f), expected a ground of "
                            "another colour or brightness",
                            100 * cloth.weak, least, cloth.contrast),
                     marks};
}

// The cloth around the disc, with the pieces of it that the disc joins.
cv::Mat1b JoinedByDisc(const RoughCloth& rough, const cv::Mat1b& disc) {
  if (cv::countNonZero(disc) == 0) return rough.mask;
  cv::Mat1i labels;
  cv::connectedComponents(rough.mask | disc | rough.pieces | Dilated(disc, kMixed), labels);
  const cv::Moments m = cv::moments(disc, true);
  return (labels == labels(cvRound(m.m01 / m.m00), cvRound(m.m10 / m.m00))) / 255;
}

// Measures the outline of cloth.mask by the contrast of each pixel. Returns the part that is not at
// the disc, or all of it where there is none. Throws PhotoFailure where the contrast is too low.
std::vector<cv::Point> MeasureOutline(const cv::Mat1f& contrast, const cv::Mat1b& disc,
                                      double ground_noise, bool has_pattern, RefinedCloth* cloth) {
  constexpr double kMixedSd = 1.0, kPatternSd = 0.5;  // [px]
  const std::vector<cv::Point> outline = LongestOutline(cloth->mask);
  if (outline.empty())
    throw PhotoFailure{PhotoFault::kNoCloth, "nothing is left of the cloth near its outline"};
  const double least = std::max(kLeastContrast, kContrastOfNoise * ground_noise);
  const cv::Mat1b near_disc = Dilated(disc, kMixed + 1);
  double at_disc = 0;  // share of the outline
  std::vector<float> contrasts;
  std::vector<cv::Point> weak, clear;
  for (const cv::Point& p : outline) {
    at_disc += near_disc(p) / double(outline.size());
    if (!near_disc(p)) clear.push_back(p);
    contrasts.push_back(contrast(p));
    if (contrasts.back() < least) weak.push_back(p);
  }
  cloth->mixed_sd = std::hypot(kMixedSd * at_disc, has_pattern ? kPatternSd : 0.0);
  cloth->contrast = Quantile(contrasts);
  cloth->weak = double(weak.size()) / double(outline.size());
  CheckContrast(*cloth, least, weak);
  return clear.empty() ? outline : clear;
}

// RefineCloth in a part of the picture, for a mask there and the side of the neighbourhood.
RefinedCloth RefinePart(const PhotoPlanes& planes, const RoughCloth& rough, const cv::Mat1b& mask,
                        const cv::Mat1f& disc_coverage, int window) {
  constexpr int kRounds = 4, kLightRounds = 2;
  const cv::Mat1b disc = (disc_coverage > 0.5f) / 255;
  RefinedCloth cloth;
  cloth.mask = mask.clone();
  const bool has_pattern = HasPattern(planes, cloth.mask, disc, window);
  const auto locate = [&](const cv::Mat3f& colors) {
    return has_pattern ? LocateInPattern(colors, cloth.mask, disc)
                       : Locate(colors, WideSides(colors, cloth.mask, disc, window));
  };
  const auto move = [&](const cv::Mat3f& colors, int reach) {
    const cv::Mat1b band = Dilated(cloth.mask, reach) - Eroded(cloth.mask, reach);
    cv::Mat1b moved = cloth.mask.clone(), above = (locate(colors).share > 0.5f) / 255;
    above.copyTo(moved, band);
    cv::Mat1f majority(moved);
    if (has_pattern) cv::GaussianBlur(majority, majority, {}, 2.0);
    moved = (majority > 0.5f) / 255;
    cv::morphologyEx(moved, moved, cv::MORPH_OPEN, RoundElement(rough.has_lines() ? 3 : 1));
    moved = LargestFilled(ClosedAroundDisc(moved | disc, disc));
    std::swap(moved, cloth.mask);
    return cv::countNonZero(moved != cloth.mask) > 0;
  };
  for (int round = 0; round < kRounds && move(planes.lab, kBand);) ++round;
  const Position position = locate(planes.lab);
  const cv::Mat3f disc_light = LocalMean(planes.light, Eroded(disc, kApart), window).color;
  if (has_pattern) {
    move(planes.light, 2);
    cv::GaussianBlur(cv::Mat1f(cloth.mask), cloth.coverage, {}, 1.0);
  }
  for (int round = 0; round < kLightRounds; ++round) {
    cv::Mat1b band = (Dilated(cloth.mask, 2) | Dilated(disc, kStrip)) - Eroded(cloth.mask, 2);
    if (has_pattern) band &= Dilated(disc, kStrip);
    if (!has_pattern) cloth.mask.convertTo(cloth.coverage, CV_32F);
    ShareOfLight(planes, NearSides(planes.light, cloth.mask, disc, window), disc_coverage,
                 disc_light, band)
        .copyTo(cloth.coverage, band);
    cloth.coverage = cv::min(cv::max(cloth.coverage, disc_coverage), 1.0f);
    cloth.mask = LargestFilled((cloth.coverage > 0.5f) / 255);
  }
  const std::vector<cv::Point> clear =
      MeasureOutline(position.contrast, disc, rough.ground_noise, has_pattern, &cloth);
  cloth.blur = MeasureBlur(locate(planes.light).share, clear);
  return cloth;
}

}  // namespace

RefinedCloth RefineCloth(const PhotoPlanes& planes, const RoughCloth& rough,
                         const cv::Mat1f& disc_coverage) {
  const int window = WindowSide(planes.light);
  const cv::Mat1b disc = (disc_coverage > 0.5f) / 255, mask = JoinedByDisc(rough, disc);
  // What is farther away is no neighbour of the outline.
  const int margin = 2 * window;
  cv::Rect part = cv::boundingRect(mask | disc);
  part += cv::Size(2 * margin, 2 * margin);
  part = (part - cv::Point(margin, margin)) & cv::Rect({}, mask.size());
  PhotoPlanes there = planes;
  there.light = planes.light(part);
  there.luma = planes.luma(part);
  there.lab = planes.lab(part);
  RefinedCloth cloth;
  try {
    cloth = RefinePart(there, rough, mask(part), disc_coverage(part), window);
  } catch (PhotoFailure& failure) {
    for (auto& mark : failure.marks)
      for (cv::Point& point : mark) point += part.tl();
    throw;
  }
  const auto whole = [&](const auto& found) {
    std::decay_t<decltype(found)> placed = std::decay_t<decltype(found)>::zeros(mask.size());
    found.copyTo(placed(part));
    return placed;
  };
  cloth.mask = whole(cloth.mask);
  cloth.coverage = whole(cloth.coverage);
  return cloth;
}

}  // namespace drape
