// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/effective_stiffness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_scaling.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

class EffectiveStiffnessTest : public testing::Test {
 protected:
  const ClothModel& model() const { return backend_->model(); }
  // Its share of the energy [J], by a difference.
  double Energy(const MaterialField& material, bool bend) const {
    MaterialField without = material;
    if (bend) {
      for (int i = 0; i < kBendEntries; ++i) without.bend[0].entries()[i] = 0.0;
    } else {
      for (int i = 0; i < kStretchEntries; ++i) without.stretch[0].entries()[i] = 0.0;
    }
    return drape::Energy(model(), material, x_) - drape::Energy(model(), without, x_);
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(200);
  const Eigen::VectorXd x_ =
      test::Settled(*backend_, test::TestMaterial(), test::RandomStart(backend_->model(), 3)).x;
};

TEST_F(EffectiveStiffnessTest, TheEnergyIsLinearInTheEntries) {
  const MaterialField material = test::TestMaterial();
  const Eigen::VectorXd by_entry = EnergyByEntry(model(), x_);
  double stretch = 0.0, bend = 0.0;
  for (int i = 0; i < kStretchEntries; ++i)
    stretch += by_entry[i] * material.stretch[0].entries()[i];
  for (int i = 0; i < kBendEntries; ++i)
    bend += by_entry[kStretchEntries + i] * material.bend[0].entries()[i];
  EXPECT_NEAR(stretch / Energy(material, false), 1.0, 1e-9);
  EXPECT_NEAR(bend / Energy(material, true), 1.0, 1e-9);
}

// A linear isotropic table that has it would bend with the same energy.
TEST_F(EffectiveStiffnessTest, BendsAsAnIsotropicTableOfThatRigidity) {
  MaterialField material = test::TestMaterial();
  for (int i = 0; i < kBendEntries; ++i) material.bend[0].entries()[i] *= 1.0 + 0.3 * i;
  const Eigen::VectorXd weights = StiffnessWeights(model(), {x_});
  MaterialField isotropic = material;
  for (int i = 0; i < kBendEntries; ++i)
    isotropic.bend[0].entries()[i] = kBendPerRigidity * EffectiveBend(material, weights);
  EXPECT_NEAR(Energy(isotropic, true) / Energy(material, true), 1.0, 1e-9);
  EXPECT_NEAR(weights.head(kStretchEntries).sum(), 1.0, 1e-12);
  EXPECT_NEAR(weights.tail(kBendEntries).sum(), 1.0, 1e-12);
}

// Columns of the bend table for curvatures that a shallow ripple does not have do not count.
TEST_F(EffectiveStiffnessTest, EntriesThatADrapeDoesNotReachHaveNoWeight) {
  Eigen::VectorXd ripple = model().RestState().x;
  for (Eigen::Index i = 0; i < ripple.size(); i += 3)
    ripple[i + 2] += 1e-4 * std::sin(100.0 * ripple[i]);
  MaterialField material = test::TestMaterial();
  const Eigen::VectorXd weights = StiffnessWeights(model(), {ripple});
  const double before = EffectiveBend(material, weights);
  for (auto& row : material.bend[0].b) row[kBendCols - 1] *= 100.0;
  EXPECT_NEAR(EffectiveBend(material, weights) / before, 1.0, 1e-9);
  EXPECT_GT(MeanBend(material.bend[0]) / before, 5.0);
}

TEST_F(EffectiveStiffnessTest, WithoutADrapeItIsTheMean) {
  const MaterialField material = test::TestMaterial();
  const Eigen::VectorXd equal = EqualStiffnessWeights();
  EXPECT_NEAR(EffectiveStretch(material, equal) / MeanStretch(material.stretch[0]), 1.0, 1e-12);
  EXPECT_NEAR(EffectiveBend(material, equal) / MeanBend(material.bend[0]), 1.0, 1e-12);
  // A cloth without any strain.
  const Eigen::VectorXd flat = StiffnessWeights(model(), {model().RestState().x});
  EXPECT_NEAR((flat - equal).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace drape
