// SPDX-License-Identifier: Apache-2.0
// The evidence lower bound on problems whose posterior is known.
#include "solver/posterior/variational_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "tests/physics/cloth_fixture.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kLatents = 6, kResiduals = 9;

// r = A·u − b, so that the posterior is N(mean, Σ), Σ⁻¹ = AᵀA + 1, mean = Σ·Aᵀ·b. With `bend`, r
// also has ½·bend·(A·u)².
class Observations final : public SampledResiduals {
 public:
  explicit Observations(int draws, double bend = 0.0, int latents = kLatents)
      : draws_(draws), bend_(bend) {
    std::mt19937_64 random(7);
    a = test::RandomMatrix(kResiduals, latents, random);
    b = test::RandomMatrix(kResiduals, 1, random);
  }
  int num_latents() const override { return static_cast<int>(a.cols()); }
  int num_residuals() const override { return kResiduals; }
  int num_draws() const override { return draws_; }
  void Prepare(const Eigen::MatrixXd& points, bool) override { points_ = points; }
  bool Residuals(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const override {
    const Eigen::VectorXd seen = a * points_.col(draw);
    *residual = seen + 0.5 * bend_ * seen.cwiseAbs2() - b;
    if (jacobian != nullptr) *jacobian = (1 + bend_ * seen.array()).matrix().asDiagonal() * a;
    return true;
  }
  Eigen::MatrixXd Precision() const {
    return a.transpose() * a + Eigen::MatrixXd::Identity(a.cols(), a.cols());
  }
  Eigen::VectorXd Mean() const { return Precision().ldlt().solve(a.transpose() * b); }
  // −ln ∫ exp(−½‖A·u − b‖²) N(u; 0, 1) du.
  double NegativeLogEvidence() const {
    const Eigen::MatrixXd spread =
        a * a.transpose() + Eigen::MatrixXd::Identity(kResiduals, kResiduals);
    return 0.5 * b.dot(spread.ldlt().solve(b)) + 0.5 * std::log(spread.determinant());
  }

  Eigen::MatrixXd a;
  Eigen::VectorXd b;

 private:
  int draws_;
  double bend_;
  Eigen::MatrixXd points_;
};

GaussianPosterior Prior(int latents = kLatents) {
  return {Eigen::VectorXd::Zero(latents), Eigen::MatrixXd::Identity(latents, latents),
          Eigen::MatrixXd::Identity(latents, latents)};
}

VariationalOptions Options(int rank) {
  VariationalOptions options;
  options.rank = rank;
  options.trust_region.max_iterations = 200;
  options.trust_region.cost_tolerance = 1e-15;
  options.trust_region.initial_damping = 1e-3;
  return options;
}

TEST(FitPosterior, AFullTriangleFindsAConjugatePosterior) {
  Observations data(2 * kLatents);
  const VariationalFit fit = FitPosterior(data, Prior(), Options(kLatents));
  EXPECT_EQ(fit.termination, FitTermination::kConverged);
  EXPECT_LT((fit.gaussian.mean - data.Mean()).norm(), 1e-6);
  EXPECT_LT((fit.gaussian.Covariance() - data.Precision().inverse()).norm(), 1e-6);
  EXPECT_NEAR(fit.cost, data.NegativeLogEvidence(), 1e-6);  // the bound is tight
}

// The best independent normal has the precisions' diagonal [Bishop 2006, section 10.1.2].
TEST(FitPosterior, MeanFieldFindsTheBestIndependentNormal) {
  Observations data(2 * kLatents);
  const VariationalFit fit = FitPosterior(data, Prior(), Options(0));
  EXPECT_LT((fit.gaussian.mean - data.Mean()).norm(), 1e-6);
  const Eigen::VectorXd variance = data.Precision().diagonal().cwiseInverse();
  EXPECT_LT((fit.gaussian.Covariance() - Eigen::MatrixXd(variance.asDiagonal())).norm(), 1e-6);
  EXPECT_GT(fit.cost, data.NegativeLogEvidence() + 0.1);
}

// In the axes of the posterior, a diagonal L is exact and a triangle adds nothing.
TEST(FitPosterior, InTheAxesOfThePosteriorADiagonalIsEnough) {
  Observations data(2 * kLatents);
  GaussianPosterior start = Prior();
  start.rotation = FromCovariance(data.Mean(), data.Precision().inverse()).rotation;
  const VariationalFit fit = FitPosterior(data, start, Options(0));
  EXPECT_LT((fit.gaussian.Covariance() - data.Precision().inverse()).norm(), 1e-6);
  EXPECT_NEAR(fit.cost, data.NegativeLogEvidence(), 1e-6);
}

// Most directions are then the prior's alone, with equal singular values of the Jacobian: the
// singular value decomposition behind Ceres's DENSE_SVD is wrong or crashes on some such.
TEST(FitPosterior, TheModeOfMoreNumbersThanDataHasTheLaplaceCovariance) {
  for (const int latents : {17, 39, 51, 78, 120}) {
    Observations data(1, 0.0, latents);
    VariationalOptions options = Options(0);
    options.kind = SampleKind::kMode;
    const VariationalFit fit = FitPosterior(data, Prior(latents), options);
    EXPECT_LT((fit.gaussian.mean - data.Mean()).norm(), 1e-6) << latents;
    EXPECT_LT((fit.gaussian.Covariance() - data.Precision().inverse()).norm(), 1e-9) << latents;
  }
}

TEST(FitPosterior, TheModeHasTheLaplaceCovariance) {
  Observations data(1);
  VariationalOptions options = Options(0);
  options.kind = SampleKind::kMode;
  const VariationalFit fit = FitPosterior(data, Prior(), options);
  EXPECT_LT((fit.gaussian.mean - data.Mean()).norm(), 1e-6);
  EXPECT_LT((fit.gaussian.Covariance() - data.Precision().inverse()).norm(), 1e-8);
}

// −ELBO at a point by its definition: the draws' mean of ½‖r‖², and the divergence in closed form.
TEST(FitPosterior, TheCostIsTheNegativeBound) {
  constexpr int kDraws = 8;
  Observations data(kDraws, 0.3);
  GaussianPosterior start = Prior();
  std::mt19937_64 random(2);
  start.mean = 0.3 * test::RandomMatrix(kLatents, 1, random);
  for (int i = 0; i < kLatents; ++i)
    for (int j = 0; j <= i; ++j) start.factor(i, j) = i == j ? 0.5 + 0.1 * i : 0.05 * (i - j);
  VariationalOptions options = Options(kLatents);
  options.trust_region.max_iterations = 0;
  const VariationalFit fit = FitPosterior(data, start, options);
  const Eigen::MatrixXd points = start.Draws(BalancedSamples(kLatents, kDraws, options.seed));
  data.Prepare(points, false);
  double expected = start.DivergenceFromPrior();
  for (int s = 0; s < kDraws; ++s) {
    Eigen::VectorXd r;
    ASSERT_TRUE(data.Residuals(s, &r, nullptr));
    expected += 0.5 * r.squaredNorm() / kDraws;
  }
  EXPECT_NEAR(fit.initial_cost, expected, 1e-12 * expected);
}

// At the optimum of a nonlinear problem no number lowers the cost: the gradient is that of the
// cost.
TEST(FitPosterior, TheOptimumOfANonlinearProblemIsStationary) {
  constexpr int kDraws = 12;
  Observations data(kDraws, 0.2);
  VariationalOptions options = Options(3);
  const VariationalFit best = FitPosterior(data, Prior(), options);
  options.trust_region.max_iterations = 0;
  const auto cost = [&](const GaussianPosterior& q) {
    return FitPosterior(data, q, options).initial_cost;
  };
  constexpr double kStep = 1e-4;
  const auto slope = [&](const auto& change) {
    GaussianPosterior up = best.gaussian, down = best.gaussian;
    change(up, kStep);
    change(down, -kStep);
    return (cost(up) - cost(down)) / (2 * kStep);
  };
  for (int i = 0; i < kLatents; ++i) {
    EXPECT_LT(std::abs(slope([&](auto& q, double h) { q.mean[i] += h; })), 1e-6) << i;
    EXPECT_LT(std::abs(slope([&](auto& q, double h) { q.factor(i, i) *= std::exp(h); })), 1e-6);
  }
  EXPECT_LT(std::abs(slope([&](auto& q, double h) { q.factor(2, 1) += h; })), 1e-6);
}

// One noise for each element: u = (mean, deviations).
TEST(FitPosterior, ElementwiseDrawsGetMeansAndDeviations) {
  class Elements final : public SampledResiduals {
   public:
    int num_latents() const override { return 2; }
    int num_residuals() const override { return 2; }
    int num_draws() const override { return 4; }
    void Prepare(const Eigen::MatrixXd& points, bool) override { u_ = points; }
    bool Residuals(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const override {
      residual->resize(2);
      *residual << 10 * (u_(0, draw) - 0.4), 10 * (u_(1, draw) - 0.2);
      if (jacobian != nullptr) *jacobian = 10 * RowMatrix::Identity(2, 2);
      return true;
    }

   private:
    Eigen::MatrixXd u_;
  } data;
  GaussianPosterior start{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1),
                          Eigen::MatrixXd::Identity(1, 1)};
  VariationalOptions options = Options(0);
  options.kind = SampleKind::kElementwise;
  const VariationalFit fit = FitPosterior(data, start, options);
  EXPECT_NEAR(fit.gaussian.mean[0], 0.4 * 100 / 101, 1e-6);
  // 100·(s − 0.2) + s − 1/s = 0.
  const double s = fit.gaussian.factor(0, 0);
  EXPECT_NEAR(100 * (s - 0.2) + s - 1 / s, 0.0, 1e-4);
}

// E elements η = m + s·ε with noise of their own and r = A·η − b. By the bound of posterior_fit.h,
//   −ln p(b | m, s) ≤ ½‖A1·m − b‖² + ½ s²‖A‖², so that
// m = (A1)ᵀb / (‖A1‖² + 1) and s² = 1 / (‖A‖² + 1): the prior of s counts once, not once for each
// element.
class ConjugateElements final : public SampledResiduals {
 public:
  static constexpr int kElements = 5, kDraws = 2 * kElements;  // BalancedSamples are exact
  ConjugateElements() : noise_(BalancedSamples(kElements, kDraws, 3)) {
    std::mt19937_64 random(11);
    a = test::RandomMatrix(kResiduals, kElements, random);
    b = test::RandomMatrix(kResiduals, 1, random);
  }
  int num_latents() const override { return 2; }
  int num_residuals() const override { return kResiduals; }
  int num_draws() const override { return kDraws; }
  void Prepare(const Eigen::MatrixXd& points, bool) override { u_ = points; }
  bool Residuals(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const override {
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kElements);
    *residual = a * (u_(0, draw) * ones + u_(1, draw) * noise_.col(draw)) - b;
    if (jacobian == nullptr) return true;
    jacobian->resize(kResiduals, 2);
    *jacobian << a * ones, a * noise_.col(draw);
    return true;
  }
  Eigen::VectorXd Sum() const { return a.rowwise().sum(); }
  // −ln ∫ exp(−½‖A·η − b‖²) N(η; m, s²) dη.
  double NegativeLogEvidence(double m, double s) const {
    const Eigen::MatrixXd spread =
        Eigen::MatrixXd::Identity(kResiduals, kResiduals) + s * s * a * a.transpose();
    const Eigen::VectorXd r = m * Sum() - b;
    return 0.5 * r.dot(spread.ldlt().solve(r)) + 0.5 * std::log(spread.determinant());
  }

  Eigen::MatrixXd a;
  Eigen::VectorXd b;

 private:
  Eigen::MatrixXd noise_, u_;
};

TEST(FitPosterior, ElementwiseDrawsFindTheBestBoundOfAConjugateProblem) {
  ConjugateElements data;
  const GaussianPosterior start{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1),
                                Eigen::MatrixXd::Identity(1, 1)};
  VariationalOptions options = Options(0);
  options.kind = SampleKind::kElementwise;
  const VariationalFit fit = FitPosterior(data, start, options);
  const double m = fit.gaussian.mean[0], s = fit.gaussian.factor(0, 0);
  EXPECT_NEAR(m, data.Sum().dot(data.b) / (data.Sum().squaredNorm() + 1), 1e-6);
  EXPECT_NEAR(s * s, 1 / (data.a.squaredNorm() + 1), 1e-6);
  const double prior = 0.5 * m * m + 0.5 * (s * s - 1 - std::log(s * s));
  EXPECT_NEAR(fit.divergence, prior, 1e-12);
  EXPECT_NEAR(
      fit.cost,
      0.5 * (data.Sum() * m - data.b).squaredNorm() + 0.5 * s * s * data.a.squaredNorm() + prior,
      1e-9);
  EXPECT_GE(fit.cost, data.NegativeLogEvidence(m, s) + prior);
}

TEST(SignedRoot, SquaresToTheDivergenceAndIsSmooth) {
  for (const double rho : {-3.0, -0.5, -2e-4, -9e-5, 0.0, 9e-5, 1e-3, 0.5, 2.0}) {
    double slope = 0.0;
    const double root = SignedRoot(rho, &slope);
    const double t = std::exp(2 * rho);
    EXPECT_NEAR(root * root, t - 1 - std::log(t), 1e-9 * (1 + t)) << rho;
    EXPECT_EQ(root > 0, rho > 0);
    constexpr double kStep = 1e-5;
    EXPECT_NEAR(slope, (SignedRoot(rho + kStep) - SignedRoot(rho - kStep)) / (2 * kStep), 1e-6)
        << rho;
  }
}

// Samples of the hierarchy against the fits of one material that they are made of.

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
  ResidualOptions options_ = test::CloseOutlineOptions();
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
