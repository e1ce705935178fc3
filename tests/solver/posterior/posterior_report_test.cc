// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <span>
#include <string>

#include "solver/fit/effective_stiffness.h"
#include "solver/posterior/posterior_io.h"
#include "tests/physics/cloth_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;
using testing::Not;

PosteriorFit WithTables(ParameterTying tying) {
  PosteriorFit fit;
  fit.hierarchy.base = TestMaterial();
  for (double& entry : std::span(fit.hierarchy.base.stretch[0].entries(), kStretchEntries))
    entry *= 1.1;  // numbers whose mean is rounded
  fit.hierarchy.fabric = tying;
  fit.hierarchy.fabric_sigma = 0.5;
  const int size = fit.hierarchy.num_latents();
  fit.distribution.gaussian =
      FromCovariance(Eigen::VectorXd::Zero(size), 0.1 * Eigen::MatrixXd::Identity(size, size));
  return fit;
}

// Only bend is varied; the mean of 400 equal numbers is rounded, which is no uncertainty.
TEST(PosteriorReport, WhatIsHeldHasNoUncertainty) {
  for (const ParameterTying tying : {ParameterTying::kBendScale, ParameterTying::kBendRows}) {
    const PosteriorFit fit = WithTables(tying);
    const PosteriorStiffness stiffness = ComputePosteriorStiffness(fit, EqualStiffnessWeights());
    EXPECT_EQ(stiffness.stretch_deviation, 0.0);
    EXPECT_GT(stiffness.bend_deviation, 0.01 * stiffness.bend);
    const std::string text = PosteriorTable(fit, EqualStiffnessWeights());
    EXPECT_THAT(text, HasSubstr(" N/m (not varied), bend "));
    EXPECT_THAT(text, Not(HasSubstr("e-1")));
  }
  const PosteriorFit all = WithTables(ParameterTying::kEntries);
  EXPECT_GT(ComputePosteriorStiffness(all, EqualStiffnessWeights()).stretch_deviation, 0.0);
  EXPECT_THAT(PosteriorTable(all, EqualStiffnessWeights()), Not(HasSubstr("not varied")));
}

}  // namespace
}  // namespace drape::test
