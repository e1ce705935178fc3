// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/cloth/ground.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "losses/camera/photo/picture/median.h"

namespace drape {
namespace {

constexpr double kNoiseOfFactor = 1.48;  // median absolute deviation to standard deviation

}  // namespace

Monomials MonomialsAt(int column, int row, cv::Size size) {
  const double x = 2.0 * column / size.width - 1, y = 2.0 * row / size.height - 1;
  return {1, x, y, x * x, x * y, y * y};
}

Ground FitGround(const cv::Mat3f& lab, const cv::Mat1b& border) {
  constexpr int kStride = 3, kRounds = 6;
  constexpr double kReach = 4.0;  // standard deviations
  std::vector<Monomials> places;
  std::vector<cv::Vec3f> colors;
  std::vector<float> channel[3];
  for (int row = 0; row < lab.rows; row += kStride)
    for (int col = 0; col < lab.cols; col += kStride)
      if (border(row, col)) {
        places.push_back(MonomialsAt(col, row, lab.size()));
        colors.push_back(lab(row, col));
        for (int c = 0; c < 3; ++c) channel[c].push_back(colors.back()[c]);
      }
  Ground ground;
  for (int c = 0; c < 3; ++c) ground.coefficients(0, c) = Median(channel[c]);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> errors;
    for (size_t i = 0; i < places.size(); ++i)
      errors.push_back(static_cast<float>(cv::norm(cv::Vec3d(colors[i]) - ground.At(places[i]))));
    ground.noise = std::max(0.3, kNoiseOfFactor / std::sqrt(3.0) * Median(errors));
    if (round + 1 == kRounds) break;
    const double reach = kReach * std::sqrt(3.0) * ground.noise;
    cv::Matx<double, 6, 6> normal = cv::Matx<double, 6, 6>::eye() * 1e-6;
    cv::Matx<double, 6, 3> right;
    for (size_t i = 0; i < places.size(); ++i) {
      const double u = errors[i] / reach, weight = u < 1 ? (1 - u * u) * (1 - u * u) : 0;
      normal += weight * places[i] * places[i].t();
      right +=
          weight * places[i] * cv::Matx<double, 1, 3>(colors[i][0], colors[i][1], colors[i][2]);
    }
    ground.coefficients = normal.inv(cv::DECOMP_CHOLESKY) * right;
  }
  return ground;
}

cv::Mat3f WithoutGround(const cv::Mat3f& lab, const Ground& ground) {
  cv::Mat3f rest(lab.size());
  for (int row = 0; row < lab.rows; ++row)
    for (int col = 0; col < lab.cols; ++col)
      rest(row, col) = lab(row, col) - cv::Vec3f(ground.At(MonomialsAt(col, row, lab.size())));
  return rest;
}

}  // namespace drape
