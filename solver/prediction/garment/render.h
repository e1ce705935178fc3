// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "losses/image/image.h"

namespace drape {

// Simple pictures of surfaces in space: orthographic, shaded, the nearer hides the farther.

struct ShownSurface {
  const std::vector<std::array<int, 3>>* triangles;
  const Eigen::VectorXd* x;            // [m], shape [3V], finite
  std::array<uint8_t, 3> colour;       // of the side that is counter-clockwise to the viewer
  std::array<uint8_t, 3> back_colour;  // of the other side
};

inline constexpr std::array<uint8_t, 3> kBodyColour = {196, 190, 184};
inline constexpr std::array<uint8_t, 3> kClothColour = {72, 122, 180};
inline constexpr std::array<uint8_t, 3> kClothBackColour = {150, 178, 210};

// From where, and what part of the world. Azimuth 0 sees the front of a body, which faces −y, 90
// its left side; the elevation is above the horizon [degrees].
struct View {
  double azimuth = 0, elevation = 10;
  Eigen::Vector3d centre = {0, 0, .87};  // in the middle of the picture [m]
  double height = 1.9;                   // of the picture [m]
  int width_px = 560, height_px = 600;
};

// White where there is no surface.
RgbImage RenderSurfaces(const std::vector<ShownSurface>& surfaces, const View& view);

// Pictures of one size in rows of `columns`, 4 px apart. CHECKs the sizes.
RgbImage TilePictures(const std::vector<RgbImage>& pictures, int columns);

}  // namespace drape
