// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

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
