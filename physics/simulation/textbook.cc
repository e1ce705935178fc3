// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/textbook.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace drape {
namespace {

// An elastica under its own weight, integrated from its free tip towards the clamp: τ = Γ^⅓·σ with
// σ = 1 − s, slope'' = −τ·cos(slope). The integration stops where the slope is level.
struct Elastica {
  double gamma, chord;
};

Elastica FromTip(double tip_slope) {
  constexpr double kStep = 2e-3;
  using Vector = Eigen::Vector4d;  // slope, slope', reach, drop
  const auto rate = [](double tau, const Vector& y) {
    return Vector(y[1], -tau * std::cos(y[0]), std::cos(y[0]), std::sin(y[0]));
  };
  Vector y(tip_slope, 0.0, 0.0, 0.0);
  for (double tau = 0.0;; tau += kStep) {
    const Vector a = rate(tau, y), b = rate(tau + kStep / 2, y + kStep / 2 * a),
                 c = rate(tau + kStep / 2, y + kStep / 2 * b), d = rate(tau + kStep, y + kStep * c);
    const Vector next = y + kStep / 6 * (a + 2 * b + 2 * c + d);
    if (next[0] > 0.0) {
      y = next;
      continue;
    }
    const double share = y[0] / (y[0] - next[0]);  // of the last step, interpolated linearly
    const Vector end = y + share * (next - y);
    return {std::pow(tau + share * kStep, 3), std::atan2(end[3], end[2])};
  }
}

}  // namespace

MaterialField LinearMaterial(double k, double D, double density) {
  MaterialField material;
  material.density = density;
  StretchTable stretch;
  for (auto& row : stretch.c) {
    row[0] = row[2] = k / kMembranePerEntry;
    row[3] = 0.5 * k / kMembranePerEntry;
  }
  BendTable bend;
  for (auto& row : bend.b) std::fill(std::begin(row), std::end(row), kBendPerRigidity * D);
  material.stretch = {stretch};
  material.bend = {bend};
  return material;
}

double HeavyElasticaGamma(double chord) {
  CHECK(chord > 0.0 && chord < M_PI / 2) << chord;
  double low = 0.0, high = M_PI / 2;  // slopes of the tip
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (FromTip(middle).chord < chord ? low : high) = middle;
  }
  return FromTip(0.5 * (low + high)).gamma;
}

}  // namespace drape
