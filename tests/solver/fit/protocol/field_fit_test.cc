// SPDX-License-Identifier: Apache-2.0
// HETER on a cloth whose field is known.
#include "solver/fit/protocol/field_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/statics.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// Correlation over the elements where the posterior is below `known` of the prior.
double Correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& ratio,
                   double known) {
  std::vector<double> x, y;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (ratio[i] > known) continue;
    x.push_back(a[i]);
    y.push_back(b[i]);
  }
  const Eigen::Map<Eigen::ArrayXd> p(x.data(), x.size()), q(y.data(), y.size());
  const Eigen::ArrayXd dp = p - p.mean(), dq = q - q.mean();
  return (dp * dq).sum() / std::sqrt(dp.square().sum() * dq.square().sum());
}

class FieldTwinTest : public testing::Test {
 protected:
  FieldTwinTest() {
    fields_.basis = FieldBasis::kModes;
    fields_.groups = FieldGroups::kBend;
    fields_.modes = 40;
    fields_.length = 0.04;
    fields_.sigma = 0.5;
    fields_.iterations = 40;
    fields_.restarts = 2;
    const Mesh& mesh = backend_->model().mesh;
    const FieldParametrisation fields(base_, mesh.num_faces(), mesh.num_hinges(),
                                      MakeFieldTerms(mesh, fields_));
    std::mt19937_64 random(31);
    const Eigen::VectorXd theta = 0.7 * test::RandomMatrix(fields.size(), 1, random);
    reference_ = fields.LogFactors(ElementKind::kHinges, theta).col(0);
    const MaterialField material = fields.Material(theta);
    candidate_.theta = Eigen::VectorXd::Zero(kMaterialEntries);
    problem_.fine = backend_.get();
    problem_.material = candidate_.base = base_;
    for (const uint64_t seed : {1, 2, 3}) AddDrape(material, seed);
  }
  // The image of a drape of the reference; the candidate starts from the drape of one table beside
  // it.
  void AddDrape(const MaterialField& reference, uint64_t seed) {
    State drape =
        test::Settled(*backend_, reference, test::RandomStart(backend_->model(), seed), 60);
    problem_.observations.push_back(
        test::MakeObservation(backend_->model().mesh, drape, 72, std::to_string(seed)));
    const RolloutInput input{&base_, &drape};
    const EquilibriumResult rest = backend_->Equilibria({&input, 1}, {}).front();
    ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
    candidate_.shapes.push_back(rest.x);
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(300);
  const MaterialField base_ = Scaled(test::TestMaterial(), 1.0, 4.0);
  FieldOptions fields_;
  StagedFitOptions staged_;
  FitProblem problem_;
  FitCandidate candidate_;
  Eigen::VectorXd reference_;  // log factor of each hinge
};

TEST_F(FieldTwinTest, FindsTheFieldWhereTheDataDetermineIt) {
  constexpr double kKnown = 0.7;
  const FieldFit fit = FitFields(problem_, staged_, fields_, candidate_, {});
  ASSERT_TRUE(fit.valid());
  const Mesh& mesh = backend_->model().mesh;
  Eigen::VectorXd fitted(mesh.num_hinges());
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    fitted[e] = 0.0;
    for (int k = 0; k < kBendEntries; ++k)
      fitted[e] +=
          std::log(fit.material.bend[e].entries()[k] / base_.bend[0].entries()[k]) / kBendEntries;
  }
  const Eigen::VectorXd ratio = fit.posterior_hinge.cwiseQuotient(fit.prior_hinge);
  const double correlation = Correlation(reference_, fitted, ratio, kKnown);
  std::printf(
      "cost %.1f -> %.1f, %d directions, known at %.0f %% of the hinges: correlation %.3f, "
      "everywhere %.3f\n",
      fit.summary.initial_cost, fit.summary.final_cost, fit.determined,
      100.0 * (ratio.array() < kKnown).count() / double(ratio.size()), correlation,
      Correlation(reference_, fitted, ratio, 2.0));
  EXPECT_LT(fit.summary.final_cost, 0.1 * fit.summary.initial_cost);
  EXPECT_GT((ratio.array() < kKnown).count(), ratio.size() / 10);
  EXPECT_GT(correlation, 0.7);
  EXPECT_LE(ratio.maxCoeff(), 1.0 + 1e-9);
}

// The drapes are equilibria of the material that is returned.
TEST_F(FieldTwinTest, DrapesBelongToTheFields) {
  fields_.iterations = 12;
  fields_.restarts = 0;
  const FieldFit fit = FitFields(problem_, staged_, fields_, candidate_, {});
  ASSERT_TRUE(fit.valid());
  EXPECT_LT(fit.summary.final_cost, fit.summary.initial_cost);
  for (const Eigen::VectorXd& x : fit.shapes)
    EXPECT_LT(ForceResidual(backend_->model(), fit.material, x), 1e-8);
}

}  // namespace
}  // namespace drape
