// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_io.h"

#include <gmock/gmock.h>

#include <cmath>
#include <span>
#include <string>

#include "solver/fit/effective_stiffness.h"
#include "solver/posterior/posterior_fit.h"
#include "tests/losses/temp_folder.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape::test {
namespace {

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
  }
  const PosteriorFit all = WithTables(ParameterTying::kEntries);
  EXPECT_GT(ComputePosteriorStiffness(all, EqualStiffnessWeights()).stretch_deviation, 0.0);
}

// The mean of a column whose entries are alike is known as if it were seen with a further error.
// What entries are beside their mean is known as before, and what the prior holds stays.
TEST(StoredPosterior, OtherBranchesWidenTheMeansOfColumns) {
  constexpr double kPrior = 0.3, kSeen = 0.01, kDeviation = 0.3, kHeld = 1e-12;
  StoredPosterior posterior;
  posterior.base = TestMaterial();
  posterior.prior_sd = Eigen::VectorXd::Constant(kMaterialEntries, kPrior);
  posterior.mean = Eigen::VectorXd::LinSpaced(kMaterialEntries, -1.0, 1.0);
  posterior.prior_sd.head(kStretchEntries).setConstant(kHeld);
  const double variance = kPrior * kPrior * kSeen;
  posterior.covariance = variance * Eigen::MatrixXd::Identity(kMaterialEntries, kMaterialEntries);
  posterior.covariance.topLeftCorner<kStretchEntries, kStretchEntries>().diagonal().setConstant(
      kHeld * kHeld);
  const StoredPosterior before = posterior;
  CountBranches(kDeviation, posterior);
  EXPECT_EQ(posterior.branch_deviation, kDeviation);
  EXPECT_EQ(posterior.mean, before.mean);
  const auto bend = posterior.covariance.bottomRightCorner<kBendEntries, kBendEntries>();
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kBendEntries), beside = mean;
  mean.head<kBendCols>().setConstant(1.0 / std::sqrt(kBendCols));
  beside[0] = -(beside[1] = std::sqrt(0.5));
  const double by_prior = 1.0 / (kPrior * kPrior),
               seen =
                   1.0 / (1.0 / (1.0 / variance - by_prior) + kBendCols * std::pow(kDeviation, 2));
  EXPECT_NEAR(mean.dot(bend * mean), 1.0 / (by_prior + seen), 1e-12);
  EXPECT_NEAR(beside.dot(bend * beside), variance, 1e-12);
  EXPECT_NEAR(posterior.covariance(0, 0), kHeld * kHeld, 1e-30);
  EXPECT_NEAR((posterior.covariance - before.covariance).topRows(kStretchEntries).norm(), 0.0,
              1e-28);

  // The number on all bend entries is off by the mean of three columns.
  StoredPosterior scales;
  scales.fabric = ParameterTying::kScales;
  scales.prior_sd = Eigen::Vector2d::Constant(kPrior);
  scales.mean = Eigen::Vector2d::Zero();
  scales.covariance = variance * Eigen::Matrix2d::Identity();
  CountBranches(kDeviation, scales);
  EXPECT_NEAR(1.0 / scales.covariance(1, 1),
              by_prior + 1.0 / (1.0 / (1.0 / variance - by_prior) + std::pow(kDeviation, 2) / 3.0),
              1e-9);

  const TempFolder folder;
  WritePosterior(folder.path(), posterior, "a test");
  EXPECT_EQ(ReadPosterior(folder.path()).branch_deviation, kDeviation);
}

}  // namespace
}  // namespace drape::test

namespace drape {
namespace {

class StoredSamplesTest : public FileFixture {
 protected:
  StoredSamplesTest() {
    stored_.drawn = 3;
    stored_.images = {{"front", 1e-3, Eigen::Vector3d(0.11, 0.12, 0.13)},
                      {"back", 2e-3, Eigen::Vector3d(0.1, 0.12, 0.11)}};
    stored_.samples = {{Eigen::Vector2d(0.1, -1.0 / 3), -1.5, -0.25, Eigen::MatrixXd(3, 2)},
                       {Eigen::Vector2d(0.2, 0.3), -2.5, -0.75, Eigen::MatrixXd(3, 2)}};
    stored_.samples[0].radius << 0.111, 0.1, 0.12, 0.12, 0.13, 0.115;
    stored_.samples[1].radius << 0.11, 0.1, 0.12, 0.12, 0.13, 0.11;
  }
  // What Read says of the file with one text for another.
  void ExpectRefused(const std::string& from, const std::string& to, const std::string& reason) {
    WriteSamples(Path(""), stored_);
    std::string text = Read(Path(kSamplesFile));
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    Write(kSamplesFile, text.replace(at, from.size(), to));
    EXPECT_INPUT_ERROR(ReadSamples(Path(""), 2), reason);
  }
  StoredSamples stored_;
};

TEST_F(StoredSamplesTest, AreReadAsTheyWereWritten) {
  WriteSamples(Path(""), stored_);
  const StoredSamples read = ReadSamples(Path(""), 2);
  EXPECT_EQ(read.drawn, 3);
  ASSERT_EQ(read.images.size(), 2u);
  EXPECT_EQ(read.images[1].name, "back");
  EXPECT_EQ(read.images[1].sigma, 2e-3);
  EXPECT_EQ(read.images[1].radius, stored_.images[1].radius);
  ASSERT_EQ(read.samples.size(), 2u);
  EXPECT_EQ(read.samples[0].log_factors, stored_.samples[0].log_factors);
  EXPECT_EQ(read.samples[0].radius, stored_.samples[0].radius);
  EXPECT_EQ(read.samples[1].log_prior, -2.5);
  EXPECT_EQ(read.samples[1].log_density, -0.75);
}

// A radius that is a standard deviation off has e^-½ of the density of one that is not.
TEST_F(StoredSamplesTest, LikelihoodIsNormal) {
  const Eigen::MatrixXd at_images = stored_.LogLikelihood(stored_.samples[1]);
  EXPECT_NEAR(at_images(0, 0), -std::log(1e-3 * std::sqrt(2 * M_PI)), 1e-12);
  EXPECT_NEAR(at_images(2, 1), -std::log(2e-3 * std::sqrt(2 * M_PI)), 1e-12);
  const Eigen::MatrixXd off = stored_.LogLikelihood(stored_.samples[0]) - at_images;
  EXPECT_NEAR(off(0, 0), -0.5, 1e-10);
  EXPECT_NEAR(off(2, 1), -0.5 * 2.5 * 2.5, 1e-10);
  EXPECT_NEAR(off(1, 0), 0.0, 1e-10);
}

TEST_F(StoredSamplesTest, OthersAreRefusedByName) {
  ExpectRefused("drapefit-samples", "drapefit-posterior", "samples of a posterior");
  ExpectRefused("\"version\": 1", "\"version\": 2", "version");
  ExpectRefused("\"sigma_m\":0.001", "\"sigma_m\":0", "images[0].sigma_m");
  ExpectRefused("0.11,0.12,0.13", "0.11,0.12", "images[1].radius_m");
  ExpectRefused("[0.2,0.3]", "[0.2]", "samples[1].log_factors");
  ExpectRefused("\"log_prior\":-2.5", "\"log_prior\":null", "samples[1].log_prior");
  EXPECT_INPUT_ERROR(ReadSamples(Path("none"), 2), "none");
}

}  // namespace
}  // namespace drape
