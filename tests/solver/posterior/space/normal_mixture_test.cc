// SPDX-License-Identifier: Apache-2.0
// Distances of normal distributions against closed forms and Monte Carlo [METHODS, P60].
#include "solver/posterior/space/normal_mixture.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "physics/material/material_io.h"
#include "physics/util/math/random.h"
#include "solver/posterior/variational_fit.h"

namespace drape::test {
namespace {

NormalDistribution OneNumber(double mean, double sd) {
  return {Eigen::VectorXd::Constant(1, mean), Eigen::MatrixXd::Constant(1, 1, sd * sd)};
}

NormalDistribution RandomNormal(int size, int seed) {
  const Eigen::MatrixXd numbers = IndependentSamples(size, size + 1, seed);
  const Eigen::MatrixXd root = numbers.leftCols(size);
  return {numbers.col(size), root * root.transpose() + Eigen::MatrixXd::Identity(size, size)};
}

// By samples of p: mean and standard error of f.
template <class F>
std::pair<double, double> Sample(const NormalDistribution& p, const F& f) {
  constexpr int kSamples = 40000;
  const Eigen::MatrixXd root = p.covariance.llt().matrixL();
  const Eigen::MatrixXd standard = IndependentSamples(p.size(), kSamples, 5);
  Eigen::ArrayXd values(kSamples);
  for (int i = 0; i < kSamples; ++i) values[i] = f(p.mean + root * standard.col(i));
  const double mean = values.mean();
  return {mean, std::sqrt((values - mean).square().mean() / kSamples)};
}

TEST(NormalDistance, IsThatOfTheTextbookForOneNumber) {
  const NormalDistribution p = OneNumber(1.0, 2.0), q = OneNumber(-0.5, 3.0);
  EXPECT_NEAR(KullbackLeibler(p, q), std::log(1.5) + (4 + 2.25) / 18 - 0.5, 1e-14);
  const double overlap = std::sqrt(2 * 2.0 * 3.0 / 13.0) * std::exp(-0.25 * 2.25 / 13.0);
  EXPECT_NEAR(Bhattacharyya(p, q), -std::log(overlap), 1e-14);
  EXPECT_NEAR(Hellinger(p, q), std::sqrt(1 - overlap), 1e-14);
  EXPECT_NEAR(Wasserstein(p, q), std::hypot(1.5, 1.0), 1e-14);
  EXPECT_NEAR(LogDensity(p, Eigen::VectorXd::Constant(1, 3.0)),
              -0.5 - std::log(2 * std::sqrt(2 * std::numbers::pi)), 1e-14);
}

TEST(NormalDistance, AgreesWithMonteCarlo) {
  const NormalDistribution p = RandomNormal(4, 1), q = RandomNormal(4, 2);
  const auto [divergence, error] =
      Sample(p, [&](const Eigen::VectorXd& x) { return LogDensity(p, x) - LogDensity(q, x); });
  EXPECT_NEAR(KullbackLeibler(p, q), divergence, 4 * error);
  EXPECT_LT(error, 0.02 * divergence);
  const auto [overlap, overlap_error] = Sample(p, [&](const Eigen::VectorXd& x) {
    return std::exp(0.5 * (LogDensity(q, x) - LogDensity(p, x)));
  });
  EXPECT_NEAR(std::exp(-Bhattacharyya(p, q)), overlap, 4 * overlap_error);
}

// All but Wasserstein's are invariant under an affine map; that one under a rotation.
TEST(NormalDistance, DoesNotDependOnTheCoordinates) {
  const NormalDistribution p = RandomNormal(3, 3), q = RandomNormal(3, 4);
  const Eigen::MatrixXd map = IndependentSamples(3, 3, 6);
  const auto moved = [](const Eigen::MatrixXd& a, NormalDistribution n) {
    return NormalDistribution{a * n.mean + Eigen::Vector3d(1, 2, 3),
                              a * n.covariance * a.transpose()};
  };
  EXPECT_NEAR(KullbackLeibler(moved(map, p), moved(map, q)), KullbackLeibler(p, q), 1e-9);
  EXPECT_NEAR(Hellinger(moved(map, p), moved(map, q)), Hellinger(p, q), 1e-10);
  const Eigen::MatrixXd turn = Eigen::Quaterniond(1, 2, 3, 4).normalized().toRotationMatrix();
  EXPECT_NEAR(Wasserstein(moved(turn, p), moved(turn, q)), Wasserstein(p, q), 1e-12);
  EXPECT_NEAR(Wasserstein(p, p), 0.0, 1e-6);
}

TEST(NormalDistance, FindsWhatTheDataDetermine) {
  Eigen::MatrixXd covariance = Eigen::Vector4d(0.9, 0.04, 0.2, 1.0).asDiagonal();
  const Eigen::MatrixXd turn = RandomNormal(4, 7).covariance.householderQr().householderQ();
  covariance = (turn * covariance * turn.transpose()).eval();
  const DeterminedDirections two = FindDetermined(covariance, 4);
  ASSERT_EQ(two.ratios.size(), 2);
  EXPECT_NEAR(two.ratios[0], 0.04, 1e-12);
  EXPECT_NEAR(std::abs(two.axes.col(0).dot(turn.col(1))), 1.0, 1e-12);
  EXPECT_EQ(FindDetermined(covariance, 1).ratios.size(), 1);
}

// Bayes' rule with the likelihood that is found gives the posterior again.
TEST(NormalDistance, TakesThePriorOut) {
  const NormalDistribution seen = RandomNormal(3, 8);
  const Eigen::Vector3d centre(0.3, -1, 2);
  const Eigen::MatrixXd precision = seen.covariance.inverse() + Eigen::MatrixXd::Identity(3, 3);
  NormalDistribution posterior{Eigen::VectorXd(), precision.inverse()};
  posterior.mean = posterior.covariance * (seen.covariance.inverse() * seen.mean + centre);
  const NormalDistribution found = WithoutPrior(posterior, centre);
  EXPECT_LT((found.mean - seen.mean).norm(), 1e-10);
  EXPECT_LT((found.covariance - seen.covariance).norm(), 1e-10);
  // Nothing was seen: as uncertain as can be said.
  const NormalDistribution none = WithoutPrior({centre, Eigen::MatrixXd::Identity(3, 3)}, centre);
  EXPECT_NEAR(none.covariance(0, 0), kMostNoise, 1e-6 * kMostNoise);
}

// The mixture behind noisy observations [Bovy 2011].

// Two populations in a plane, seen with noise that differs from one observation to another and is
// as large as their scatter.
std::vector<NormalDistribution> Planted(int count, double distance) {
  const Eigen::MatrixXd standard = IndependentSamples(4, count, 11);
  std::vector<NormalDistribution> seen;
  for (int i = 0; i < count; ++i) {
    const bool first = i % 3 != 0;
    Eigen::Vector2d x = first ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(distance, 1);
    x += Eigen::Vector2d(0.5, first ? 1.0 : 0.3).cwiseProduct(standard.col(i).head<2>());
    const Eigen::Vector2d noise(0.4 + 0.5 * (i % 2), 0.3 + 0.2 * (i % 5));
    x += noise.cwiseProduct(standard.col(i).tail<2>());
    seen.push_back({x, noise.cwiseAbs2().asDiagonal()});
  }
  return seen;
}

TEST(Deconvolution, RecoversAPlantedMixture) {
  const NormalMixture found = Deconvolve(Planted(1500, 4.0), 2);
  ASSERT_EQ(found.size(), 2);
  const int first = found.components[0].mean.x() < found.components[1].mean.x() ? 0 : 1;
  EXPECT_NEAR(found.weights[first], 2.0 / 3, 0.04);
  const NormalDistribution &a = found.components[first], &b = found.components[1 - first];
  EXPECT_LT((a.mean - Eigen::Vector2d(0, 0)).norm(), 0.15);
  EXPECT_LT((b.mean - Eigen::Vector2d(4, 1)).norm(), 0.15);
  // Without the noise, whose variance is up to 0.81 and 1.21.
  EXPECT_NEAR(std::sqrt(a.covariance(0, 0)), 0.5, 0.1);
  EXPECT_NEAR(std::sqrt(a.covariance(1, 1)), 1.0, 0.1);
  EXPECT_NEAR(std::sqrt(b.covariance(1, 1)), 0.3, 0.15);
}

TEST(Deconvolution, ChoosesTheNumberOfComponents) {
  EXPECT_EQ(ChooseComponents(Planted(45, 8.0), 3).components, 2);
  std::vector<NormalDistribution> alike;
  for (const NormalDistribution& x : Planted(300, 1e3))
    if (x.mean.x() < 500 && alike.size() < 30) alike.push_back(x);
  const ComponentChoice one = ChooseComponents(alike, 4);
  EXPECT_EQ(one.components, 1);
  EXPECT_EQ(one.left_out.size(), 30u);
  EXPECT_EQ(one.log_likelihoods.size(), 4u);
}

// Far from all components the likelihood is small, and its logarithm finite.
TEST(Deconvolution, JudgesWhatIsFarAway) {
  const NormalMixture mixture = Deconvolve(Planted(50, 4.0), 2);
  const Eigen::Matrix2d exact = 1e-12 * Eigen::Matrix2d::Identity();
  const double near = mixture.LogLikelihood({Eigen::Vector2d(0, 0), exact});
  const double far = mixture.LogLikelihood({Eigen::Vector2d(1e4, 0), exact});
  EXPECT_TRUE(std::isfinite(far));
  EXPECT_LT(far, near - 1e6);
  EXPECT_GT(mixture.LogLikelihood({Eigen::Vector2d(1e4, 0), 1e8 * exact / 1e-12}), -100);
}

// Two observations in three directions still have a population.
TEST(Deconvolution, FewObservationsAreEnough) {
  const std::vector<NormalDistribution> two = {
      {Eigen::Vector3d(0, 0, 0), 0.01 * Eigen::Matrix3d::Identity()},
      {Eigen::Vector3d(1, 0, 0), 0.01 * Eigen::Matrix3d::Identity()}};
  const NormalMixture mixture = Deconvolve(two, 1);
  EXPECT_LT((mixture.components[0].mean - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-3);
  EXPECT_GT(mixture.components[0].covariance(1, 1), 1e-3);
  EXPECT_TRUE(std::isfinite(ChooseComponents(two, 4).log_likelihoods[0]));
}

TEST(Deconvolution, MomentsAreThoseOfTheWhole) {
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(1, 1);
  const NormalMixture mixture{
      {0.25, 0.75},
      {{Eigen::VectorXd::Constant(1, 0.0), unit}, {Eigen::VectorXd::Constant(1, 4.0), unit}}};
  EXPECT_NEAR(mixture.Moments().mean[0], 3.0, 1e-14);
  EXPECT_NEAR(mixture.Moments().covariance(0, 0), 1.0 + 0.25 * 9 + 0.75 * 1, 1e-14);
}

// The published table of distances between materials [Gong 2024, table 4] follows from start values
// alone [METHODS, P63].

// Deviations of the released programs: of cotton blue, of the others, and the one that a fit's
// smallest becomes by the softplus function.
constexpr double kBlueDeviation = 1e-4, kLeastDeviation = 9.992007e-14;

StretchTable StartTable(const std::string& name) {
  return ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + name + ".json",
                      {NegativeEntries::kWarn})
      .field.stretch[0];
}

// The material `paper` of ARCSim.
StretchTable Paper() {
  StretchTable paper;
  for (auto& row : paper.c) row[0] = row[2] = row[3] = 5e5;
  return paper;
}

NormalDistribution AsNormal(const StretchTable& table, double deviation) {
  return {Eigen::Map<const Eigen::VectorXd>(table.entries(), kStretchEntries),
          deviation * deviation * Eigen::MatrixXd::Identity(kStretchEntries, kStretchEntries)};
}

double Distance(const std::string& fabric, const StretchTable& sample) {
  const double deviation = fabric == "cotton_blue" ? kBlueDeviation : kLeastDeviation;
  return KullbackLeibler(AsNormal(StartTable(fabric), deviation),
                         AsNormal(sample, kLeastDeviation));
}

// To the printed digits.
void ExpectPrinted(double computed, double printed) {
  EXPECT_NEAR(computed / printed, 1.0, 5.1e-4) << printed;
}

TEST(PublishedDistances, FollowFromStartValues) {
  // Linen green was started with the table of cotton blue.
  const StretchTable linen = StartTable("cotton_blue");
  ExpectPrinted(Distance("cotton_white", linen), 8.669e30);
  ExpectPrinted(Distance("cotton_blue", linen), 1.202e19);
  ExpectPrinted(Distance("viscose_white", linen), 9.796e30);
  ExpectPrinted(Distance("cotton_pink", linen), 7.307e30);
  ExpectPrinted(Distance("cotton_white", Paper()), 2.253e38);
  ExpectPrinted(Distance("cotton_blue", Paper()), 2.253e38);
  ExpectPrinted(Distance("viscose_white", Paper()), 2.254e38);
  ExpectPrinted(Distance("cotton_pink", Paper()), 2.252e38);
  ExpectPrinted(Distance("wool_red", Paper()), 2.253e38);
  // The tenth: the released start table of wool differs from the published one.
  EXPECT_NEAR(Distance("wool_red", linen), 7.524e29, 1e26);
}

}  // namespace
}  // namespace drape::test
