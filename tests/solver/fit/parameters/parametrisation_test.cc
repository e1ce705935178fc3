// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parametrisation.h"

#include <gmock/gmock.h>

#include <set>

#include "physics/util/errors.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

Eigen::VectorXd Entries(const MaterialField& field, int face, int hinge) {
  Eigen::VectorXd entries(kMaterialEntries);
  entries << Eigen::Map<const Eigen::VectorXd>(&field.stretch_of(face).c[0][0], kStretchEntries),
      Eigen::Map<const Eigen::VectorXd>(&field.bend_of(hinge).b[0][0], kBendEntries);
  return entries;
}

Eigen::VectorXd SomeTheta(int size) {
  std::mt19937_64 random(5);
  return 0.7 * test::RandomMatrix(size, 1, random);
}

bool IsC12(int entry) { return entry < kStretchEntries && entry % kStretchCols == 1; }

struct TableCase {
  std::string text;
  int size;
};
class ParametrisationTest : public testing::TestWithParam<TableCase> {
 protected:
  const MaterialField base_ = test::TestMaterial();
  const TableParametrisation parametrisation_{base_,
                                              ParseName<ParameterTying>(GetParam().text, "")};
  const Eigen::MatrixXd& tie_ = parametrisation_.tie();
};
INSTANTIATE_TEST_SUITE_P(Tyings, ParametrisationTest,
                         testing::Values(TableCase{"1", 1}, TableCase{"3", 3}, TableCase{"2", 2},
                                         TableCase{"7", 7}, TableCase{"39", 39}),
                         [](const auto& info) { return "Free" + info.param.text; });

TEST_P(ParametrisationTest, EachFreeEntryFollowsExactlyOneParameter) {
  ASSERT_EQ(parametrisation_.size(), GetParam().size);
  ASSERT_EQ(tie_.rows(), kMaterialEntries);
  const int fixed =
      FreesStretch(ParseName<ParameterTying>(GetParam().text, "")) ? 0 : kStretchEntries;
  EXPECT_EQ(tie_.rowwise().sum().head(fixed), Eigen::VectorXd::Zero(fixed));
  EXPECT_EQ(tie_.rowwise().sum().tail(kMaterialEntries - fixed),
            Eigen::VectorXd::Ones(kMaterialEntries - fixed));
  EXPECT_EQ((tie_.array() != 0.0).count(), kMaterialEntries - fixed);
  EXPECT_GE(tie_.colwise().sum().minCoeff(), 1.0);
}

TEST_P(ParametrisationTest, NamesAreDistinct) {
  std::set<std::string> names;
  for (int i = 0; i < parametrisation_.size(); ++i)
    names.insert(NameFor(ParseName<ParameterTying>(GetParam().text, ""), i));
  EXPECT_EQ(names.size(), GetParam().size);
}

TEST_P(ParametrisationTest, MaterialIsBaseTimesExpOfTheta) {
  const Eigen::VectorXd theta = SomeTheta(parametrisation_.size());
  const MaterialField material = parametrisation_.Material(theta);
  const Eigen::VectorXd eta = tie_ * theta;
  const Eigen::VectorXd factor = eta.array().exp();
  const StretchTable stretch = ApplyLogFactors(base_.stretch[0], eta.data());
  const Eigen::VectorXd entries = Entries(material, 0, 0), base = Entries(base_, 0, 0);
  for (int k = 0; k < kMaterialEntries; ++k)
    EXPECT_NEAR(entries[k] / (IsC12(k) ? stretch.entries()[k] : base[k] * factor[k]), 1.0, 1e-14);
  EXPECT_EQ(material.density, base_.density);
  EXPECT_EQ(Entries(parametrisation_.Material(0 * theta), 0, 0), Entries(base_, 0, 0));
}

TEST_P(ParametrisationTest, EveryTableResistsAllStrains) {
  for (const double size : {1.0, 5.0, 25.0})
    EXPECT_TRUE(test::ResistsAllStrains(
        parametrisation_.Material(size * SomeTheta(parametrisation_.size()))));
}

// ∂entry/∂θ = entry · ∂(log entry)/∂θ, central differences of step h are exact to h²/6 relative.
TEST_P(ParametrisationTest, ChainRuleAgreesWithDifferences) {
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd theta = SomeTheta(parametrisation_.size());
  const MaterialField material = parametrisation_.Material(theta);
  const Eigen::VectorXd entries = Entries(material, 0, 0);
  const Eigen::MatrixXd logs_by_theta = parametrisation_.LogEntriesByTheta(theta);
  for (int j = 0; j < parametrisation_.size(); ++j) {
    Eigen::VectorXd plus = theta, minus = theta;
    plus[j] += kStep;
    minus[j] -= kStep;
    const Eigen::VectorXd difference = (Entries(parametrisation_.Material(plus), 0, 0) -
                                        Entries(parametrisation_.Material(minus), 0, 0)) /
                                       (2 * kStep);
    const Eigen::ArrayXd error = difference - entries.cwiseProduct(logs_by_theta.col(j));
    EXPECT_LT((error / entries.array()).abs().maxCoeff(), 1e-9)
        << NameFor(ParseName<ParameterTying>(GetParam().text, ""), j);
    const Eigen::VectorXd direction = Eigen::VectorXd::Unit(parametrisation_.size(), j);
    EXPECT_LT((Entries(parametrisation_.Jvp(material, direction), 0, 0) -
               entries.cwiseProduct(logs_by_theta.col(j)))
                  .cwiseQuotient(entries)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-14);
  }
}

// L = Σ gradient · entry over all elements, also where they have tables of their own.
TEST_P(ParametrisationTest, VjpIsTheTransposeOfJvp) {
  std::mt19937_64 random(9);
  const auto model = test::SmallDisc("smooth");
  for (const MaterialField& base : {base_, test::Scatter(base_, model->mesh, 0.2, random)}) {
    const TableParametrisation parametrisation(base,
                                               ParseName<ParameterTying>(GetParam().text, ""));
    const Eigen::VectorXd theta = SomeTheta(parametrisation.size());
    const MaterialField material = parametrisation.Material(theta);
    MaterialGradient gradient = MaterialGradient::Zero(base, 2);
    gradient.stretch = test::RandomMatrix(int(gradient.stretch.rows()), 2, random);
    gradient.bend = 1e6 * test::RandomMatrix(int(gradient.bend.rows()), 2, random);
    const RowMatrix by_theta = parametrisation.Vjp(material, gradient);
    for (int j = 0; j < parametrisation.size(); ++j) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(parametrisation.size(), j);
      const Eigen::RowVectorXd change =
          gradient.Contract(parametrisation.Jvp(material, unit)).colwise().sum();
      EXPECT_LT((by_theta.row(j) - change).norm(), 1e-11 * (1 + change.norm())) << j;
    }
  }
}

TEST_P(ParametrisationTest, FieldsKeepTheirTableForEachElement) {
  std::mt19937_64 random(9);
  const auto model = test::SmallDisc("smooth");
  const MaterialField scattered = test::Scatter(base_, model->mesh, 0.2, random);
  const TableParametrisation parametrisation(scattered,
                                             ParseName<ParameterTying>(GetParam().text, ""));
  const Eigen::VectorXd theta = SomeTheta(parametrisation.size());
  const MaterialField material = parametrisation.Material(theta);
  ASSERT_EQ(material.stretch.size(), scattered.stretch.size());
  const Eigen::ArrayXd factor = (tie_ * theta).array().exp();
  const Eigen::ArrayXd ratio = Entries(material, 7, 11).array() / Entries(scattered, 7, 11).array();
  for (int k = 0; k < kMaterialEntries; ++k) {
    if (IsC12(k)) continue;
    EXPECT_NEAR(ratio[k] / factor[k], 1.0, 1e-14) << k;
  }
  EXPECT_TRUE(test::ResistsAllStrains(material));
}

TEST(ParametrisationNames, SayWhatIsFree) {
  const MaterialField base = test::TestMaterial();
  EXPECT_EQ(NameFor(ParameterTying::kScales, 0), "stretch");
  EXPECT_EQ(NameFor(ParameterTying::kScales, 1), "bend");
  EXPECT_EQ(NameFor(ParameterTying::kColumns, 3), "c33");
  EXPECT_EQ(NameFor(ParameterTying::kColumns, 6), "bend[2]");
  EXPECT_EQ(NameFor(ParameterTying::kEntries, 23), "c33[5]");
  EXPECT_EQ(NameFor(ParameterTying::kEntries, 38), "bend[2][4]");
}

TEST(ParameterTying, RefusesOtherNumbers) {
  for (const std::string text : {"", "4", "2.0", " 2", "all"}) {
    try {
      ParseName<ParameterTying>(text, "");
      ADD_FAILURE() << "accepted '" << text << "'";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(),
                  testing::HasSubstr("'" + text + "', expected one of 1, 2, 3, 7, 39"));
    }
  }
}

}  // namespace
}  // namespace drape
