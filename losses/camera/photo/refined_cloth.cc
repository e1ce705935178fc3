// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/camera/photo/cloth_mask.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kApart = 4;                 // [px] from the outline, where colours are unmixed
constexpr int kBand = 10;                 // [px] on either side, in which the outline may move
constexpr double kWindowShare = 0.02;     // of the longer side: the neighbourhood
constexpr double kLeastContrast = 5.0;    // [Lab units]
constexpr double kContrastOfNoise = 2.5;  // standard deviations of the ground

cv::Mat1b Disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}
cv::Mat1b Eroded(const cv::Mat1b& mask, int radius) {
  cv::Mat1b eroded;
  cv::erode(mask, eroded, Disc(radius));
  return eroded;
}
cv::Mat1b Dilated(const cv::Mat1b& mask, int radius) {
  cv::Mat1b dilated;
  cv::dilate(mask, dilated, Disc(radius));
  return dilated;
}

// The mean colour in the neighbourhood of each pixel over the pixels of a mask; the mean of all of
// them where there are none.
cv::Mat3f LocalMean(const cv::Mat3f& lab, const cv::Mat1b& mask, int window) {
  cv::Mat3f chosen = cv::Mat3f::zeros(lab.size());
  lab.copyTo(chosen, mask);
  cv::Mat1f weight;
  mask.convertTo(weight, CV_32F);
  cv::blur(chosen, chosen, {window, window});
  cv::blur(weight, weight, {window, window});
  const cv::Scalar all = cv::mean(lab, mask);
  const cv::Vec3f mean(static_cast<float>(all[0]), static_cast<float>(all[1]),
                       static_cast<float>(all[2]));
  constexpr float kLeastWeight = 0.004f;
  for (int row = 0; row < lab.rows; ++row)
    for (int col = 0; col < lab.cols; ++col) {
      const float w = weight(row, col);
      chosen(row, col) = w > kLeastWeight ? chosen(row, col) / w : mean;
    }
  return chosen;
}

// How far each pixel of the picture is from the ground's colour to the cloth's, 0 … 1, near the
// outline of a mask, and their contrast there.
struct Position {
  cv::Mat1f share, contrast;
};
Position Locate(const cv::Mat3f& lab, const cv::Mat1b& mask, const cv::Mat1b& disc) {
  const int window = 2 * static_cast<int>(kWindowShare * std::max(lab.rows, lab.cols) / 2) + 1;
  const cv::Mat1b inner = Eroded(mask, kApart).mul(1 - Dilated(disc, kApart));
  const cv::Mat3f cloth = LocalMean(lab, inner, window);
  const cv::Mat3f ground = LocalMean(lab, 1 - Dilated(mask, kApart), window);
  Position position{cv::Mat1f(lab.size()), cv::Mat1f(lab.size())};
  for (int row = 0; row < lab.rows; ++row)
    for (int col = 0; col < lab.cols; ++col) {
      const cv::Vec3f across = cloth(row, col) - ground(row, col);
      const float squared = std::max(across.dot(across), 1e-3f);
      position.share(row, col) = (lab(row, col) - ground(row, col)).dot(across) / squared;
      position.contrast(row, col) = std::sqrt(squared);
    }
  return position;
}

cv::Mat1b LargestFilled(const cv::Mat1b& mask) {
  cv::Mat1b filled = cv::Mat1b::zeros(mask.size());
  const std::vector<cv::Point> outline = LongestOutline(mask);
  if (!outline.empty())
    cv::drawContours(filled, std::vector<std::vector<cv::Point>>{outline}, 0, 1, cv::FILLED);
  return filled;
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
  const auto high = widths.begin() + static_cast<long>(0.6 * double(widths.size()));
  std::nth_element(widths.begin(), high, widths.end());
  return *high;
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

}  // namespace

RefinedCloth RefineCloth(const PhotoPlanes& planes, const RoughCloth& rough,
                         const cv::Mat1b& disc) {
  constexpr int kRounds = 4;
  RefinedCloth cloth;
  cloth.mask = (rough.mask | disc);
  Position position;
  for (int round = 0; round < kRounds; ++round) {
    position = Locate(planes.lab, cloth.mask, disc);
    const cv::Mat1b band = Dilated(cloth.mask, kBand) - Eroded(cloth.mask, kBand);
    cv::Mat1b moved = cloth.mask.clone();
    cv::Mat1b above = (position.share > 0.5f) / 255;
    above.copyTo(moved, band);
    cv::morphologyEx(moved, moved, cv::MORPH_OPEN, Disc(1));
    cloth.mask = LargestFilled(moved | disc);
  }
  position = Locate(planes.lab, cloth.mask, disc);
  const cv::Mat1b band = Dilated(cloth.mask, 2) - Eroded(cloth.mask, 2);
  cloth.mask.convertTo(cloth.coverage, CV_32F);
  position.share.copyTo(cloth.coverage, band.mul(1 - Dilated(disc, 1)));
  cloth.coverage = cv::min(cv::max(cloth.coverage, 0.0f), 1.0f);
  const std::vector<cv::Point> outline = LongestOutline(cloth.mask);
  const double least = std::max(kLeastContrast, kContrastOfNoise * rough.ground_noise);
  std::vector<float> contrasts;
  std::vector<cv::Point> weak;
  for (const cv::Point& p : outline) {
    contrasts.push_back(position.contrast(p));
    if (contrasts.back() < least) weak.push_back(p);
  }
  if (contrasts.empty())
    throw PhotoFailure{PhotoFault::kNoCloth, "nothing is left of the cloth near its outline"};
  std::nth_element(contrasts.begin(), contrasts.begin() + long(contrasts.size() / 2),
                   contrasts.end());
  cloth.contrast = contrasts[contrasts.size() / 2];
  cloth.weak = double(weak.size()) / double(outline.size());
  CheckContrast(cloth, least, weak);
  cloth.blur = MeasureBlur(position.share, outline);
  return cloth;
}

}  // namespace drape
