// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

// A drape of 7 folds without a first harmonic: r(θ) [m].
inline double StarRadius(double angle) {
  return 0.120 + 0.012 * std::cos(7 * angle + 0.4) + 0.006 * std::cos(2 * angle - 1.0);
}

// Its silhouette in the image of a camera.
inline GrayImage StarSilhouette(const Camera& camera) {
  GrayImage image(camera.width, camera.height);
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const double x = col - camera.cx, y = camera.cy - row;
      const double edge = camera.scale * StarRadius(std::atan2(y, x)) - std::hypot(x, y);
      image.at(col, row) = static_cast<float>(std::clamp(edge + 0.5, 0.0, 1.0));
    }
  }
  return image;
}

// A camera of 1200 × 900 px that does not look at the centre.
inline Camera PhotographCamera() {
  Camera camera;
  camera.width = 1200;
  camera.height = 900;
  camera.scale = 2500;
  camera.cx = 640;
  camera.cy = 430;
  return camera;
}

struct Light {
  double cloth = 0.25, background = 0.8;  // brightness
  double falloff = 0.2;                   // relative loss of light from the left to the right side
  double noise = 0.02;
};

// A photograph of a silhouette under uneven light.
inline GrayImage Photograph(const GrayImage& silhouette, const Light& light) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, light.noise);
  GrayImage photo = silhouette;
  for (int row = 0; row < photo.height; ++row) {
    for (int col = 0; col < photo.width; ++col) {
      const double c = silhouette.at(col, row);
      const double brightness =
          (c * light.cloth + (1 - c) * light.background) * (1 - light.falloff * col / photo.width);
      photo.at(col, row) = 1 - static_cast<float>(std::clamp(brightness + noise(random), 0.0, 1.0));
    }
  }
  return photo;
}

inline void FillRectangle(GrayImage* image, int column, int row, int width, int height,
                          float value) {
  for (int r = row; r < row + height; ++r)
    for (int c = column; c < column + width; ++c) image->at(c, r) = value;
}

}  // namespace drape
