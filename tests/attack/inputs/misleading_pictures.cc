// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <random>

#include "tests/attack/inputs/pictures.h"

namespace drape::attack {
namespace {

// A picture of cloth where `is_cloth` of the distance from the centre [px] and the angle [rad].
std::string Draw(int width, int height,
                 const std::function<bool(double r, double angle)>& is_cloth) {
  std::string rows;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double x = column - 0.5 * (width - 1), y = 0.5 * (height - 1) - row;
      rows += is_cloth(std::hypot(x, y), std::atan2(y, x)) ? '\0' : '\xff';
    }
  }
  return EncodePngAs(
      rows, static_cast<std::size_t>(width),
      {.width = static_cast<uint32_t>(width), .height = static_cast<uint32_t>(height)});
}

std::string DrawSquare(const std::function<bool(double r, double angle)>& is_cloth) {
  return Draw(kStarSize, kStarSize, is_cloth);
}

std::string DrawNoise(double share, unsigned seed) {
  std::mt19937 random(seed);
  return DrawSquare([&](double, double) { return random() < share * 4294967296.0; });
}

std::string DrawOffCentre(double dx, double dy) {
  return DrawSquare([=](double r, double angle) {
    return std::hypot(r * std::cos(angle) - dx, r * std::sin(angle) - dy) < 85;
  });
}

}  // namespace

std::vector<BadPicture> MakeMisleadingPictures() {
  const auto disc = [](double r, double) { return r < 85; };
  return {
      {"all white", "a.png", DrawSquare([](double, double) { return false; })},
      {"all black", "a.png", DrawSquare([](double, double) { return true; })},
      {"one black pixel", "a.png", DrawSquare([](double r, double) { return r < 1; })},
      {"a small disc", "a.png", DrawSquare([](double r, double) { return r < 20; })},
      {"a disc to the border", "a.png", DrawSquare([](double r, double) { return r < 128; })},
      {"a disc over the border", "a.png", DrawSquare([](double r, double) { return r < 150; })},
      // Taken with a note: white on black, and the support in the middle of the cloth.
      {"inverted", "a.png", DrawSquare([](double r, double) { return r > 85; }), false},
      {"a ring", "a.png", DrawSquare([](double r, double) { return r < 85 && r > 70; }), false},
      {"a thin ring", "a.png", DrawSquare([](double r, double) { return r < 85 && r > 83; })},
      {"a letter C", "a.png", DrawSquare([](double r, double a) {
         return r < 85 && (r > 50 ? std::abs(a) > 0.4 : false);
       })},
      {"a spiral", "a.png", DrawSquare([](double r, double a) {
         return r < 100 && std::fmod(r / 8 + a / (2 * M_PI) + 10, 2.0) < 1;
       })},
      {"a star of needles", "a.png",
       DrawSquare([](double r, double a) { return r < 66 + 50 * std::pow(std::cos(20 * a), 8); }),
       false},
      {"stripes", "a.png", DrawSquare([](double r, double a) {
         return std::fmod(std::abs(r * std::cos(a)), 16.0) < 8;
       })},
      {"a checkerboard of pixels", "a.png", DrawSquare([](double r, double a) {
         return (std::lround(r * std::cos(a) + 127.5) + std::lround(r * std::sin(a) + 127.5)) % 2 ==
                0;
       })},
      {"noise", "a.png", DrawNoise(0.5, 1)},
      {"pepper", "a.png", DrawNoise(0.05, 2)},
      {"salt", "a.png", DrawNoise(0.95, 3)},
      {"two discs", "a.png", DrawSquare([](double r, double a) {
         return std::hypot(std::abs(r * std::cos(a)) - 60, r * std::sin(a)) < 40;
       })},
      {"a line", "a.png",
       DrawSquare([](double r, double a) { return std::abs(r * std::sin(a)) < 2 && r < 100; })},
      {"half a disc", "a.png", DrawSquare([](double r, double a) { return r < 85 && a > 0; })},
      {"off centre", "a.png", DrawOffCentre(20, -15), false},
      {"far off centre", "a.png", DrawOffCentre(80, 80)},
      {"1 x 1", "a.png", Draw(1, 1, disc)},
      {"1 x 256", "a.png", Draw(1, 256, disc)},
      {"3 x 3", "a.png", Draw(3, 3, [](double r, double) { return r < 1; })},
      {"300 x 300 without a scale", "a.png", Draw(300, 300, disc)},
      {"256 x 300", "a.png", Draw(256, 300, disc)},
      {"4000 x 10", "a.png", Draw(4000, 10, disc)},
      {"a disc", "a.png", DrawSquare(disc), false}};
}

}  // namespace drape::attack
