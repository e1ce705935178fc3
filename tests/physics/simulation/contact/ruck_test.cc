// SPDX-License-Identifier: Apache-2.0
// The fold of a strip on a floor whose ends were moved together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/implicit_euler.h"
#include "tests/physics/cloth/contact/sheets.h"
#include "tests/physics/simulation/textbook/closed_forms.h"

namespace drape {
namespace {

// The height of a free fold in small deflection, where the heavy beam w'''' + p²w'' = −1/ℓ³ lifts
// off with w = w' = w'' = 0 at both ends: tan(pL/2) = pL/2, w = 1.3256·Δ^(4/7)·ℓ^(3/7) with ℓ³ =
// D/ρg and Δ the way by which the ends were moved together [Vella 2009].
TEST(Ruck, HasTheHeightOfAHeavyBeam) {
  constexpr double kRigidity = 1e-5, kLength = 0.14;
  const double elastic = std::cbrt(kRigidity / (test::kDensity * test::kGravity));  // ℓ [m]
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -test::kGravity);
  scene.contact = Contact{.thickness = 0.0, .range = 2e-5, .obstacles = {PlaneObstacle{}}};
  const auto model =
      std::make_shared<ClothModel>(MakeStrip(kLength, 6e-3, 112, 5), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearBeam(1e5, kRigidity, test::kDensity), 0.05, {.tolerance = 1e-7});
  for (const double share : {0.01, 0.02}) {
    const double moved = share * elastic;
    State state = model->RestState();
    Surroundings around;
    // From a low fold in the middle of a strip that is compressed evenly.
    for (int i = 0; i < model->mesh.num_vertices(); ++i) {
      const double u = model->mesh.uv(0, i);
      state.x[3 * i] -= moved * (u / kLength - 0.5);
      const double from_middle = std::min(std::abs(u - 0.5 * kLength) / (1.5 * elastic), 1.0);
      state.x[3 * i + 2] = 1.8e-5 + 1e-3 * std::pow(std::cos(0.5 * M_PI * from_middle), 2);
      if (u < 1e-9 || u > kLength - 1e-9)
        around.pins.push_back({.vertex = i, .stiffness = 1e5, .place = state.x.segment<3>(3 * i)});
    }
    for (int step = 0; step < 60; ++step)
      ASSERT_EQ(euler.Advance(state, around), IntegratorStatus::kOk) << step;
    EXPECT_LT(state.v.cwiseAbs().maxCoeff(), 1e-4);
    double height = 0.0;
    for (Eigen::Index i = 2; i < state.x.size(); i += 3) height = std::max(height, state.x[i]);
    height -= state.x[2];
    const double expected = 1.3256 * std::pow(moved, 4.0 / 7.0) * std::pow(elastic, 3.0 / 7.0);
    EXPECT_NEAR(height, expected, 0.03 * expected) << share;
  }
}

}  // namespace
}  // namespace drape
