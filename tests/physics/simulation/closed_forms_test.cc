// SPDX-License-Identifier: Apache-2.0
// Cases with a closed form [MODEL, M53, M56, M57].
#include "tests/physics/simulation/closed_forms.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "physics/cloth/assembly/assembly.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/rollout.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

constexpr double kGravity = 9.81;

class ClosedFormTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Laws, ClosedFormTest, testing::Values("reference", "smooth"),
                         [](const auto& info) { return info.param; });

// N = k(l² − 1)l/2 over the section of a strip that is stretched uniformly by l.
TEST_P(ClosedFormTest, UniaxialPull) {
  const double length = 0.2, width = 0.05, k = 100.0;
  const ClothModel model(MakeStrip(length, width, 20, 6), Scene(), MakeLaw(GetParam()));
  for (const auto& [stretch, expected] : {std::pair{1.05, 5.381}, {1.1, 11.55}, {1.2, 26.40}}) {
    Eigen::VectorXd x = model.mesh.rest_x, force;
    for (int i = 0; i < x.size(); i += 3) x[i] *= stretch;
    AssembleForce(model, LinearMaterial(k, 1e-6, 0.2), x, force);
    double pull = 0.0;  // of the fixed end on the strip, by width
    for (int i = 0; i < x.size(); i += 3)
      if (x[i] < 0.5 * stretch * length) pull += force[i] / width;
    EXPECT_NEAR(pull, k * (stretch * stretch - 1.0) * stretch / 2, 1e-10 * expected);
    EXPECT_NEAR(pull, expected, 1e-3 * expected);
  }
}

// Steps with a handle at the vertices near the origin only, until nothing moves.
State Settle(const std::shared_ptr<const ClothModel>& model, const MaterialField& material,
             double h, int steps) {
  StepSolver solver(model);
  RolloutOptions options;
  options.h = h;
  options.steps = steps;
  const RolloutResult result = Rollout(solver, material, model->RestState(), options);
  EXPECT_EQ(result.status, RolloutStatus::kOk);
  return result.end;
}

// ΔL/L = ρgL/2k under its own weight. N = k(l² − 1)l/2 = kε(1 + 3ε/2 + …) lowers it by the known
// fraction ρgL/k = .6 %, which the tolerance of .1 % does not hide.
TEST_P(ClosedFormTest, HangingStrip) {
  const double length = 0.3, width = 0.02, k = 100.0, density = 0.2;
  const auto model = std::make_shared<const ClothModel>(
      MakeStrip(length, width, 60, 5), HangingStripScene(kGravity), MakeLaw(GetParam()));
  const State end = Settle(model, LinearMaterial(k, 1e-6, density), 0.05, 300);
  EXPECT_LT(end.v.cwiseAbs().maxCoeff(), 1e-9);
  const double load = density * kGravity * length / k;  // strain at the clamp
  const double expected = load / 2 * (1.0 - load);
  const double strain = TipMove(model->mesh, end.x).x() / length;
  std::printf("%s: strain %.6e, expected %.6e\n", GetParam().c_str(), strain, expected);
  EXPECT_NEAR(load / 2, 2.943e-3, 1e-9);
  EXPECT_NEAR(strain, expected, 1e-3 * expected);
}

// A narrow cantilever under its own weight: the tip drops by Γ/8 of its length at small Γ =
// ρgL³/D_beam (.01250 at Γ = .1) [MODEL, M53]. Free long edges let it curl across, so that D_beam =
// D(1 − ν²) with ν = −1/3 of the hinge model. The tolerance of 2 % covers the hinges that the free
// edges lack (1/(9·12) softer) and the end of the clamp, which is the last held vertex in one row
// and half a spacing before it in the next (a quarter of a spacing is 1.7 %).
TEST_P(ClosedFormTest, Cantilever) {
  const double density = 0.2, spacing = 0.1 / 60, length = 60 * spacing, gamma = 0.1;
  const double beam_rigidity = density * kGravity * length * length * length / gamma;
  const auto model = std::make_shared<const ClothModel>(
      MakeStrip(64 * spacing, 12 * spacing * std::sqrt(0.75), 64, 12),
      CantileverScene(4.1 * spacing, kGravity), MakeLaw(GetParam()));
  const State end = Settle(model, LinearBeam(1e4, beam_rigidity, density), 0.05, 200);
  EXPECT_LT(end.v.cwiseAbs().maxCoeff(), 1e-9);
  const double drop = -TipMove(model->mesh, end.x).z() / length;
  std::printf("%s: H/L %.5f, beam .01250\n", GetParam().c_str(), drop);
  EXPECT_NEAR(drop, 0.0125, 0.02 * 0.0125);
}

}  // namespace
}  // namespace drape
