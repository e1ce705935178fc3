// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/state.h"
#include "physics/simulation/backend.h"
#include "solver/fit/rollout_residuals.h"
#include "tests/physics/cloth_fixture.h"

// Synthetic silhouettes with a known reference.
namespace drape::test {

inline std::unique_ptr<Backend> SmoothDisc(int vertices) {
  return MakeCpuBackend(SmallDisc("smooth", vertices), 1);
}

inline State RandomStart(const ClothModel& model, uint64_t seed, double hem_rms = 5e-3) {
  return {ApplyStartShape(model.mesh, DrapeDiscs().support, RandomStartShape(seed, hem_rms)),
          Eigen::VectorXd::Zero(model.num_dofs())};
}

// The stable drape at rest that a start falls into.
inline State Settled(Backend& backend, const MaterialField& material, State start,
                     int steps = 100) {
  RolloutOptions options;
  options.h = 0.1;
  options.steps = steps;
  const RolloutInput input{&material, &start};
  const RolloutResult fallen = backend.Rollouts({&input, 1}, options, nullptr).front();
  EXPECT_EQ(fallen.status, RolloutStatus::kOk);
  start.x = fallen.end.x;
  EquilibriumResult rest = backend.Equilibria({&input, 1}, {}).front();
  EXPECT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  return {std::move(rest.x), Eigen::VectorXd::Zero(start.x.size())};
}

// The silhouette of a drape as an observation.
inline Observation MakeObservation(const Mesh& mesh, const State& drape, int angles,
                                   const std::string& name) {
  constexpr int kSupersample = 4;
  Observation observation;
  observation.name = name;
  observation.file = name + ".png";
  observation.image = Rasterize(mesh, drape.x, observation.camera, kSupersample);
  Outline outline;
  EXPECT_TRUE(OutlineFromImage(observation.image, observation.camera, angles, &outline));
  observation.radius = outline.radius;
  return observation;
}

// A square image, mirrored left to right if asked for, and then turned counter-clockwise.
inline GrayImage QuarterTurned(const GrayImage& image, int quarters, bool mirrored) {
  GrayImage turned = image;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      int c = column, r = row;
      for (int i = 0; i < quarters; ++i) c = std::exchange(r, c), c = image.width - 1 - c;
      turned.at(column, row) = image.at(mirrored ? image.width - 1 - c : c, r);
    }
  return turned;
}

// Residuals in pixels that reject no step for its length and follow drapes closely.
inline ResidualOptions CloseOutlineOptions() {
  ResidualOptions options;
  options.rollout = {};
  options.equilibrium = {};
  options.sigma_px = 1.0;
  options.max_outline_change = std::numeric_limits<double>::infinity();
  options.max_jump = 3e-3;
  return options;
}

inline double ComputeDrapeCoefficient(const Mesh& mesh, const Eigen::VectorXd& x) {
  constexpr int kAngles = 360;
  Outline outline;
  EXPECT_TRUE(OutlineFromMesh(mesh, x, Camera(), kAngles, &outline));
  return DrapeCoefficient(ProfileArea(MetresFromPixels(outline.radius, Camera())), {});
}

}  // namespace drape::test
