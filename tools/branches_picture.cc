// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "losses/camera.h"
#include "losses/shape_features.h"
#include "tools/branches_report.h"

namespace drape {
namespace {

using Color = std::array<double, 3>;

constexpr int kColumns = 8, kGap = 6, kBar = 6;  // tiles in a row; [px]
// Told apart by people who see few colours too (Okabe and Ito 2008).
constexpr Color kColors[] = {{0, 114, 178},   {230, 159, 0}, {0, 158, 115},  {204, 121, 167},
                             {86, 180, 233}, {213, 94, 0},  {110, 110, 110}};
constexpr Color kRing = {255, 255, 255};

// A silhouette at half its size.
class Tile {
 public:
  explicit Tile(const GrayImage& silhouette) : silhouette_(silhouette) {}
  int width() const { return silhouette_.width / 2; }
  int height() const { return silhouette_.height / 2; }

  double Coverage(int column, int row) const {
    double sum = 0.0;
    for (const int y : {0, 1})
      for (const int x : {0, 1}) sum += silhouette_.at(2 * column + x, 2 * row + y);
    return 0.25 * sum;
  }
  // Of the circle of the support, a pixel and a half wide.
  double Ring(int column, int row) const {
    const Camera camera;
    const double radius = std::hypot(2 * column + 0.5 - camera.cx, 2 * row + 0.5 - camera.cy);
    const double off = std::abs(radius - kSupportRadius * camera.pixels_per_metre());
    return std::clamp(1.25 - 0.5 * off, 0.0, 1.0);
  }

 private:
  const GrayImage& silhouette_;
};

void Paint(RgbImage* picture, int column, int row, const Color& color, double alpha) {
  uint8_t* rgb = &picture->rgb[3 * (size_t(row) * picture->width + column)];
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<uint8_t>(std::lround(rgb[c] + alpha * (color[c] - rgb[c])));
}

void DrawTile(const Tile& tile, int left, int top, const Color& color, RgbImage* picture) {
  for (int row = 0; row < tile.height(); ++row) {
    for (int column = 0; column < tile.width(); ++column) {
      Paint(picture, left + column, top + row, color, tile.Coverage(column, row));
      Paint(picture, left + column, top + row, kRing, tile.Ring(column, row));
    }
  }
}

// `joined`: the next tile of the row is of the same cluster.
void DrawBar(const Tile& tile, int left, int top, bool joined, const Color& color,
             RgbImage* picture) {
  const int width = tile.width() + (joined ? kGap : 0);
  for (int row = 0; row < kBar; ++row)
    for (int column = 0; column < width; ++column)
      Paint(picture, left + column, top + tile.height() + row, color, 1.0);
}

}  // namespace

RgbImage DrawBranches(const BranchSurvey& survey) {
  const GrayImage blank(Camera().width, Camera().height);
  const Tile empty(blank);
  const int drapes = std::max(1, survey.spread.drapes), columns = std::min(kColumns, drapes);
  const int step_x = empty.width() + kGap, step_y = empty.height() + kBar + kGap;
  RgbImage picture{columns * step_x + kGap, (drapes + columns - 1) / columns * step_y + kGap, {}};
  picture.rgb.assign(size_t(3) * picture.width * picture.height, 255);
  int index = 0;
  for (size_t c = 0; c < survey.clusters.size(); ++c) {
    const Color& color = kColors[c % std::size(kColors)];
    const std::vector<int>& members = survey.clusters[c].members;
    for (size_t m = 0; m < members.size(); ++m, ++index) {
      const Tile tile(survey.samples[members[m]].silhouette);
      const int left = kGap + index % columns * step_x, top = kGap + index / columns * step_y;
      const bool joined = m + 1 < members.size() && index % columns + 1 < columns;
      DrawTile(tile, left, top, color, &picture);
      DrawBar(tile, left, top, joined, color, &picture);
    }
  }
  return picture;
}

}  // namespace drape
