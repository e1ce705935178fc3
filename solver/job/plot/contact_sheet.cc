// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace drape {
namespace {

using Color = std::array<double, 3>;

constexpr int kColumns = 8, kGap = 6, kBar = 6;  // tiles in a row; [px]
// Distinguishable for people who see few colours too [Okabe 2008].
constexpr Color kColors[] = {{0, 114, 178},  {230, 159, 0}, {0, 158, 115},  {204, 121, 167},
                             {86, 180, 233}, {213, 94, 0},  {110, 110, 110}};
constexpr Color kRing = {255, 255, 255};

// A silhouette at half its size.
class Tile {
 public:
  Tile(const GrayImage& silhouette, const Camera& camera, double support)
      : silhouette_(silhouette), camera_(camera), support_(support) {}
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
    const double radius = std::hypot(2 * column + 0.5 - camera_.cx, 2 * row + 0.5 - camera_.cy);
    const double off = std::abs(radius - support_ * camera_.pixels_per_metre());
    return std::clamp(1.25 - 0.5 * off, 0.0, 1.0);
  }

 private:
  const GrayImage& silhouette_;
  const Camera& camera_;
  double support_;  // [m]
};

void Paint(RgbImage* picture, int column, int row, const Color& color, double alpha) {
  uint8_t* rgb = &picture->rgb[3 * (size_t(row) * picture->width + column)];
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<uint8_t>(std::lround(rgb[c] + alpha * (color[c] - rgb[c])));
}

void RenderTile(const Tile& tile, int left, int top, const Color& color, RgbImage* picture) {
  for (int row = 0; row < tile.height(); ++row) {
    for (int column = 0; column < tile.width(); ++column) {
      Paint(picture, left + column, top + row, color, tile.Coverage(column, row));
      Paint(picture, left + column, top + row, kRing, tile.Ring(column, row));
    }
  }
}

// `joined`: the next tile of the row is of the same group.
void RenderBar(const Tile& tile, int left, int top, bool joined, const Color& color,
               RgbImage* picture) {
  const int width = tile.width() + (joined ? kGap : 0);
  for (int row = 0; row < kBar; ++row)
    for (int column = 0; column < width; ++column)
      Paint(picture, left + column, top + tile.height() + row, color, 1.0);
}

}  // namespace

RgbImage RenderContactSheet(const std::vector<SheetTile>& tiles, const Camera& camera,
                            double support) {
  const GrayImage blank(camera.width, camera.height);
  const Tile empty(blank, camera, support);
  const int count = std::max(1, static_cast<int>(tiles.size()));
  const int columns = std::min(kColumns, count);
  const int step_x = empty.width() + kGap, step_y = empty.height() + kBar + kGap;
  RgbImage picture{columns * step_x + kGap, (count + columns - 1) / columns * step_y + kGap, {}};
  picture.rgb.assign(size_t(3) * picture.width * picture.height, 255);
  for (size_t i = 0; i < tiles.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const bool joined =
        i + 1 < tiles.size() && column + 1 < columns && tiles[i + 1].group == tiles[i].group;
    const Color& color = kColors[tiles[i].group % std::size(kColors)];
    const Tile tile(*tiles[i].silhouette, camera, support);
    const int left = kGap + column * step_x, top = kGap + row * step_y;
    RenderTile(tile, left, top, color, &picture);
    RenderBar(tile, left, top, joined, color, &picture);
  }
  return picture;
}

}  // namespace drape
