// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/cloth/cloth_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "losses/camera/photo/marker/disc.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

cv::Mat1b FillHoles(const cv::Mat1b& mask) {
  cv::Mat1b padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::floodFill(padded, {0, 0}, 2);
  const cv::Mat1b filled = (padded != 2) / 255;
  return filled(cv::Rect(1, 1, mask.cols, mask.rows)).clone();
}

struct Part {
  int label = 0;
  double area = 0, distance = 0;
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
         HUGE_VAL,
         {s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]}});
  }
  const double column = 0.5 * (mask.cols - 1), row = 0.5 * (mask.rows - 1);
  for (int r = 0; r < mask.rows; ++r)
    for (int c = 0; c < mask.cols; ++c)
      if (const int label = (*labels)(r, c); label > 0)
        parts[size_t(label) - 1].distance =
            std::min(parts[size_t(label) - 1].distance, std::hypot(c - column, r - row));
  return parts;
}

bool TouchesBorder(const cv::Rect& box, cv::Size size) {
  return box.x <= 0 || box.y <= 0 || box.br().x >= size.width || box.br().y >= size.height;
}

std::string Side(const cv::Rect& box, cv::Size size) {
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
  const Part* cloth = nullptr;
  for (const Part& part : parts)
    if (part.area >= kCandidate * largest && (!cloth || part.distance < cloth->distance))
      cloth = &part;
  Picked picked{FillHoles((labels == cloth->label) / 255), cloth->box};
  const double area = cv::countNonZero(picked.mask);
  for (const Part& part : parts)
    if (&part != cloth && part.area / area > picked.other) {
      picked.other = part.area / area;
      picked.other_label = part.label;
    }
  return picked;
}

}  // namespace

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
  if (TouchesBorder(picked.box, mask.size()))
    throw PhotoFailure{PhotoFault::kCroppedCloth,
                       "the cloth touches the edge of the picture at the " +
                           Side(picked.box, mask.size()) + ", expected ground all around it",
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

}  // namespace drape
