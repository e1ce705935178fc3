// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/strips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "physics/material/material_scaling.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

// A strip's reading against closed forms, its derivative against differences.

constexpr double kGravity = 9.80665, kDegree = M_PI / 180.0;

LabMeasurement Cantilever(double length, double direction = 0.0) {
  return {
      .kind = LabMeasurementKind::kCantilever, .direction = direction, .points = {{length, 0.0}}};
}

LabMeasurement Tensile(double force, double direction = 0.0) {
  return {.kind = LabMeasurementKind::kTensile,
          .direction = direction,
          .length = 0.2,
          .width = 0.05,
          .points = {{force, 0.0}}};
}

double Reading(const LabMeasurement& test, const MaterialField& material,
               const std::string& law = "smooth") {
  return Strips({test}, MakeLaw(law)).Compute(material).value()[0];
}

// A cloth of bending length c, D = ρ·g·c³.
MaterialField OfBendingLength(double c, double density) {
  return LinearMaterial(200.0, density * kGravity * c * c * c, density);
}

class TestedStripOfLaw : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Laws, TestedStripOfLaw, testing::Values("smooth", "reference"));

// The table's D falls as the standard's G: from a reading comes back the bending length.
TEST_P(TestedStripOfLaw, ACantileverFallsAsAHeavyElastica) {
  constexpr double kLength = 0.06;
  EXPECT_NEAR(
      Reading(Cantilever(kLength), OfBendingLength(kLength / std::cbrt(8.0042), 0.2), GetParam()),
      41.5, 0.1);
  for (const double gamma : {0.5, 2.0, 8.0, 20.0, 50.0})
    for (const double direction : {0.0, 30.0, 45.0, 90.0}) {
      const double angle = Reading(Cantilever(kLength, direction),
                                   OfBendingLength(kLength / std::cbrt(gamma), 0.2), GetParam());
      EXPECT_NEAR(HeavyElasticaGamma(angle * kDegree), gamma, 0.006 * gamma) << direction;
    }
}

TEST_P(TestedStripOfLaw, ClothsFromLimpToStiffAreComputed) {
  for (const double density : {0.06, 0.3})
    for (const double c : {0.01, 0.03, 0.06}) {
      const double angle = Reading(Cantilever(2.0 * c), OfBendingLength(c, density), GetParam());
      EXPECT_NEAR(EstimateBending(2.0 * c, angle, density).length, c, 0.003 * c);
    }
}

TEST_P(TestedStripOfLaw, APulledStripOfALinearTableStretchesInClosedForm) {
  constexpr double k = 100.0, kWidth = 0.05;
  for (const double direction : {0.0, 90.0})
    for (const double stretch : {1.002, 1.05, 1.1, 1.2}) {
      const double load = k * (stretch * stretch - 1.0) * stretch / 2.0;
      const double computed =
          Reading(Tensile(load * kWidth, direction), LinearMaterial(k, 1e-6, 0.2), GetParam());
      EXPECT_NEAR(k * (computed * computed - 1.0) * computed / 2.0, load, 1e-3 * load);
    }
}

// A bend table of ratio 2: the strip has within 4 % the rigidity that an unstructured mesh has in
// its direction.
TEST(Strips, BendAlongItsDirection) {
  MaterialField material = LinearMaterial(200.0, 1.0, 0.2);
  const double D = 0.2 * kGravity * std::pow(0.03, 3);
  for (int c = 0; c < kBendCols; ++c) {
    material.bend[0].b[0][c] = kBendPerRigidity * 0.7 * D;
    material.bend[0].b[1][c] = kBendPerRigidity * D;
    material.bend[0].b[2][c] = kBendPerRigidity * 1.4 * D;
  }
  for (const double direction : {0.0, 45.0, 90.0, -30.0}) {
    const double angle = Reading(Cantilever(0.06, direction), material);
    const double G = EstimateBending(0.06, angle, 0.2).rigidity;
    EXPECT_NEAR(G / DirectionalRigidity(material.bend[0], direction * kDegree), 1.0, 0.04)
        << direction;
  }
  // A strip along the weft bends by the hinges across it.
  EXPECT_LT(Reading(Cantilever(0.06, 0.0), material), Reading(Cantilever(0.06, 90.0), material));
}

TEST(Strips, PullAlongItsDirection) {
  MaterialField material = LinearMaterial(100.0, 1e-6, 0.2);
  for (auto& row : material.stretch[0].c) row[2] *= 2.0;  // warp
  EXPECT_LT(Reading(Tensile(0.5, 90.0), material), Reading(Tensile(0.5, 0.0), material));
  EXPECT_DOUBLE_EQ(Reading(Tensile(0.5, 180.0), material), Reading(Tensile(0.5, 0.0), material));
}

// By five-point differences along a direction in which each entry moves.
TEST_P(TestedStripOfLaw, TheDerivativeIsExact) {
  const MaterialField material = test::TestMaterial();
  const TableParametrisation parametrisation(material, ParameterTying::kEntries);
  std::mt19937_64 random(1);
  const Eigen::VectorXd along = test::RandomMatrix(kMaterialEntries, 1, random) / 3.0;
  for (const LabMeasurement& test : {Cantilever(0.06, 20.0), Tensile(0.4, 20.0)}) {
    RolloutResiduals strip(&parametrisation, Strips({test}, MakeLaw(GetParam())).MakeBlocks(), {});
    strip.PrepareForEvaluation(true, true);
    ASSERT_TRUE(strip.has_accepted());
    const Eigen::VectorXd by_theta = strip.accepted().jacobian.row(0);
    const auto at = [&](double step) {
      Eigen::Map<Eigen::VectorXd>(strip.theta(), kMaterialEntries) = step * along;
      strip.PrepareForEvaluation(false, true);
      EXPECT_TRUE(strip.all_valid());
      return strip.residual(0)[0];
    };
    double least = 1.0;  // over a sweep: kinks of the reference law above, rounding below
    for (const double step : {1e-2, 3e-3, 1e-3, 3e-4}) {
      const double difference =
          (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
      least = std::min(least, std::abs(difference / by_theta.dot(along) - 1.0));
    }
    EXPECT_LT(least, 1e-6) << ToString(test.kind);
  }
}

TEST(Strips, WhatCannotBeComputedIsAStatus) {
  const Strips strip({Cantilever(0.3)}, MakeLaw("smooth"));
  EXPECT_FALSE(strip.Compute(LinearMaterial(200.0, 1e-14, 0.2)));
  EXPECT_TRUE(strip.Compute(OfBendingLength(0.15, 0.2)));
}

}  // namespace
}  // namespace drape
