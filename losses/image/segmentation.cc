// SPDX-License-Identifier: Apache-2.0
#include "losses/image/segmentation.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "losses/image/cloth_mask.h"
#include "losses/image/photo_planes.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kMinSide = 16;  // [px]
constexpr int kLevels = 256;
constexpr double kSecondShare = 1.0 / 2;  // of the cloth, from which on a part is ambiguous
constexpr double kHoleShare = 1.0 / 10;   // of the cloth, from which on holes are not filled
constexpr int kEdgeReach = 2;             // [px] in which an edge keeps its grey levels

struct TwoLevels {
  double low = 0, high = 0;  // means of the two classes; equal for an image of one level
};

// The means of the classes that Otsu's threshold separates [Otsu 1979].
TwoLevels FindLevels(const GrayImage& image) {
  cv::Mat1b levels, high;
  CoveragePlane(image).convertTo(levels, CV_8U, kLevels - 1);
  cv::threshold(levels, high, 0, 1, cv::THRESH_OTSU);
  const auto mean = [&](const cv::Mat1b& mask) {
    return cv::mean(levels, mask)[0] / (kLevels - 1);
  };
  const int count = cv::countNonZero(high);
  if (count == 0 || count == int(high.total())) return {mean({}), mean({})};
  return {mean(1 - high), mean(high)};
}

cv::Mat1b Threshold(const GrayImage& image) { return (CoveragePlane(image) >= 0.5f) / 255; }

// What is far from the edges between ground and cloth, whose pixels are mixed, and its levels.
struct Plateaus {
  TwoLevels levels;
  cv::Mat1b ground, cloth;
};
Plateaus FindPlateaus(const GrayImage& image) {
  constexpr int kReach = 3;  // [px]
  const cv::Mat1b mask = Threshold(image);
  Plateaus found{FindLevels(image), 1 - Dilated(mask, kReach), Eroded(mask, kReach)};
  const auto refine = [&](double& level, const cv::Mat1b& where) {
    if (cv::countNonZero(where) > 0) level = cv::mean(CoveragePlane(image), where)[0];
  };
  refine(found.levels.low, found.ground);
  refine(found.levels.high, found.cloth);
  return found;
}

std::string At(const PicturePart& part) {
  return Format("%lld px at (%.0f, %.0f)", static_cast<long long>(part.pixels), part.column,
                part.row);
}

std::string Sizes(const std::vector<PicturePart>& parts) {
  constexpr size_t kNamed = 3;
  std::string text;
  for (size_t i = 0; i < std::min(parts.size(), kNamed); ++i)
    text += (i == 0 ? "" : ", ") + At(parts[i]);
  if (parts.size() <= kNamed) return text;
  const std::vector<PicturePart> rest(parts.begin() + kNamed, parts.end());
  return text + Format(", and %lld px in %zu others", static_cast<long long>(CountPixels(rest)),
                       rest.size());
}

PicturePart Describe(const MaskPart& part, cv::Size size) {
  return {part.pixels, part.middle.x, part.middle.y, !TouchedSides(part.box, size).empty()};
}

void SortBySize(std::vector<PicturePart>* parts) {
  std::stable_sort(parts->begin(), parts->end(),
                   [](const PicturePart& a, const PicturePart& b) { return a.pixels > b.pixels; });
}

void CheckNoise(size_t count, const char* what, const std::string& where) {
  if (count <= kMaxParts) return;
  throw InputError(where, "is noise: " + std::to_string(count) + what + ", expected at most " +
                              std::to_string(kMaxParts));
}

// Leaves the cloth alone in the mask and returns the other dark parts.
std::vector<PicturePart> CutOthers(const std::string& where, cv::Mat1b* mask) {
  cv::Mat1i labels;
  const std::vector<MaskPart> parts = ListParts(*mask, 8, &labels);
  CheckNoise(parts.size(), " separate dark parts", where);
  if (parts.empty()) throw InputError(where, "no cloth: no pixel is dark");
  const MaskPart& cloth = NearestPart(labels, parts);
  if (const std::string sides = TouchedSides(cloth.box, mask->size()); !sides.empty())
    throw InputError(where, "cloth touches the border at the " + sides +
                                ", expected a light background all around it");
  const PicturePart chosen = Describe(cloth, mask->size());
  std::vector<PicturePart> others;
  for (const MaskPart& part : parts) {
    if (&part == &cloth) continue;
    others.push_back(Describe(part, mask->size()));
    if (!others.back().touches_border && part.pixels > kSecondShare * cloth.pixels)
      throw InputError(where, "two dark parts of similar size: " + At(chosen) + " and " +
                                  At(others.back()) + ", expected one piece of cloth");
  }
  *mask = (labels == cloth.label) / 255;
  SortBySize(&others);
  return others;
}

// Fills the holes of the cloth and returns them.
std::vector<PicturePart> FillClothHoles(const std::string& where, cv::Mat1b* mask,
                                        std::vector<std::string>* notes) {
  cv::Mat1i labels;
  const std::vector<MaskPart> parts = ListParts(1 - *mask, 4, &labels);
  std::vector<PicturePart> holes;
  const MaskPart* largest = nullptr;
  for (const MaskPart& part : parts) {
    if (!TouchedSides(part.box, mask->size()).empty()) continue;
    holes.push_back(Describe(part, mask->size()));
    if (largest == nullptr || part.pixels > largest->pixels) largest = &part;
  }
  SortBySize(&holes);
  CheckNoise(holes.size(), " holes in the cloth", where);
  const double cloth = cv::countNonZero(*mask);
  const cv::Mat1b filled = FillHoles(*mask);
  const bool is_large = static_cast<double>(CountPixels(holes)) > kHoleShare * cloth;
  if (is_large) {
    const std::vector<PicturePart> rest(holes.begin() + 1, holes.end());
    if (!IsRoundHole((labels == largest->label) / 255, filled) ||
        static_cast<double>(CountPixels(rest)) > kHoleShare * cloth)
      throw InputError(where, "holes in the cloth: " + Sizes(holes) +
                                  Format(", %.0f %% of it",
                                         100.0 * static_cast<double>(CountPixels(holes)) / cloth) +
                                  ", expected at most 10 %, or a round hole in its middle, where "
                                  "the support is");
    notes->push_back("the round hole in the middle of the cloth was filled: the support");
    holes = rest;
  }
  *mask = filled;
  return holes;
}

// The coverage near the edge of the mask, and the mask elsewhere. Near the edge a pixel of a cut
// part or of a hole takes the value of the mask, too.
void ApplyMask(const cv::Mat1b& mask, GrayImage* image) {
  const cv::Mat1b square = cv::Mat1b::ones(2 * kEdgeReach + 1, 2 * kEdgeReach + 1);
  cv::Mat1f coverage = CoveragePlane(*image);
  cv::Mat1b least, most;
  cv::erode(mask, least, square);
  cv::dilate(mask, most, square);
  const cv::Mat1b replaced = (least == most) | (Threshold(*image) != mask);
  cv::Mat1f(mask).copyTo(coverage, replaced);
}

void CheckPicture(const GrayImage& picture, const std::string& where) {
  CHECK_EQ(picture.coverage.size(), size_t(picture.width) * picture.height);
  if (picture.width < kMinSide || picture.height < kMinSide)
    throw InputError(where, Format("image is %dx%d, expected at least %dx%d pixels", picture.width,
                                   picture.height, kMinSide, kMinSide));
  const auto in_range = [](float c) { return c >= 0 && c <= 1; };
  if (!std::all_of(picture.coverage.begin(), picture.coverage.end(), in_range))
    throw InputError(where, "a pixel's coverage is not in [0, 1]");
}

// Whether the middle of the cloth is on it; not so of a ring that is open, where the cloth hangs
// straight down from the support.
bool CoversMiddle(const GrayImage& image) {
  const cv::Moments m = cv::moments(CoveragePlane(image));
  return image.at(static_cast<int>(m.m10 / m.m00), static_cast<int>(m.m01 / m.m00)) >= 0.5f;
}

// The levels and the mask of a picture for which IsSilhouette holds, once they are scaled to 0 and
// 1 where they are far from them, and white on black is inverted.
struct TwoTones {
  TwoLevels levels;
  cv::Mat1b mask;
  bool was_inverted = false;
};
TwoTones ScaleTones(GrayImage& picture) {
  constexpr double kInverted = 0.98;  // of the border
  TwoTones tones{.levels = FindPlateaus(picture).levels, .mask = {}};
  TwoLevels& levels = tones.levels;
  if (levels.low > kLevelTolerance || levels.high < 1 - kLevelTolerance) {
    for (float& c : picture.coverage)
      c = static_cast<float>(std::clamp((c - levels.low) / (levels.high - levels.low), 0.0, 1.0));
    levels = {0, 1};
  }
  tones.mask = Threshold(picture);
  tones.was_inverted = cv::mean(tones.mask, BorderMask(tones.mask.size()))[0] > kInverted;
  if (!tones.was_inverted) return tones;
  for (float& c : picture.coverage) c = 1 - c;
  tones.mask = 1 - tones.mask;
  levels = {1 - levels.high, 1 - levels.low};
  return tones;
}

// The silhouette in a picture for which IsSilhouette holds.
Silhouette CleanSilhouette(GrayImage picture, const std::string& where) {
  Silhouette silhouette;
  Segmentation& done = silhouette.segmentation;
  TwoTones tones = ScaleTones(picture);
  if (tones.was_inverted) done.seen.push_back("the picture is white on black and was inverted");
  done.background = tones.levels.low;
  done.cloth = tones.levels.high;
  done.cut = CutOthers(where, &tones.mask);
  done.filled = FillClothHoles(where, &tones.mask, &done.seen);
  if (!done.cut.empty() || !done.filled.empty() || !done.seen.empty())
    ApplyMask(tones.mask, &picture);
  silhouette.image = std::move(picture);
  return silhouette;
}

// The silhouette in any other picture.
Silhouette DevelopSilhouette(const Photograph& photo, const std::string& where) {
  FoundCloth found;
  try {
    CatchOpenCv([&] { FindSilhouette(photo.image, MakePlanes(photo.image), {}, &found); });
  } catch (const PhotoFailure& failure) {
    throw InputError(where, std::string(ToString(failure.fault)) + ": " + failure.reason);
  }
  Silhouette silhouette{GrayImage(photo.image.width, photo.image.height), {}};
  cv::Mat1f coverage = CoveragePlane(silhouette.image);
  cv::resize(found.cloth.coverage, coverage, coverage.size());
  Segmentation& done = silhouette.segmentation;
  done.photograph = true;
  done.focal_35mm = photo.exif.focal_35mm;
  done.background = 1 - found.ground_level;
  done.cloth = 1 - found.cloth_level;
  done.seen = found.seen;
  done.doubts = found.doubts;
  return silhouette;
}

}  // namespace

int64_t CountPixels(const std::vector<PicturePart>& parts) {
  return std::accumulate(parts.begin(), parts.end(), int64_t{0},
                         [](int64_t sum, const PicturePart& part) { return sum + part.pixels; });
}

std::vector<std::string> Segmentation::Notes() const {
  std::vector<std::string> notes;
  if (photograph)
    notes.push_back(Format("photograph: grey levels of %.0f %% (background) and %.0f %% (cloth)",
                           100 * (1 - background), 100 * (1 - cloth)));
  if (!cut.empty())
    notes.push_back("cut " + std::to_string(cut.size()) + (cut.size() == 1 ? " part" : " parts") +
                    " outside the cloth: " + Sizes(cut));
  if (!filled.empty())
    notes.push_back("filled " + std::to_string(filled.size()) +
                    (filled.size() == 1 ? " hole" : " holes") + " in the cloth: " + Sizes(filled));
  notes.insert(notes.end(), seen.begin(), seen.end());
  notes.insert(notes.end(), doubts.begin(), doubts.end());
  return notes;
}

bool IsSilhouette(const GrayImage& image) {
  constexpr double kFarthest = 0.2;      // of a level from 0 or 1
  constexpr double kSameLevel = 0.04;    // of coverage; published images: .02
  constexpr double kMostBetween = 5e-4;  // of the pixels; published images: 2e-4
  const Plateaus found = FindPlateaus(image);
  if (found.levels.low > kFarthest || found.levels.high < 1 - kFarthest) return false;
  const auto count_off = [&](double level, const cv::Mat1b& where) {
    const cv::Mat off = cv::abs(CoveragePlane(image) - level) > kSameLevel;
    return cv::countNonZero(off & where);
  };
  const int between =
      count_off(found.levels.low, found.ground) + count_off(found.levels.high, found.cloth);
  return between <= kMostBetween * static_cast<double>(found.cloth.total());
}

Silhouette SegmentSilhouette(GrayImage picture, const std::string& where) {
  CheckPicture(picture, where);
  if (IsSilhouette(picture))
    if (Silhouette found = CleanSilhouette(picture, where); CoversMiddle(found.image)) return found;
  Photograph photo{{picture.width, picture.height, {}}, {}};
  for (const float c : picture.coverage)
    photo.image.rgb.insert(photo.image.rgb.end(), 3,
                           static_cast<uint8_t>(std::lround(255 * (1 - c))));
  return DevelopSilhouette(photo, where);
}

Silhouette ReadSilhouette(const std::string& path) {
  GrayImage picture = ReadImage(path);
  CheckPicture(picture, path);
  if (IsSilhouette(picture))
    if (Silhouette found = CleanSilhouette(picture, path); CoversMiddle(found.image)) return found;
  return DevelopSilhouette(ReadPhotograph(path), path);
}

GrayImage ReadMask(const std::string& path) {
  GrayImage picture = ReadImage(path);
  CheckPicture(picture, path);
  if (!IsSilhouette(picture))
    throw InputError(path,
                     "a picture with grey levels, expected a mask: cloth black, all else white");
  ScaleTones(picture);
  return picture;
}

}  // namespace drape
