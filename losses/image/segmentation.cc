// SPDX-License-Identifier: Apache-2.0
#include "losses/image/segmentation.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// Row-major, shape [height, width], 1 = cloth.
struct PictureMask {
  int width = 0, height = 0;
  std::vector<uint8_t> value;

  uint8_t at(int column, int row) const { return value[size_t(row) * width + column]; }
};

// Pixels of one part that follow one another in a row: [first, end).
struct PixelRun {
  int row, first, end, part;
};

struct PictureParts {
  std::vector<PicturePart> parts;
  std::vector<PixelRun> runs;  // by row, then column
};

enum class Neighbours { kFour, kEight };

constexpr size_t kMaxRuns = size_t{1} << 21;

// The representative of run i: each run refers to an earlier one of its part, or to itself.
int Root(std::vector<PixelRun>& runs, int i) {
  while (runs[i].part != i) i = runs[i].part = runs[runs[i].part].part;
  return i;
}

void Unite(std::vector<PixelRun>& runs, int i, int j) {
  const int a = Root(runs, i), b = Root(runs, j);
  if (a < b) runs[b].part = a;
  if (b < a) runs[a].part = b;
}

void AddRuns(const PictureMask& mask, int row, uint8_t value, std::vector<PixelRun>* runs) {
  for (int col = 0; col < mask.width;) {
    if (mask.at(col, row) != value) {
      ++col;
      continue;
    }
    const int first = col;
    while (col < mask.width && mask.at(col, row) == value) ++col;
    runs->push_back({row, first, col, static_cast<int>(runs->size())});
  }
}

// Unites the runs [first, end) of a row with the runs of the row before it, [before, first).
void UniteWithRowBefore(int before, int first, int end, int reach, std::vector<PixelRun>* runs) {
  int above = before;
  for (int i = first; i < end; ++i) {
    while (above < first && (*runs)[above].end + reach <= (*runs)[i].first) ++above;
    for (int j = above; j < first && (*runs)[j].first < (*runs)[i].end + reach; ++j)
      Unite(*runs, i, j);
  }
}

// Numbers the parts in the order of their first runs and measures them.
std::vector<PicturePart> Measure(const PictureMask& mask, std::vector<PixelRun>* runs) {
  std::vector<PicturePart> parts;
  std::vector<int> number(runs->size());
  for (size_t i = 0; i < runs->size(); ++i) {
    const int root = Root(*runs, static_cast<int>(i));
    if (root == static_cast<int>(i)) {
      number[i] = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    number[i] = number[root];
    const PixelRun& run = (*runs)[i];
    PicturePart& part = parts[number[i]];
    const int64_t pixels = run.end - run.first;
    part.pixels += pixels;
    part.column += 0.5 * (run.first + run.end - 1) * pixels;
    part.row += double(run.row) * pixels;
    part.touches_border |=
        run.row == 0 || run.row == mask.height - 1 || run.first == 0 || run.end == mask.width;
  }
  for (size_t i = 0; i < runs->size(); ++i) (*runs)[i].part = number[i];
  for (PicturePart& part : parts) {
    part.column /= part.pixels;
    part.row /= part.pixels;
  }
  return parts;
}

// The connected parts of the pixels of that value. Dark parts should be connected through corners
// (kEight) and their complement not (kFour), so that a closed curve has an inside. Throws
// InputError (prefix `where`) for more than 2^21 runs: such a picture is noise.
PictureParts FindParts(const PictureMask& mask, uint8_t value, Neighbours neighbours,
                       const std::string& where) {
  const int reach = neighbours == Neighbours::kEight ? 1 : 0;
  PictureParts found;
  int before = 0;
  for (int row = 0; row < mask.height; ++row) {
    const int first = static_cast<int>(found.runs.size());
    AddRuns(mask, row, value, &found.runs);
    if (found.runs.size() > kMaxRuns)
      throw InputError(where,
                       "is noise: more than 2 million changes between dark and light, "
                       "expected one piece of cloth");
    UniteWithRowBefore(before, first, static_cast<int>(found.runs.size()), reach, &found.runs);
    before = first;
  }
  found.parts = Measure(mask, &found.runs);
  return found;
}

constexpr int kMinSide = 16;  // [px]
constexpr int kLevels = 256;
constexpr double kMinContrast = 0.15;        // of the mean coverages of cloth and background
constexpr double kCandidateShare = 1.0 / 8;  // of the largest part, for a part to be the cloth
constexpr double kSecondShare = 1.0 / 2;     // of the cloth, from which on a part is ambiguous
constexpr double kHoleShare = 1.0 / 10;      // of the cloth, from which on holes are not filled
constexpr int kEdgeReach = 2;                // [px] in which an edge keeps its grey levels

struct TwoLevels {
  double low = 0, high = 0;  // means of the two classes; equal for an image of one level
};

// The means of the classes that Otsu's threshold separates.
TwoLevels FindLevels(const GrayImage& image) {
  std::array<double, kLevels> count = {};
  for (const float c : image.coverage) ++count[std::lround(c * (kLevels - 1))];
  double total = 0, sum = 0;
  for (int level = 0; level < kLevels; ++level) {
    total += count[level];
    sum += count[level] * level;
  }
  TwoLevels best{sum / total / (kLevels - 1), sum / total / (kLevels - 1)};
  double largest = 0, below = 0, sum_below = 0;
  for (int level = 0; level + 1 < kLevels; ++level) {
    below += count[level];
    sum_below += count[level] * level;
    if (below == 0 || below == total) continue;
    const double low = sum_below / below, high = (sum - sum_below) / (total - below);
    const double between = below * (total - below) * (high - low) * (high - low);
    if (between <= largest) continue;
    largest = between;
    best = {low / (kLevels - 1), high / (kLevels - 1)};
  }
  return best;
}

PictureMask Threshold(const GrayImage& image, float level) {
  PictureMask mask{image.width, image.height, std::vector<uint8_t>(image.coverage.size())};
  for (size_t i = 0; i < image.coverage.size(); ++i) mask.value[i] = image.coverage[i] >= level;
  return mask;
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

void SortBySize(std::vector<PicturePart>* parts) {
  std::stable_sort(parts->begin(), parts->end(),
                   [](const PicturePart& a, const PicturePart& b) { return a.pixels > b.pixels; });
}

// The part nearest to the image's centre among those that are not small beside the largest one.
int FindCloth(const PictureMask& mask, const PictureParts& found) {
  int64_t largest = 0;
  for (const PicturePart& part : found.parts) largest = std::max(largest, part.pixels);
  const double column = 0.5 * (mask.width - 1), row = 0.5 * (mask.height - 1);
  int cloth = 0;
  double nearest = HUGE_VAL;
  for (const PixelRun& run : found.runs) {
    if (found.parts[run.part].pixels < kCandidateShare * largest) continue;
    const double across = std::max({run.first - column, 0.0, column - (run.end - 1)});
    const double distance = std::hypot(across, run.row - row);
    if (distance >= nearest) continue;
    nearest = distance;
    cloth = run.part;
  }
  return cloth;
}

// Where a part touches the border: "top (12 px about column 130), left (3 px about row 20)".
std::string BorderText(const PictureMask& mask, const PictureParts& found, int part) {
  struct Side {
    const char *name, *along;
    int64_t pixels = 0;
    double sum = 0;
  } sides[] = {{"top", "column"}, {"bottom", "column"}, {"left", "row"}, {"right", "row"}};
  const auto add = [&](int side, int64_t pixels, double middle) {
    sides[side].pixels += pixels;
    sides[side].sum += pixels * middle;
  };
  for (const PixelRun& run : found.runs) {
    if (run.part != part) continue;
    const double middle = 0.5 * (run.first + run.end - 1);
    if (run.row == 0) add(0, run.end - run.first, middle);
    if (run.row == mask.height - 1) add(1, run.end - run.first, middle);
    if (run.first == 0) add(2, 1, run.row);
    if (run.end == mask.width) add(3, 1, run.row);
  }
  std::string text;
  for (const Side& side : sides) {
    if (side.pixels == 0) continue;
    text += (text.empty() ? "" : ", ") + Format("%s (%lld px about %s %.0f)", side.name,
                                                static_cast<long long>(side.pixels), side.along,
                                                side.sum / side.pixels);
  }
  return text;
}

void CheckNoise(const std::vector<PicturePart>& parts, const char* what, const std::string& where) {
  if (parts.size() <= kMaxParts) return;
  throw InputError(where, "is noise: " + std::to_string(parts.size()) + what +
                              ", expected at most " + std::to_string(kMaxParts));
}

// Leaves the cloth alone in the mask and returns the other dark parts.
std::vector<PicturePart> CutOthers(const std::string& where, PictureMask* mask) {
  const PictureParts found = FindParts(*mask, 1, Neighbours::kEight, where);
  CheckNoise(found.parts, " separate dark parts", where);
  const int cloth = FindCloth(*mask, found);
  const PicturePart& chosen = found.parts[cloth];
  if (chosen.touches_border)
    throw InputError(where, "cloth touches the border at the " + BorderText(*mask, found, cloth) +
                                ", expected a light background all around it");
  std::vector<PicturePart> others;
  for (const PicturePart& part : found.parts) {
    if (&part == &chosen) continue;
    if (!part.touches_border && part.pixels > kSecondShare * chosen.pixels)
      throw InputError(where, "two dark parts of similar size: " + At(chosen) + " and " + At(part) +
                                  ", expected one piece of cloth");
    others.push_back(part);
  }
  for (const PixelRun& run : found.runs)
    if (run.part != cloth)
      for (int col = run.first; col < run.end; ++col)
        mask->value[size_t(run.row) * mask->width + col] = 0;
  SortBySize(&others);
  return others;
}

// Fills the holes of the cloth and returns them.
std::vector<PicturePart> FillHoles(const std::string& where, PictureMask* mask) {
  const PictureParts found = FindParts(*mask, 0, Neighbours::kFour, where);
  std::vector<PicturePart> holes;
  for (const PicturePart& part : found.parts)
    if (!part.touches_border) holes.push_back(part);
  SortBySize(&holes);
  CheckNoise(holes, " holes in the cloth", where);
  const auto cloth = std::count(mask->value.begin(), mask->value.end(), 1);
  if (CountPixels(holes) > kHoleShare * static_cast<double>(cloth))
    throw InputError(where,
                     "holes in the cloth: " + Sizes(holes) +
                         Format(", %.0f %% of it", 100.0 * static_cast<double>(CountPixels(holes)) /
                                                       static_cast<double>(cloth)) +
                         ", expected at most 10 %");
  for (const PixelRun& run : found.runs)
    if (!found.parts[run.part].touches_border)
      for (int col = run.first; col < run.end; ++col)
        mask->value[size_t(run.row) * mask->width + col] = 1;
  return holes;
}

// Whether all pixels within kEdgeReach of a pixel have its value.
bool IsAwayFromEdge(const PictureMask& mask, int column, int row) {
  const int first = std::max(column - kEdgeReach, 0);
  const int last = std::min(column + kEdgeReach, mask.width - 1);
  for (int r = std::max(row - kEdgeReach, 0); r <= std::min(row + kEdgeReach, mask.height - 1); ++r)
    for (int c = first; c <= last; ++c)
      if (mask.at(c, r) != mask.at(column, row)) return false;
  return true;
}

// The coverage between the levels near the edge of the mask, and the mask elsewhere. Near
// the edge a pixel of a cut part or of a hole takes the value of the mask, too.
void ApplyMask(const PictureMask& mask, const TwoLevels& levels, GrayImage* image) {
  for (int row = 0; row < mask.height; ++row) {
    for (int col = 0; col < mask.width; ++col) {
      float& c = image->at(col, row);
      const bool cloth = mask.at(col, row) != 0;
      const double scaled = std::clamp((c - levels.low) / (levels.high - levels.low), 0.0, 1.0);
      const bool belongs = (scaled >= 0.5) == cloth;
      c = belongs && !IsAwayFromEdge(mask, col, row) ? static_cast<float>(scaled) : cloth;
    }
  }
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

void CheckContrast(const TwoLevels& levels, const std::string& where) {
  if (levels.high - levels.low >= kMinContrast) return;
  const bool dark = levels.low >= 0.5;
  throw InputError(where, std::string(dark ? "no background: all pixels are dark"
                                           : "no cloth: no pixel is much darker than the others") +
                              Format(" (grey levels of %.0f and %.0f %%)", 100 * (1 - levels.low),
                                     100 * (1 - levels.high)) +
                              ", expected dark cloth on a light background");
}

}  // namespace

int64_t CountPixels(const std::vector<PicturePart>& parts) {
  return std::accumulate(parts.begin(), parts.end(), int64_t{0},
                         [](int64_t sum, const PicturePart& part) { return sum + part.pixels; });
}

std::vector<std::string> Segmentation::Notes() const {
  std::vector<std::string> notes;
  if (rescaled)
    notes.push_back(
        Format("photograph: grey levels of %.0f %% (background) and %.0f %% (cloth), "
               "threshold at %.0f %%",
               100 * (1 - background), 100 * (1 - cloth), 100 * (1 - 0.5 * (background + cloth))));
  if (!cut.empty())
    notes.push_back("cut " + std::to_string(cut.size()) + (cut.size() == 1 ? " part" : " parts") +
                    " outside the cloth: " + Sizes(cut));
  if (!filled.empty())
    notes.push_back("filled " + std::to_string(filled.size()) +
                    (filled.size() == 1 ? " hole" : " holes") + " in the cloth: " + Sizes(filled));
  return notes;
}

Silhouette SegmentSilhouette(GrayImage picture, const std::string& where) {
  CheckPicture(picture, where);
  TwoLevels levels = FindLevels(picture);
  CheckContrast(levels, where);
  Silhouette silhouette;
  Segmentation& done = silhouette.segmentation;
  done.background = levels.low;
  done.cloth = levels.high;
  done.rescaled = levels.low > kLevelTolerance || levels.high < 1 - kLevelTolerance;
  if (!done.rescaled) levels = {0, 1};
  PictureMask mask = Threshold(picture, static_cast<float>(0.5 * (levels.low + levels.high)));
  done.cut = CutOthers(where, &mask);
  done.filled = FillHoles(where, &mask);
  if (done.rescaled || !done.cut.empty() || !done.filled.empty()) ApplyMask(mask, levels, &picture);
  silhouette.image = std::move(picture);
  return silhouette;
}

Silhouette ReadSilhouette(const std::string& path) {
  return SegmentSilhouette(ReadImage(path), path);
}

}  // namespace drape
