// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/render.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "losses/silhouette/silhouette_border.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using Colour = std::array<uint8_t, 3>;

constexpr int kSamples = 3;  // of a pixel, along each axis
constexpr int kGap = 4;      // between pictures [px]
constexpr double kAmbient = .42;

// The axes of a view: right, up, towards the viewer.
Eigen::Matrix3d ViewAxes(const View& view) {
  const double a = view.azimuth * std::numbers::pi / 180;
  const double e = view.elevation * std::numbers::pi / 180;
  Eigen::Matrix3d axes;
  axes.row(0) << std::cos(a), std::sin(a), 0;
  axes.row(2) << std::cos(e) * std::sin(a), -std::cos(e) * std::cos(a), std::sin(e);
  axes.row(1) = axes.row(2).cross(axes.row(0));
  return axes;
}

// Sums of the normals of the faces about each vertex, weighted by area, shape [3, V].
Eigen::Matrix3Xd VertexNormals(const ShownSurface& surface) {
  Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, surface.x->size() / 3);
  const auto at = [&](int i) { return surface.x->segment<3>(3 * i); };
  for (const auto& t : *surface.triangles) {
    const Vector3d normal = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    for (const int i : t) normals.col(i) += normal;
  }
  return normals;
}

class Canvas {
 public:
  explicit Canvas(const View& view)
      : view_(view),
        axes_(ViewAxes(view)),
        width_(view.width_px * kSamples),
        height_(view.height_px * kSamples),
        depth_(size_t(width_) * height_, -HUGE_VAL),
        colour_(size_t(width_) * height_, Colour{255, 255, 255}) {}

  void Show(const ShownSurface& surface) {
    const Eigen::Index n = surface.x->size() / 3;
    CHECK(surface.x->allFinite());
    const Eigen::Matrix3Xd seen =
        axes_ *
        (Eigen::Map<const Eigen::Matrix3Xd>(surface.x->data(), 3, n).colwise() - view_.centre);
    const Eigen::Matrix3Xd normals = axes_ * VertexNormals(surface);
    Eigen::Matrix2Xd image(2, n);
    const double scale = height_ / view_.height;
    image.row(0) = (scale * seen.row(0)).array() + .5 * (width_ - 1);
    image.row(1) = (-scale * seen.row(1)).array() + .5 * (height_ - 1);
    for (const auto& t : *surface.triangles) Fill(surface, t.data(), image, seen, normals);
  }

  RgbImage Picture() const {
    RgbImage picture{view_.width_px, view_.height_px, {}};
    for (int row = 0; row < picture.height; ++row)
      for (int column = 0; column < picture.width; ++column)
        for (int c = 0; c < 3; ++c) picture.rgb.push_back(Mean(column, row, c));
    return picture;
  }

 private:
  uint8_t Mean(int column, int row, int channel) const {
    int sum = 0;
    for (int y = row * kSamples; y < (row + 1) * kSamples; ++y)
      for (int x = column * kSamples; x < (column + 1) * kSamples; ++x)
        sum += colour_[size_t(y) * width_ + x][channel];
    return static_cast<uint8_t>(sum / (kSamples * kSamples));
  }

  void Fill(const ShownSurface& surface, const int* t, const Eigen::Matrix2Xd& image,
            const Eigen::Matrix3Xd& seen, const Eigen::Matrix3Xd& normals) {
    const auto a = image.col(t[0]), b = image.col(t[1]), c = image.col(t[2]);
    const double twice_area = EdgeSide(image.data(), t[0], t[1], {c.x(), c.y()});
    const Eigen::Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const PixelRange columns = PixelsIn(low.x(), high.x(), width_);
    const PixelRange rows = PixelsIn(low.y(), high.y(), height_);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int column = columns.first; column <= columns.last; ++column) {
        const Vec2 p = {double(column), double(row)};
        if (!Covers(image.data(), t, p)) continue;
        const Vector3d share =
            Vector3d(EdgeSide(image.data(), t[1], t[2], p), EdgeSide(image.data(), t[2], t[0], p),
                     EdgeSide(image.data(), t[0], t[1], p)) /
            twice_area;
        const double depth =
            share[0] * seen(2, t[0]) + share[1] * seen(2, t[1]) + share[2] * seen(2, t[2]);
        double& nearest = depth_[size_t(row) * width_ + column];
        if (depth <= nearest) continue;
        nearest = depth;
        const Vector3d normal = share[0] * normals.col(t[0]) + share[1] * normals.col(t[1]) +
                                share[2] * normals.col(t[2]);
        // Rows count downwards, so that a front face is clockwise in the image.
        colour_[size_t(row) * width_ + column] =
            Shade(twice_area < 0 ? surface.colour : surface.back_colour,
                  twice_area < 0 ? normal : Vector3d(-normal));
      }
    }
  }

  // Lambert's law for a light at the upper left of the viewer.
  static Colour Shade(const Colour& colour, const Vector3d& normal) {
    static const Vector3d light = Vector3d(-.45, .55, .7).normalized();
    const double norm = normal.norm();
    const double cosine = norm > 0 ? std::max(0.0, normal.dot(light) / norm) : 0;
    Colour shaded;
    for (int c = 0; c < 3; ++c)
      shaded[c] = static_cast<uint8_t>(
          std::lround(colour[c] * std::min(1.0, kAmbient + (1.08 - kAmbient) * cosine)));
    return shaded;
  }

  View view_;
  Eigen::Matrix3d axes_;
  int width_, height_;  // of the samples
  std::vector<double> depth_;
  std::vector<Colour> colour_;
};

}  // namespace

RgbImage RenderSurfaces(const std::vector<ShownSurface>& surfaces, const View& view) {
  Canvas canvas(view);
  for (const ShownSurface& surface : surfaces) canvas.Show(surface);
  return canvas.Picture();
}

RgbImage TilePictures(const std::vector<RgbImage>& pictures, int columns) {
  CHECK(!pictures.empty());
  CHECK_GE(columns, 1);
  const int count = static_cast<int>(pictures.size()), rows = (count + columns - 1) / columns;
  const int w = pictures[0].width, h = pictures[0].height;
  columns = std::min(columns, count);
  RgbImage sheet{columns * (w + kGap) - kGap, rows * (h + kGap) - kGap, {}};
  sheet.rgb.assign(size_t(3) * sheet.width * sheet.height, 255);
  for (int k = 0; k < count; ++k) {
    CHECK(pictures[k].width == w && pictures[k].height == h) << k;
    const int left = k % columns * (w + kGap), top = k / columns * (h + kGap);
    for (int row = 0; row < h; ++row)
      std::copy_n(&pictures[k].rgb[size_t(3) * row * w], 3 * w,
                  &sheet.rgb[3 * (size_t(top + row) * sheet.width + left)]);
  }
  return sheet;
}

}  // namespace drape
