// SPDX-License-Identifier: Apache-2.0
// The decisions of Newton's method on artificial residuals and energies.
#include <gmock/gmock.h>

#include <limits>

#include "physics/simulation/statics/statics.h"

namespace drape {
namespace {

using testing::DoubleEq;
using testing::Optional;

constexpr double kRadius = 3e-3;
const EquilibriumOptions kOptions{
    .tolerance = 1e-9, .shift = {.first = 25.0, .most = 400.0}, .first_radius = kRadius};

class NewtonControlTest : public testing::Test {
 protected:
  // A step whose first factorisation succeeds.
  NewtonVerdict Step(double move, double residual, double energy) {
    EXPECT_EQ(control_.Next(), NewtonNext::kStep);
    control_.FirstShift();
    control_.Scale(move);
    return control_.Judge(residual, energy);
  }
  // The largest move that the next step may make [m].
  double Radius() {
    constexpr double kFar = 1e3;
    return kFar * control_.Scale(kFar);
  }
  NewtonControl control_{kOptions, 1.0, 0.0};
};

TEST_F(NewtonControlTest, EndsAtTheToleranceOnly) {
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(Step(1e-4, 1.1e-9, -1.0), NewtonVerdict::kAccept);
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(Step(1e-4, 1e-9, -2.0), NewtonVerdict::kAccept);
  EXPECT_EQ(control_.Next(), NewtonNext::kConverged);
  EXPECT_EQ(NewtonControl(kOptions, std::numeric_limits<double>::quiet_NaN(), 0.0).Next(),
            NewtonNext::kStep);
}

TEST_F(NewtonControlTest, EndsAtTheIterationLimitAndWhenCancelled) {
  std::atomic<bool> cancel = false;
  EquilibriumOptions options = kOptions;
  options.max_iterations = 2;
  options.cancel = &cancel;
  control_ = NewtonControl(options, 1.0, 0.0);
  Step(1e-4, 0.9, -1.0);
  Step(1e-4, 0.8, -2.0);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
  EXPECT_EQ(control_.iterations(), 2);
  cancel = true;
  EXPECT_EQ(control_.Next(), NewtonNext::kCancelled);
}

TEST_F(NewtonControlTest, AFailedFactorisationRaisesTheShiftUntilNoneIsLeft) {
  EXPECT_EQ(control_.FirstShift(), 0.0);
  EXPECT_THAT(control_.NextShift(), Optional(25.0));
  EXPECT_THAT(control_.NextShift(), Optional(100.0));
  EXPECT_THAT(control_.NextShift(), Optional(400.0));
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(control_.NextShift(), std::nullopt);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
  EXPECT_EQ(control_.factorisations(), 4);
}

TEST_F(NewtonControlTest, TheShiftStaysWhereItWasRaisedAndDecaysAfterwards) {
  control_.FirstShift();
  control_.NextShift();
  control_.NextShift();
  control_.Scale(1e-4);
  control_.Judge(0.9, -1.0);
  for (const double expected : {100.0, 25.0, 6.25, 0.0, 0.0}) {
    EXPECT_EQ(control_.FirstShift(), expected);
    control_.Scale(1e-4);
    control_.Judge(0.9, -1.0);
  }
  EXPECT_EQ(control_.steps()[0].shift, 100.0);
  EXPECT_EQ(control_.steps()[2].shift, 25.0);
}

TEST_F(NewtonControlTest, AShortenedStepKeepsAShift) {
  Step(2 * kRadius, 0.9, -1.0);
  EXPECT_EQ(control_.FirstShift(), kOptions.shift.first);
}

TEST_F(NewtonControlTest, StepsAreShortenedToTheRadius) {
  EXPECT_EQ(control_.Scale(0.95 * kRadius), 1.0);
  EXPECT_EQ(control_.Scale(kRadius), 1.0);
  EXPECT_THAT(control_.Scale(4 * kRadius), DoubleEq(0.25));
}

TEST_F(NewtonControlTest, TheRadiusGrowsAfterShortenedStepsUpToItsMaximum) {
  Step(0.5 * kRadius, 0.9, -1.0);
  EXPECT_THAT(Radius(), DoubleEq(kRadius));
  control_.Judge(0.8, -2.0);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * kRadius));
  control_.Judge(0.8, -3.0);
  Step(0.5 * kRadius, 0.8, -4.0);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * 1.5 * kRadius));
  for (int i = 0; i < 10; ++i) Step(1.0, 0.8, -5.0 - i);
  EXPECT_THAT(Radius(), DoubleEq(kOptions.max_radius));
}

TEST_F(NewtonControlTest, ALongNonMonotoneRunThatEndsWellKeepsTheRadius) {
  EXPECT_EQ(Step(1.0, 0.9, 1.0), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1.0, 0.9, 1.0), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1.0, 0.9, -1.0), NewtonVerdict::kAccept);
  EXPECT_THAT(Radius(), DoubleEq(kRadius));
  control_.Judge(0.9, 0.0);  // one step above the best energy, then one below
  EXPECT_EQ(Step(1e-4, 0.9, -2.0), NewtonVerdict::kAccept);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * kRadius));
}

TEST_F(NewtonControlTest, TheNinthStepAboveTheBestEnergyIsRejected) {
  Step(1e-4, 0.5, -1.0);
  for (int i = 0; i < 8; ++i)
    ASSERT_EQ(Step(1e-4, 0.1, -1.0 + 0.01 * i), NewtonVerdict::kNonMonotone) << i;
  EXPECT_EQ(Step(0.5 * kRadius, 1e-10, 0.0), NewtonVerdict::kRejectStep);
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);  // the best shape is not an equilibrium
  EXPECT_THAT(Radius(), DoubleEq(0.35 * 0.5 * kRadius));
  control_.Judge(0.4, -2.0);
  EXPECT_EQ(control_.steps().back().residual, 0.5);
  EXPECT_EQ(Step(1e-4, 0.5, 0.0), NewtonVerdict::kNonMonotone);  // the count restarts
}

TEST_F(NewtonControlTest, AnEnergyThatIsNotFiniteIsRejectedAtOnce) {
  for (const double energy :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(Step(1e-4, 0.5, energy), NewtonVerdict::kRejectStep) << energy;
}

TEST_F(NewtonControlTest, GivesUpWhenStepsHaveNoLength) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Step(1e-8, 0.5, nan);
  EXPECT_EQ(Step(1e-9, 0.5, nan), NewtonVerdict::kRejectStep);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
}

TEST_F(NewtonControlTest, NearTheEndALowerResidualIsEnough) {
  EXPECT_EQ(Step(1e-4, 1e-4, 1.0), NewtonVerdict::kNonMonotone);  // the best one has energy 1
  EXPECT_EQ(Step(1e-4, 5e-4, -1.0), NewtonVerdict::kAccept);
  EXPECT_EQ(Step(1e-4, 4.6e-4, -0.5), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1e-4, 4.4e-4, -0.5), NewtonVerdict::kAccept);
  EXPECT_EQ(Step(1e-4, 4.4e-4, -0.6), NewtonVerdict::kAccept);  // below the last accepted energy
  ASSERT_EQ(control_.steps().size(), 5u);
  EXPECT_FALSE(control_.steps()[2].accepted);
  EXPECT_TRUE(control_.steps()[3].accepted);
  EXPECT_EQ(control_.steps()[3].residual, 4.6e-4);
  EXPECT_EQ(control_.steps()[3].energy, -0.5);
}

TEST_F(NewtonControlTest, ADrapeIsStableWhileTheSkewPartOfKIsSmall) {
  EXPECT_EQ(control_.Conclude(0.99), EquilibriumStatus::kStable);
  EXPECT_EQ(control_.Conclude(1.0), EquilibriumStatus::kUnstable);
  EXPECT_EQ(control_.Conclude(std::nullopt), EquilibriumStatus::kUnstable);
  EXPECT_EQ(control_.factorisations(), 3);
}

}  // namespace
}  // namespace drape
