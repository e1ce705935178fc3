// SPDX-License-Identifier: Apache-2.0
// Samples of the hierarchy against the fits of one material that they are made of.
#include <gtest/gtest.h>

#include "solver/posterior/variational_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kSpecimenAngles = 36;
constexpr double kShortJump = 3e-4;  // [m]

class HierarchicalSamplesTest : public testing::Test {
 protected:
  HierarchicalSamplesTest() {
    hierarchy_.base = test::TestMaterial();
    hierarchy_.fabric = ParameterTying::kColumns;
    hierarchy_.fabric_sigma = 0.5;
    hierarchy_.specimen_stretch_sigma = 0.2;
    hierarchy_.specimen_bend_sigma = 0.1;
    hierarchy_.specimens = 2;
    AddDrape(0, 1);
    AddDrape(0, 2);
    AddDrape(1, 3);
    options_.sigma_px = 0.5;
    options_.equilibrium.tolerance = 1e-12;
  }
  void AddDrape(int specimen, uint64_t seed) {
    const State drape =
        test::Settled(*backend_, hierarchy_.base, test::RandomStart(backend_->model(), seed));
    specimens_[specimen].observations.push_back(test::MakeObservation(
        backend_->model().mesh, drape, kSpecimenAngles, std::to_string(seed)));
    specimens_[specimen].starts.push_back(drape);
  }
  SpecimenDrapes FirstDrape() const {
    return {{specimens_[0].observations[0]}, {specimens_[0].starts[0]}};
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  HierarchicalModel hierarchy_;
  std::vector<SpecimenDrapes> specimens_{2};
  OutlineResidualOptions options_ = test::CloseOutlineOptions();
  std::mt19937_64 random_{8};
};

TEST_F(HierarchicalSamplesTest, TheHierarchyNamesAndTiesItsNumbers) {
  ASSERT_EQ(hierarchy_.num_latents(), 7 + 4);
  EXPECT_EQ(hierarchy_.NameFor(4), "bend[0]");
  EXPECT_EQ(hierarchy_.NameFor(9), "specimen 2 stretch");
  const Eigen::MatrixXd second = hierarchy_.LogEntries(1);
  EXPECT_EQ(second(0, 0), 0.5);
  EXPECT_EQ(second.col(7).norm() + second.col(8).norm(), 0.0);
  EXPECT_EQ(second(23, 9), 0.2);
  EXPECT_EQ(second(24, 9), 0.0);
  EXPECT_EQ(second(38, 10), 0.1);
}

// Jacobian of both draws and all observations against central differences.
TEST_F(HierarchicalSamplesTest, JacobiansAgreeWithCentralDifferences) {
  HierarchicalSamples draws(backend_.get(), hierarchy_, specimens_, options_, 2);
  const int n = draws.num_latents();
  ASSERT_TRUE(draws.StartAt(Eigen::VectorXd::Zero(n)));
  const Eigen::MatrixXd points = 0.02 * test::RandomMatrix(n, 2, random_);
  const Eigen::VectorXd direction = test::RandomMatrix(n, 1, random_);
  draws.Prepare(points, true);
  Eigen::VectorXd residual;
  RowMatrix jacobian;
  for (int s = 0; s < 2; ++s) {
    draws.Prepare(points, true);
    ASSERT_TRUE(draws.Residuals(s, &residual, &jacobian));
    ASSERT_EQ(residual.size(), 3 * kSpecimenAngles);
    const Eigen::VectorXd exact = jacobian * direction;
    double best = 1.0;
    for (const double step : {1e-3, 1e-4, 1e-5}) {
      Eigen::VectorXd up, down;
      draws.Prepare(points.colwise() + step * direction, false);
      ASSERT_TRUE(draws.Residuals(s, &up, nullptr));
      draws.Prepare(points.colwise() - step * direction, false);
      ASSERT_TRUE(draws.Residuals(s, &down, nullptr));
      best = std::min(best, ((up - down) / (2 * step) - exact).norm() / exact.norm());
    }
    EXPECT_LT(best, 1e-6);
  }
}

// The result of a sample does not depend on the others.
TEST_F(HierarchicalSamplesTest, SamplesAreIndependentOfEachOther) {
  const Eigen::MatrixXd points = 0.05 * test::RandomMatrix(11, 3, random_);
  const auto residual = [&](const Eigen::MatrixXd& u, int draw) {
    HierarchicalSamples draws(backend_.get(), hierarchy_, specimens_, options_, int(u.cols()));
    EXPECT_TRUE(draws.StartAt(Eigen::VectorXd::Zero(11)));
    draws.Prepare(u, false);
    Eigen::VectorXd r;
    EXPECT_TRUE(draws.Residuals(draw, &r, nullptr));
    return r;
  };
  EXPECT_EQ(residual(points, 2), residual(points.col(2), 0));
}

// A far point is found in parts where it is too far from the prediction at once.
TEST_F(HierarchicalSamplesTest, ADrapeIsFollowedInParts) {
  const Eigen::VectorXd far = 0.3 * test::RandomMatrix(11, 1, random_);
  Eigen::VectorXd at_once, in_parts;
  const auto residual = [&](double max_jump, Eigen::VectorXd* r) {
    options_.max_jump = max_jump;
    HierarchicalSamples draws(backend_.get(), hierarchy_, specimens_, options_, 1);
    EXPECT_TRUE(draws.StartAt(Eigen::VectorXd::Zero(11)));
    draws.Prepare(far, false);
    EXPECT_TRUE(draws.Residuals(0, r, nullptr));
    return draws.counts();
  };
  EXPECT_EQ(residual(1.0, &at_once).jumps, 0);
  EXPECT_GT(residual(kShortJump, &in_parts).jumps, 0);
  EXPECT_LT((in_parts - at_once).norm(), 1e-6 * at_once.norm());
  HierarchicalSamples impatient(backend_.get(), hierarchy_, specimens_, options_, 1,
                                LostBranchPolicy::kRejectAtOnce);
  ASSERT_TRUE(impatient.StartAt(Eigen::VectorXd::Zero(11)));
  impatient.Prepare(far, false);
  EXPECT_FALSE(impatient.Residuals(0, &in_parts, nullptr));
}

// A trial changes no start: the next trial starts at the same point, bit for bit.
TEST_F(HierarchicalSamplesTest, ATrialLeavesTheDrapesWhereTheyWere) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(11);
  const Eigen::VectorXd far = 0.3 * test::RandomMatrix(11, 1, random_);
  options_.max_jump = kShortJump;
  HierarchicalSamples draws(backend_.get(), hierarchy_, specimens_, options_, 1);
  ASSERT_TRUE(draws.StartAt(zero));
  const std::vector<Eigen::VectorXd> shapes = draws.Shapes(0);
  draws.Prepare(far, false);
  ASSERT_GT(draws.counts().jumps, 0);  // in parts
  draws.Prepare(zero, false);
  Eigen::VectorXd residual;
  EXPECT_TRUE(draws.Residuals(0, &residual, nullptr));
  EXPECT_EQ(draws.Shapes(0), shapes);
}

// Independent samples need no derivatives.
TEST_F(HierarchicalSamplesTest, WithoutDerivativesADrawIsFoundFromItsStart) {
  const Eigen::VectorXd near = 0.01 * test::RandomMatrix(11, 1, random_);
  HierarchicalSamples plain(backend_.get(), hierarchy_, specimens_, options_, 1);
  HierarchicalSamples started(backend_.get(), hierarchy_, specimens_, options_, 1);
  ASSERT_TRUE(started.StartAt(near));
  plain.Prepare(near, false);
  started.Prepare(near, false);
  Eigen::VectorXd found, expected;
  ASSERT_TRUE(plain.Residuals(0, &found, nullptr));
  ASSERT_TRUE(started.Residuals(0, &expected, nullptr));
  EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
  EXPECT_EQ(plain.counts().tangents, 0);
}

// Where no part of the way is valid, the residuals are extrapolated and counted.
TEST_F(HierarchicalSamplesTest, PastItsBranchASampleIsExtrapolated) {
  options_.max_jump = 1e-12;
  HierarchicalSamples refuse(backend_.get(), hierarchy_, specimens_, options_, 2);
  HierarchicalSamples straight(backend_.get(), hierarchy_, specimens_, options_, 2,
                               LostBranchPolicy::kExtrapolate);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(11);
  ASSERT_TRUE(refuse.StartAt(zero) && straight.StartAt(zero));
  Eigen::VectorXd at_zero, beyond;
  RowMatrix jacobian, jacobian_beyond;
  straight.Prepare(zero.replicate(1, 2), true);
  ASSERT_TRUE(straight.Residuals(0, &at_zero, &jacobian));
  EXPECT_EQ(straight.num_extrapolated(), 0);
  Eigen::MatrixXd points = zero.replicate(1, 2);
  points.col(1) = 0.1 * test::RandomMatrix(11, 1, random_);
  for (const bool with_jacobians : {false, true}) {
    refuse.Prepare(points, with_jacobians);
    straight.Prepare(points, with_jacobians);
    EXPECT_EQ(straight.num_extrapolated(), 1);
    EXPECT_TRUE(refuse.Residuals(0, &beyond, nullptr));
    EXPECT_FALSE(refuse.Residuals(1, &beyond, nullptr));
    ASSERT_TRUE(straight.Residuals(1, &beyond, with_jacobians ? &jacobian_beyond : nullptr));
    EXPECT_LT((beyond - at_zero - jacobian * points.col(1)).norm(), 1e-9 * beyond.norm());
  }
  EXPECT_EQ(jacobian_beyond, jacobian);
}

// Two scales, two specimens with noise of their own, one of them with two drapes.
TEST_F(HierarchicalSamplesTest, JacobiansOfElementDrawsAgreeWithCentralDifferences) {
  const auto draws = HierarchicalSamples::Elementwise(backend_.get(), hierarchy_.base, {0.5, 0.2},
                                                      specimens_, options_, 2, 5);
  ASSERT_EQ(draws->num_latents(), 78);
  ASSERT_EQ(draws->num_residuals(), 3 * kSpecimenAngles);
  Eigen::VectorXd point(78);
  point << Eigen::VectorXd::Zero(39), Eigen::VectorXd::Constant(39, 0.5);
  ASSERT_TRUE(draws->StartAt(point));
  const Eigen::VectorXd direction = test::RandomMatrix(78, 1, random_);
  draws->Prepare(point.replicate(1, 2), true);
  Eigen::VectorXd residual, other;
  RowMatrix jacobian;
  ASSERT_TRUE(draws->Residuals(1, &residual, &jacobian));
  ASSERT_TRUE(draws->Residuals(0, &other, nullptr));
  EXPECT_GT((residual - other).norm(), 1e-3);  // noise of their own
  const Eigen::VectorXd exact = jacobian * direction;
  double best = 1.0;
  for (const double step : {1e-3, 1e-4, 1e-5}) {
    Eigen::VectorXd up, down;
    draws->Prepare((point + step * direction).replicate(1, 2), false);
    ASSERT_TRUE(draws->Residuals(1, &up, nullptr));
    draws->Prepare((point - step * direction).replicate(1, 2), false);
    ASSERT_TRUE(draws->Residuals(1, &down, nullptr));
    best = std::min(best, ((up - down) / (2 * step) - exact).norm() / exact.norm());
  }
  EXPECT_LT(best, 1e-6);
}

// The same image twice: what differs is the specimens' noise, of the size asked for.
TEST_F(HierarchicalSamplesTest, SpecimensOfElementDrawsHaveNoiseOfTheirOwn) {
  const std::vector<SpecimenDrapes> twice = {FirstDrape(), FirstDrape()};
  const auto difference = [&](double element_sigma, uint64_t seed) {
    const auto draws = HierarchicalSamples::Elementwise(
        backend_.get(), hierarchy_.base, {0.5, element_sigma}, twice, options_, 2, seed);
    EXPECT_TRUE(draws->StartAt(
        (Eigen::VectorXd(78) << Eigen::VectorXd::Zero(39), Eigen::VectorXd::Ones(39)).finished()));
    Eigen::VectorXd r;
    EXPECT_TRUE(draws->Residuals(0, &r, nullptr));
    return Eigen::VectorXd(r.head(kSpecimenAngles) - r.tail(kSpecimenAngles));
  };
  const Eigen::VectorXd small = difference(1e-4, 5), large = difference(2e-4, 5);
  EXPECT_GT(small.norm(), 1e-5);
  EXPECT_LT((large - 2 * small).norm(), 0.05 * large.norm());
  EXPECT_EQ(difference(1e-4, 5), small);
  EXPECT_NE(difference(1e-4, 6), small);
}

TEST_F(HierarchicalSamplesTest, OtherDrawsStartFromTheSameDrapes) {
  HierarchicalSamples draws(backend_.get(), hierarchy_, specimens_, options_, 2);
  ASSERT_TRUE(draws.StartAt(Eigen::VectorXd::Zero(11)));
  const auto more = draws.WithSamples(4, LostBranchPolicy::kReject);
  ASSERT_EQ(more->num_draws(), 4);
  more->Prepare(Eigen::MatrixXd::Zero(11, 4), false);
  EXPECT_LT((more->Shapes(3)[2] - specimens_[1].starts[0].x).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace drape
