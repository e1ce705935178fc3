// SPDX-License-Identifier: Apache-2.0
// Twin experiments: cloth of known tables is draped from a random start, seen as a 256×256 image,
// and fitted from the tables of another fabric. The density is given: a laboratory weighs it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <span>

#include "physics/material/material_io.h"
#include "physics/util/math/random.h"
#include "solver/fit/fit.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kVertices = 600, kCoarseVertices = 200;
constexpr uint64_t kImageSeed = 1, kOtherSeeds[] = {11, 12, 13};

MaterialField Fabric(const std::string& name) {
  return ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + name + ".json").field;
}

Eigen::VectorXd LogEntries(const MaterialField& field) {
  Eigen::VectorXd entries(kMaterialEntries);
  entries << Eigen::Map<const Eigen::VectorXd>(&field.stretch[0].c[0][0], kStretchEntries),
      Eigen::Map<const Eigen::VectorXd>(&field.bend[0].b[0][0], kBendEntries);
  return entries.array().log();
}

MaterialField DrawnFromPrior(MaterialField field, double sigma, uint64_t seed) {
  std::mt19937_64 random(seed);
  for (double& entry : std::span(&field.stretch[0].c[0][0], kStretchEntries))
    entry *= std::exp(sigma * SampleNormal(random));
  for (double& entry : std::span(&field.bend[0].b[0][0], kBendEntries))
    entry *= std::exp(sigma * SampleNormal(random));
  return field;
}

class TwinTest : public testing::Test {
 protected:
  TwinTest() {
    options_.grid.stretch = {1.0, 2.0, 4.0};
    options_.grid.bend = {0.25, 0.5, 1.0, 2.0, 4.0, 8.0};
    options_.grid.lifts = {0.3, 0.6, 1.0};
    options_.candidates_per_round = {4, 2, 1};
    options_.prior_sigma = 0.3;
    problem_.fine = fine_.get();
    problem_.coarse = coarse_.get();
    problem_.material = Fabric("synthetic_wool");
  }
  void FitTo(const MaterialField& reference) {
    reference_ = reference;
    problem_.material.density = reference.density;
    const State drape =
        test::Settled(*fine_, reference, test::RandomStart(fine_->model(), kImageSeed));
    problem_.observations = {test::MakeObservation(fine_->model().mesh, drape, 90, "reference")};
    const StagedFitState state = RunStagedFit(problem_, options_, {}, {});
    ASSERT_NE(Best(state), nullptr);
    best_ = *Best(state);
    fitted_ = FittedMaterial(options_, best_);
    std::printf("%.3f px, stretch %g, bend %g, %d rollouts\n", best_.profile_rms,
                best_.guess.stretch, best_.guess.bend, state.counts.rollouts);
  }
  double DrapeCoefficient(const MaterialField& material, uint64_t seed) {
    const State drape = test::Settled(*fine_, material, test::RandomStart(fine_->model(), seed));
    return test::ComputeDrapeCoefficient(fine_->model().mesh, drape.x);
  }
  // Drape coefficients from starts that the fit has not seen; returns the difference of the means.
  double CompareUnseen(double tolerance_of_each) {
    double mean = 0.0;
    for (const uint64_t seed : kOtherSeeds) {
      const double reference = DrapeCoefficient(reference_, seed),
                   fit = DrapeCoefficient(fitted_, seed);
      std::printf("seed %d: drape coefficient %.4f, fitted %.4f\n", int(seed), reference, fit);
      EXPECT_NEAR(fit, reference, tolerance_of_each) << seed;
      mean += (fit - reference) / std::size(kOtherSeeds);
    }
    std::printf("mean difference %+.4f\n", mean);
    return mean;
  }

  const std::unique_ptr<Backend> fine_ = test::SmoothDisc(kVertices),
                                 coarse_ = test::SmoothDisc(kCoarseVertices);
  FitProblem problem_;
  StagedFitOptions options_;
  MaterialField reference_, fitted_;
  FitCandidate best_;
};

// A stiff cloth whose few branches are found from the outline, its tables drawn from the prior.
// Directions that the data alone determine to 0.1 in log units are recovered within 0.15: the
// valley of equal drapes is curved, so they are off by more than the 0.02 that its tangent promises
// (worst measured: 0.11 here, 0.17 from three other start shapes).
TEST_F(TwinTest, RecoversAStiffFabric) {
  FitTo(DrawnFromPrior(Scaled(Fabric("synthetic_wool"), 2.0, 8.0), options_.prior_sigma, 4));
  EXPECT_LT(best_.profile_rms, 0.2);
  EXPECT_LT(std::fabs(CompareUnseen(0.02)), 0.01);
  const Spectrum spectrum =
      ComputeSpectrum(FitJacobian(problem_, options_, best_), options_.prior_sigma);
  const Eigen::VectorXd error =
      spectrum.directions.transpose() * (LogEntries(fitted_) - LogEntries(reference_));
  int determined = 0;
  for (; determined < kMaterialEntries && spectrum.values[determined] > 10.0; ++determined) {
    std::printf("determined to %.3f, error %+.4f\n", 1.0 / spectrum.values[determined],
                error[determined]);
    EXPECT_LT(std::fabs(error[determined]), 0.15) << determined;
  }
  EXPECT_GE(determined, 2);
}

// The shirt itself, a soft cloth with 9 folds, has more branches than the seeds find: even with its
// true tables no seed comes nearer than 3 px to this outline. With the residual's σ at that
// size the fit stays near the reference; with 0.5 px it bends the tables until the wrong branch
// fits.
TEST_F(TwinTest, ASoftFabricIsFoundAsFarAsItsBranchAllows) {
  options_.residuals.sigma_px = 3.0;
  FitTo(Fabric("synthetic_shirt"));
  EXPECT_LT(best_.profile_rms, 5.0);
  EXPECT_LT(std::fabs(CompareUnseen(0.06)), 0.04);
}

}  // namespace
}  // namespace drape
