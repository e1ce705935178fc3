// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parametrisation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <set>

#include "physics/util/errors.h"
#include "solver/fit/protocol/field_fit.h"
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

// What a form lets vary of an entry comes on top of what its number does, in units of the prior.
TEST(ParametrisationForm, VariesFreeEntriesAlone) {
  const Eigen::MatrixXd with_form = TieWithForm(TyingMatrix(ParameterTying::kBendRows), 2.0);
  const Eigen::VectorXd variance = 4.0 * with_form.rowwise().squaredNorm();
  EXPECT_TRUE(variance.head(kStretchEntries).isZero());
  EXPECT_TRUE(variance.tail(kBendEntries).isConstant(4.0 + 0.25, 1e-12));
  const Eigen::MatrixXd entries = TyingMatrix(ParameterTying::kEntries);
  EXPECT_EQ(TieWithForm(entries, 2.0), entries);
}

// The Jacobian by a tie keeps the columns of the numbers that are not in the table.
TEST(ParametrisationForm, KeepsTheNumbersBesideTheTable) {
  const Eigen::MatrixXd tie = TyingMatrix(ParameterTying::kColumns),
                        by_entries = Eigen::MatrixXd::Random(4, kMaterialEntries + 2),
                        by_tie = JacobianByTie(by_entries, tie);
  ASSERT_EQ(by_tie.cols(), 9);
  EXPECT_TRUE(by_tie.leftCols(7).isApprox(by_entries.leftCols(kMaterialEntries) * tie));
  EXPECT_EQ(by_tie.rightCols(2), by_entries.rightCols(2));
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

// Stretch tables that resist all strains whatever their log factors are [METHODS, P2].

constexpr int kC11 = 0, kC12 = 1, kC22 = 2;

double Coupling(const StretchTable& table, int row) {
  return table.c[row][kC12] / std::sqrt(table.c[row][kC11] * table.c[row][kC22]);
}

// The rows have couplings from 0.02 to 0.98.
StretchTable ManyCouplings() {
  StretchTable table = test::TestMaterial().stretch[0];
  const double couplings[kStretchRows] = {0.02, 0.3, 0.6, 0.9, 0.97, 0.98};
  for (int r = 0; r < kStretchRows; ++r)
    table.c[r][kC12] = couplings[r] * std::sqrt(table.c[r][kC11] * table.c[r][kC22]);
  return table;
}

Eigen::VectorXd RandomFactors(double size, int seed) {
  std::mt19937_64 random(seed);
  return size * test::RandomMatrix(kStretchEntries, 1, random);
}

Eigen::VectorXd Logs(const StretchTable& table) {
  return Eigen::Map<const Eigen::ArrayXd>(table.entries(), kStretchEntries).abs().log();
}

TEST(CoupledTable, ResistsAllStrainsWhateverTheFactors) {
  const StretchTable base = ManyCouplings();
  for (const double size : {0.1, 1.0, 10.0, 100.0})
    for (int seed = 0; seed < 50; ++seed) {
      const StretchTable table = ApplyLogFactors(base, RandomFactors(size, seed).data());
      EXPECT_TRUE(test::ResistsAllStrains({0.2, {table}, {}})) << size << ' ' << seed;
      for (int r = 0; r < kStretchRows; ++r)
        EXPECT_LE(Coupling(table, r), kLargestCoupling * (1 + 1e-12)) << size << ' ' << seed;
    }
}

TEST(CoupledTable, LogFactorsAreFoundAgain) {
  const StretchTable base = ManyCouplings();
  for (int seed = 0; seed < 20; ++seed) {
    const Eigen::VectorXd eta = RandomFactors(2.0, seed);
    const Eigen::VectorXd found = FindLogFactors(base, ApplyLogFactors(base, eta.data()));
    EXPECT_LT((found - eta).norm(), 1e-9) << seed;
  }
  StretchTable none = base, other_sign = base;
  none.c[0][kC12] = 0.0;
  other_sign.c[0][kC12] *= -1;
  EXPECT_FALSE(FindLogFactors(base, none).allFinite());
  EXPECT_FALSE(FindLogFactors(base, other_sign).allFinite());
  EXPECT_TRUE(FindLogFactors(none, none).isZero());
}

TEST(CoupledTable, IsTheBaseAtZeroToTheBit) {
  const StretchTable base = ManyCouplings();
  const StretchTable table = ApplyLogFactors(base, Eigen::VectorXd::Zero(24).eval().data());
  for (int k = 0; k < kStretchEntries; ++k) EXPECT_EQ(table.entries()[k], base.entries()[k]) << k;
}

// The statement of the header: logit(ρ/ρmax) moves by u.
TEST(CoupledTable, MovesTheLogitOfTheCoupling) {
  const StretchTable base = ManyCouplings();
  const Eigen::VectorXd eta = RandomFactors(1.0, 3);
  const StretchTable table = ApplyLogFactors(base, eta.data());
  const auto logit = [](double coupling) {
    return std::log(coupling / (kLargestCoupling - coupling));
  };
  for (int r = 0; r < kStretchRows; ++r) {
    const double u = eta[4 * r + kC12] - 0.5 * (eta[4 * r + kC11] + eta[4 * r + kC22]);
    EXPECT_NEAR(logit(Coupling(table, r)) - logit(Coupling(base, r)), u, 1e-10) << r;
    for (const int c : {0, 2, 3})
      EXPECT_NEAR(table.c[r][c] / (base.c[r][c] * std::exp(eta[4 * r + c])), 1.0, 1e-14);
  }
}

TEST(CoupledTable, IsALogScaleWhereTheCouplingIsSmall) {
  StretchTable base = test::TestMaterial().stretch[0];
  for (auto& row : base.c) row[kC12] *= 1e-6;
  const Eigen::VectorXd eta = RandomFactors(1.0, 4);
  const Eigen::VectorXd logs = Logs(ApplyLogFactors(base, eta.data())) - Logs(base);
  EXPECT_LT((logs - eta).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(CoupledTable, EqualFactorsKeepTheCoupling) {
  const StretchTable base = ManyCouplings();
  const StretchTable table =
      ApplyLogFactors(base, Eigen::VectorXd::Constant(kStretchEntries, 1.7).eval().data());
  for (int r = 0; r < kStretchRows; ++r)
    EXPECT_NEAR(Coupling(table, r), Coupling(base, r), 1e-15) << r;
}

TEST(CoupledTable, StepsAddUp) {
  StretchTable base = ManyCouplings();
  for (auto& row : base.c) row[kC12] *= 0.8;
  const Eigen::VectorXd one = RandomFactors(0.5, 5), two = RandomFactors(0.5, 6);
  StretchTable between = ApplyLogFactors(base, one.data());
  for (int r = 0; r < kStretchRows; ++r) ASSERT_LE(Coupling(between, r), 0.98) << r;
  EXPECT_LT((Logs(ApplyLogFactors(between, two.data())) -
             Logs(ApplyLogFactors(base, (one + two).eval().data())))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// A step of h = 1e-5 leaves h²/6 of truncation and 1e-16/h of rounding.
TEST(CoupledTable, DerivativesAgreeWithDifferences) {
  const StretchTable base = ManyCouplings();
  constexpr double kStep = 1e-5;
  for (const double size : {0.0, 0.5, 3.0}) {
    const Eigen::VectorXd eta = RandomFactors(size, 7), direction = RandomFactors(1.0, 8);
    const StretchTable table = ApplyLogFactors(base, eta.data());
    Eigen::VectorXd exact = direction;
    PushLogFactors(base, table, exact.data());
    const Eigen::VectorXd plus = eta + kStep * direction, minus = eta - kStep * direction;
    const Eigen::VectorXd difference =
        (Logs(ApplyLogFactors(base, plus.data())) - Logs(ApplyLogFactors(base, minus.data()))) /
        (2 * kStep);
    EXPECT_LT((difference - exact).cwiseAbs().maxCoeff(), 1e-9) << size;
    const Eigen::VectorXd gradient = RandomFactors(1.0, 9);
    Eigen::VectorXd pulled = gradient;
    PullLogFactors(base, table, pulled.data());
    EXPECT_NEAR(pulled.dot(direction), gradient.dot(exact), 1e-12 * gradient.norm()) << size;
  }
}

// A base near the limit stays where it is and may come nearer to 1, not reach it.
TEST(CoupledTable, ABaseBeyondTheMarginHasALargerOne) {
  StretchTable base = test::TestMaterial().stretch[0];
  for (auto& row : base.c) row[kC12] = 0.996 * std::sqrt(row[kC11] * row[kC22]);
  Eigen::VectorXd eta = Eigen::VectorXd::Zero(kStretchEntries);
  EXPECT_NEAR(Coupling(ApplyLogFactors(base, eta.data()), 2), 0.996, 1e-15);
  eta[4 * 2 + kC12] = 50.0;
  EXPECT_NEAR(Coupling(ApplyLogFactors(base, eta.data()), 2), 0.998, 1e-12);
}

TEST(CoupledTable, ANegativeCouplingIsBoundedToo) {
  StretchTable base = ManyCouplings();
  for (auto& row : base.c) row[kC12] = -row[kC12];
  const StretchTable table = ApplyLogFactors(base, RandomFactors(5.0, 1).data());
  for (int r = 0; r < kStretchRows; ++r) {
    EXPECT_LT(Coupling(table, r), 0.0) << r;
    EXPECT_GE(Coupling(table, r), -kLargestCoupling * (1 + 1e-14)) << r;
  }
}

TEST(CoupledTable, RowsThatDoNotResistStayOnALogScale) {
  StretchTable base = ManyCouplings();
  base.c[0][kC12] = 2.0 * std::sqrt(base.c[0][kC11] * base.c[0][kC22]);
  base.c[1][kC22] = 0.0;
  base.c[2][kC11] = -base.c[2][kC11];
  const Eigen::VectorXd eta = RandomFactors(1.0, 2);
  const StretchTable table = ApplyLogFactors(base, eta.data());
  Eigen::VectorXd change = eta;
  PushLogFactors(base, table, change.data());
  for (int r = 0; r < 3; ++r) {
    const int k = 4 * r + kC12;
    EXPECT_NEAR(table.c[r][kC12] / base.c[r][kC12], std::exp(eta[k]), 1e-13 * std::exp(eta[k]));
    EXPECT_EQ(change[k], eta[k]);
  }
}

struct FieldCase {
  FieldBasis basis;
  FieldGroups groups;
  std::string name;
};

class FieldParametrisationTest : public testing::TestWithParam<FieldCase> {
 protected:
  FieldOptions Options() const {
    FieldOptions options;
    options.basis = GetParam().basis;
    options.groups = GetParam().groups;
    options.modes = 7;
    return options;
  }
  FieldParametrisation Make(const Mesh& mesh) const {
    return {test::TestMaterial(), mesh.num_faces(), mesh.num_hinges(),
            MakeFieldTerms(mesh, Options())};
  }

  std::mt19937_64 random_{5};
  const Mesh mesh_ = MakeDisc({.target_vertices = 120});
};

INSTANTIATE_TEST_SUITE_P(
    Product, FieldParametrisationTest,
    testing::Values(FieldCase{FieldBasis::kElements, FieldGroups::kScales, "ElementScales"},
                    FieldCase{FieldBasis::kElements, FieldGroups::kEntries, "ElementEntries"},
                    FieldCase{FieldBasis::kElements, FieldGroups::kBend, "ElementBend"},
                    FieldCase{FieldBasis::kModes, FieldGroups::kScales, "ModeScales"},
                    FieldCase{FieldBasis::kModes, FieldGroups::kStretch, "ModeStretch"},
                    FieldCase{FieldBasis::kModes, FieldGroups::kEntries, "ModeEntries"}),
    [](const auto& info) { return info.param.name; });

TEST_P(FieldParametrisationTest, CountsItsNumbers) {
  const int faces = GetParam().basis == FieldBasis::kModes ? 7 : mesh_.num_faces();
  const int hinges = GetParam().basis == FieldBasis::kModes ? 7 : mesh_.num_hinges();
  const bool entries = GetParam().groups == FieldGroups::kEntries;
  int size = 0;
  if (GetParam().groups != FieldGroups::kBend) size += faces * (entries ? kStretchEntries : 1);
  if (GetParam().groups != FieldGroups::kStretch) size += hinges * (entries ? kBendEntries : 1);
  EXPECT_EQ(Make(mesh_).size(), size);
}

TEST_P(FieldParametrisationTest, IsTheBaseAtZero) {
  const FieldParametrisation fields = Make(mesh_);
  const MaterialField material = fields.Material(Eigen::VectorXd::Zero(fields.size()));
  ASSERT_EQ(material.stretch.size(), static_cast<size_t>(mesh_.num_faces()));
  ASSERT_EQ(material.bend.size(), static_cast<size_t>(mesh_.num_hinges()));
  EXPECT_EQ(material.stretch[17].c[2][1], test::TestMaterial().stretch[0].c[2][1]);
  EXPECT_EQ(material.bend[17].b[2][1], test::TestMaterial().bend[0].b[2][1]);
}

TEST_P(FieldParametrisationTest, EveryElementResistsAllStrains) {
  const FieldParametrisation fields = Make(mesh_);
  for (const double size : {1.0, 10.0})
    EXPECT_TRUE(test::ResistsAllStrains(
        fields.Material(size * test::RandomMatrix(fields.size(), 1, random_))));
}

// L = Σ gradient · entry, so that Vjp, Direction and differences all give dL.
TEST_P(FieldParametrisationTest, DerivativesAgree) {
  const FieldParametrisation fields = Make(mesh_);
  const Eigen::VectorXd theta = 0.3 * test::RandomMatrix(fields.size(), 1, random_);
  const Eigen::VectorXd change = test::RandomMatrix(fields.size(), 1, random_);
  const MaterialGradient gradient{
      test::RandomMatrix(kStretchEntries * mesh_.num_faces(), 2, random_),
      1e6 * test::RandomMatrix(kBendEntries * mesh_.num_hinges(), 2, random_)};
  const auto loss = [&](const MaterialField& material) -> Eigen::VectorXd {
    return gradient.Contract(material).colwise().sum().transpose();
  };
  const MaterialField material = fields.Material(theta);
  const Eigen::VectorXd by_theta = fields.Vjp(material, gradient).transpose() * change;
  const Eigen::VectorXd by_direction = loss(fields.Jvp(material, change));
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd difference = (loss(fields.Material(theta + kStep * change)) -
                                      loss(fields.Material(theta - kStep * change))) /
                                     (2 * kStep);
  EXPECT_LT((by_theta - by_direction).norm(), 1e-12 * by_theta.norm());
  EXPECT_LT((by_theta - difference).norm(), 1e-8 * by_theta.norm());
}

TEST_P(FieldParametrisationTest, MeanLogFactorsAreThoseOfTheEntries) {
  const FieldParametrisation fields = Make(mesh_);
  const Eigen::VectorXd theta = test::RandomMatrix(fields.size(), 1, random_);
  for (const ElementKind kind : {ElementKind::kFaces, ElementKind::kHinges}) {
    const Eigen::VectorXd mean = fields.LogFactors(kind, theta).rowwise().mean();
    EXPECT_LT((fields.MeanLogFactor(kind) * theta - mean).norm(), 1e-12 * (1 + mean.norm()));
  }
}

// The same numbers are the same field on another mesh, to the linear interpolation of the modes.
TEST(FieldTerms, ModesCarryOverBetweenMeshes) {
  std::mt19937_64 random(9);
  FieldOptions options;
  options.basis = FieldBasis::kModes;
  options.modes = 40;
  const Mesh coarse = MakeDisc({.target_vertices = 300}), fine = MakeDisc({.target_vertices = 900});
  const Eigen::VectorXd theta = test::RandomMatrix(2 * options.modes, 1, random);
  const auto on = [&](const Mesh& mesh) -> Eigen::VectorXd {
    return FieldParametrisation(test::TestMaterial(), mesh.num_faces(), mesh.num_hinges(),
                                MakeFieldTerms(mesh, options))
        .LogFactors(ElementKind::kFaces, theta)
        .col(0);
  };
  const Eigen::VectorXd on_coarse = on(coarse), on_fine = on(fine);
  const Eigen::Matrix2Xd places = FaceCentres(fine);
  double error = 0.0;
  for (int f = 0; f < coarse.num_faces(); ++f) {
    Eigen::Index at;
    (places.colwise() - FaceCentres(coarse).col(f)).colwise().norm().minCoeff(&at);
    error += std::pow(on_coarse[f] - on_fine[at], 2) / coarse.num_faces();
  }
  const double scatter = std::sqrt((on_coarse.array() - on_coarse.mean()).square().mean());
  EXPECT_GT(scatter, 0.3);
  EXPECT_LT(std::sqrt(error), 0.2 * scatter);
}

TEST(FieldOptions, NamesAreChecked) {
  EXPECT_EQ(ParseName<FieldBasis>("modes", ""), FieldBasis::kModes);
  EXPECT_EQ(ParseName<FieldGroups>("entries", ""), FieldGroups::kEntries);
  EXPECT_ANY_THROW(ParseName<FieldBasis>("mode", ""));
  EXPECT_ANY_THROW(ParseName<FieldGroups>("all", ""));
}

}  // namespace
}  // namespace drape
