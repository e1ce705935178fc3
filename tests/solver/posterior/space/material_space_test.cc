// SPDX-License-Identifier: Apache-2.0
// A space of materials from posteriors of invented fabrics [METHODS, P60, P61].
#include "solver/posterior/space/material_space.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "solver/fit/parametrisation.h"
#include "solver/posterior/space/space_io.h"
#include "solver/posterior/variational_fit.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape::test {
namespace {

constexpr int kEntries = kMaterialEntries;

class MaterialSpaceTest : public FileFixture {
 protected:
  // A posterior of the 39 log factors of true tables `eta` on the test's material, about a base
  // `base_eta`: the data determine all stretch together and each row of bend, but nothing else.
  StoredPosterior Posterior(const Eigen::VectorXd& eta, const Eigen::VectorXd& base_eta,
                            double density = 0.2) const {
    const TableParametrisation table(TestMaterial(), Eigen::MatrixXd::Identity(39, 39));
    StoredPosterior posterior;
    posterior.base = table.Material(base_eta);
    posterior.base.density = density;
    posterior.specimens = 2;
    posterior.prior_sd = Eigen::VectorXd::Ones(kEntries + 4);
    posterior.prior_sd.tail(4).setConstant(0.1);
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(kEntries, 4);
    seen.col(0).head(kStretchEntries).setConstant(1 / std::sqrt(double(kStretchEntries)));
    for (int row = 0; row < kBendRows; ++row)
      seen.col(1 + row)
          .segment(kStretchEntries + row * kBendCols, kBendCols)
          .setConstant(1 / std::sqrt(double(kBendCols)));
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(kEntries, kEntries);
    const Eigen::MatrixXd fabric = (unit + seen * (400.0 * seen.transpose())).inverse();
    posterior.covariance = Eigen::MatrixXd::Identity(kEntries + 4, kEntries + 4) * 0.01;
    posterior.covariance.topLeftCorner(kEntries, kEntries) = fabric;
    posterior.mean = Eigen::VectorXd::Zero(kEntries + 4);
    posterior.mean.head(kEntries) =
        fabric * (400.0 * (seen * (seen.transpose() * (eta - base_eta))));
    return posterior;
  }
  std::string Store(const std::string& name, const StoredPosterior& posterior) const {
    std::filesystem::create_directories(Path(name));
    WritePosterior(Path(name), posterior, "test");
    return Path(name);
  }
  // Fabrics that differ by all stretch and by the rows of bend.
  static Eigen::VectorXd FabricFactors(int number) {
    const Eigen::VectorXd x = IndependentSamples(4, number + 1, 3).col(number);
    Eigen::VectorXd eta(kEntries);
    eta.head(kStretchEntries).setConstant(0.3 * x[0]);
    for (int row = 0; row < kBendRows; ++row)
      eta.segment(kStretchEntries + row * kBendCols, kBendCols)
          .setConstant(0.5 * x[1] + 0.15 * x[row == 1 ? 1 : 2 + row / 2]);
    return eta;
  }
  std::vector<std::string> StoreFabrics(int count, const Eigen::VectorXd& base_eta,
                                        const std::string& prefix = "fabric_") const {
    std::vector<std::string> folders;
    for (int i = 0; i < count; ++i)
      folders.push_back(Store(prefix + std::to_string(i), Posterior(FabricFactors(i), base_eta)));
    return folders;
  }
  static Eigen::VectorXd NoFactors() { return Eigen::VectorXd::Zero(kEntries); }

  template <class F>
  static std::string CatchError(const F& f) {
    try {
      f();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

// The coordinates of all fabrics move together with the base, so that no distance changes.
TEST_F(MaterialSpaceTest, DoesNotDependOnTheBase) {
  Eigen::VectorXd moved = IndependentSamples(kEntries, 1, 4);
  for (int r = 0; r < kStretchRows; ++r) moved[4 * r + 1] = 0.5 * (moved[4 * r] + moved[4 * r + 2]);
  std::vector<std::string> folders[2];
  for (int i = 0; i < 5; ++i) {
    StoredPosterior posterior = Posterior(FabricFactors(i), NoFactors());
    folders[0].push_back(Store("a" + std::to_string(i), posterior));
    // The same numbers about another base.
    posterior.base = TableParametrisation(TestMaterial(), ParameterTying::kEntries).Material(moved);
    posterior.base.density = 0.2;
    folders[1].push_back(Store("b" + std::to_string(i), posterior));
  }
  const MaterialSpace a = BuildMaterialSpace(ReadFabricBeliefs(folders[0], SpaceBy::kDrape), {});
  const MaterialSpace b = BuildMaterialSpace(ReadFabricBeliefs(folders[1], SpaceBy::kDrape), {});
  EXPECT_LT((a.wasserstein - b.wasserstein).norm(), 1e-9 * a.wasserstein.norm());
  EXPECT_LT((a.hellinger - b.hellinger).norm(), 1e-6);
  EXPECT_NEAR(a.pairs[0].all[0].divergence, b.pairs[0].all[0].divergence, 1e-8);
  ASSERT_TRUE(a.has_population());
  EXPECT_NEAR(a.left_out[2].log_likelihood, b.left_out[2].log_likelihood, 1e-6);
}

// One fabric fitted from two start tables is two points next to each other; the full distance
// mostly measures the start tables.
TEST_F(MaterialSpaceTest, TwoStartTablesOfOneFabricAreNeighbours) {
  std::vector<std::string> folders = StoreFabrics(5, NoFactors());
  Eigen::VectorXd start = 0.7 * IndependentSamples(kEntries, 1, 9);
  for (int r = 0; r < kStretchRows; ++r) start[4 * r + 1] = 0.5 * (start[4 * r] + start[4 * r + 2]);
  folders.push_back(Store("again", Posterior(FabricFactors(0), start)));
  const MaterialSpace space = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kDrape), {});
  EXPECT_EQ(space.directions.ratios.size(), 4);
  for (int i = 1; i < 5; ++i)
    EXPECT_LT(space.wasserstein(0, 5), 0.2 * space.wasserstein(0, i)) << i;
  for (const PairDistances& pair : space.pairs) {
    if (pair.first != 0 || pair.second != 5) continue;
    EXPECT_EQ(pair.directions, 4);
    EXPECT_GT(pair.share_of_prior[0], 0.9);
    EXPECT_LT(pair.determined[1].hellinger, 0.2);
    EXPECT_GT(pair.all[0].wasserstein, 5 * pair.determined[0].wasserstein);
  }
}

// By drape a heavier fabric with stiffness in proportion is the same; by weight it is another.
TEST_F(MaterialSpaceTest, DrapeAndWeightAreNotMixed) {
  std::vector<std::string> folders = StoreFabrics(3, NoFactors());
  const double ratio = 1.7;
  const Eigen::VectorXd heavier = FabricFactors(0).array() + std::log(ratio);
  const Eigen::VectorXd base = Eigen::VectorXd::Constant(kEntries, std::log(ratio));
  folders.push_back(Store("heavy", Posterior(heavier, base, 0.2 * ratio)));
  const MaterialSpace drape = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kDrape), {});
  const MaterialSpace weight = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kWeight), {});
  EXPECT_LT(drape.wasserstein(0, 3), 1e-6);
  EXPECT_GT(weight.wasserstein(0, 3), 0.3);
  EXPECT_GT(drape.beliefs.fabrics[3].density, drape.beliefs.fabrics[0].density);
}

TEST_F(MaterialSpaceTest, NonFabricsAreLessLikelyThanAnyFabric) {
  const std::vector<std::string> folders = StoreFabrics(12, NoFactors());
  const FabricBeliefs beliefs = ReadFabricBeliefs(folders, SpaceBy::kDrape);
  const FabricBelief same = ReadFabricBelief(beliefs.frame, folders[4]);
  const MaterialSpace space = BuildMaterialSpace(beliefs, {same});
  ASSERT_EQ(space.left_out.size(), 12u);
  double least = 1e300;
  for (const JudgedMaterial& fabric : space.left_out)
    least = std::min(least, fabric.log_likelihood);
  ASSERT_EQ(space.non_fabrics.size(), 4u);
  for (const JudgedMaterial& each : space.non_fabrics) {
    EXPECT_LT(each.log_likelihood, least) << each.name;
    EXPECT_DOUBLE_EQ(each.p_value, 1.0 / 13) << each.name;
  }
  ASSERT_EQ(space.added.size(), 1u);
  EXPECT_GT(space.added[0].p_value, 0.2);
  EXPECT_GT(space.added[0].by_fabric[4], 0.9);
}

// The prior that a fit reads: the population where the data determine something, else that of the
// fits; and tables in proportion to the density.
TEST_F(MaterialSpaceTest, ThePriorIsReadBack) {
  const std::vector<std::string> folders = StoreFabrics(12, NoFactors());
  const MaterialSpace space = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kDrape), {});
  WriteMaterialSpace(Path(""), space, {});
  const SpacePrior prior = ReadSpacePrior(Path("space.json"));
  nlohmann::json narrow = nlohmann::json::parse(Read(Path("space.json")));
  narrow["prior"]["covariance"][0][0] = 1e-308;
  Write("narrow.json", narrow.dump());
  EXPECT_THAT(CatchError([&] { ReadSpacePrior(Path("narrow.json")); }),
              testing::HasSubstr("narrow.json: key 'prior.covariance'"));
  nlohmann::json far = nlohmann::json::parse(Read(Path("space.json")));
  far["prior"]["mean"][0] = 1e308;
  Write("far.json", far.dump());
  EXPECT_THAT(CatchError([&] { ReadSpacePrior(Path("far.json")); }),
              testing::HasSubstr("far.json: key 'prior.mean[0]'"));
  EXPECT_EQ(prior.theta.mean, space.prior.mean);
  EXPECT_EQ(prior.theta.covariance, space.prior.covariance);
  EXPECT_EQ(prior.frame.by, SpaceBy::kDrape);
  const Eigen::VectorXd variances =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(prior.theta.covariance).eigenvalues();
  EXPECT_NEAR(variances[kEntries - 1 - 3], 1.0, 1e-6);
  EXPECT_NEAR(variances[20], 1.0, 1e-6);
  const MaterialField light = prior.frame.Table(prior.theta.mean, 0.1);
  const MaterialField heavy = prior.frame.Table(prior.theta.mean, 0.3);
  EXPECT_EQ(light.density, 0.1);
  EXPECT_NEAR(heavy.bend[0].b[1][2], 3 * light.bend[0].b[1][2], 1e-12);
}

TEST_F(MaterialSpaceTest, BendingLengthsAreThoseOfTheTable) {
  const std::vector<std::string> folders = StoreFabrics(2, NoFactors());
  const FabricBeliefs beliefs = ReadFabricBeliefs(folders, SpaceBy::kDrape);
  const FabricBelief& fabric = beliefs.fabrics[1];
  const MaterialField table = beliefs.frame.Table(fabric.theta.mean, fabric.density);
  double sum = 0.0;
  for (const double entry : table.bend[0].b[2]) sum += entry / kBendPerRigidity / kBendCols;
  const NormalDistribution lengths = LogBendingLengths(beliefs.frame, fabric);
  EXPECT_NEAR(std::exp(lengths.mean[0]), BendingLength(sum, table.density), 1e-12);
  EXPECT_GT(lengths.covariance(0, 0), 0.0);
}

TEST_F(MaterialSpaceTest, MistakesAreNamed) {
  const std::vector<std::string> folders = StoreFabrics(2, NoFactors());
  const auto read = [](const std::vector<std::string>& list) {
    return CatchError([&] { ReadFabricBeliefs(list, SpaceBy::kDrape); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(read({folders[0]}), HasSubstr("at least two fabrics"));
  EXPECT_THAT(read({folders[0], folders[0]}), HasSubstr("twice"));
  EXPECT_THAT(read({folders[0], Path("none")}), HasSubstr("none: is no folder"));
  StoredPosterior other = Posterior(FabricFactors(0), NoFactors());
  other.prior_sd.head(kEntries).setConstant(0.5);
  EXPECT_THAT(read({folders[0], Store("narrow", other)}),
              HasSubstr("prior_sd 0.5 to 0.5, expected"));
  StoredPosterior few;
  few.fabric = ParameterTying::kScales;
  few.base = TestMaterial();
  few.mean = Eigen::VectorXd::Zero(2);
  few.prior_sd = Eigen::VectorXd::Ones(2);
  few.covariance = 0.1 * Eigen::MatrixXd::Identity(2, 2);
  EXPECT_THAT(read({folders[0], Store("few", few)}), HasSubstr("2 log factors of a fabric"));
  StoredPosterior apart = few;
  apart.base.stretch[0].c[2][0] *= 1.5;
  EXPECT_THAT(read({Store("few", few), Store("apart", apart)}),
              HasSubstr("more than its 2 numbers can change"));
  Write("space.json", R"({"format": "drapefit-space", "version": 9})");
  EXPECT_THAT(CatchError([&] { ReadSpacePrior(Path("space.json")); }), HasSubstr("version"));
}

// Posteriors that are hardly narrower than their prior.
TEST_F(MaterialSpaceTest, FitsThatDetermineNothingHaveNoPopulation) {
  std::vector<std::string> folders;
  for (int i = 0; i < 3; ++i) {
    StoredPosterior posterior = Posterior(FabricFactors(i), NoFactors());
    posterior.covariance.topLeftCorner(kEntries, kEntries) =
        0.9 * Eigen::MatrixXd::Identity(kEntries, kEntries);
    folders.push_back(Store("vague_" + std::to_string(i), posterior));
  }
  const MaterialSpace space = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kDrape), {});
  EXPECT_EQ(space.determined, 0);
  EXPECT_FALSE(space.has_population());
  EXPECT_EQ(space.pairs[0].directions, 0);
  EXPECT_DOUBLE_EQ(space.pairs[0].share_of_prior[0], 1.0);
  EXPECT_TRUE(std::isnan(space.hellinger(0, 1)));
  EXPECT_THAT(MaterialSpaceText(space), testing::HasSubstr("Hellinger none"));
  WriteMaterialSpace(Path(""), space, {});
  EXPECT_THAT(CatchError([&] { ReadSpacePrior(Path("space.json")); }), testing::HasSubstr("prior"));
}

// Kind bdp: distributions of elements, without a population.
TEST_F(MaterialSpaceTest, ElementsHaveDistancesAlone) {
  std::vector<std::string> folders;
  for (int i = 0; i < 3; ++i) {
    StoredPosterior posterior;
    posterior.kind = PosteriorKind::kElements;
    posterior.base = TestMaterial();
    posterior.mean = FabricFactors(i);
    posterior.prior_sd = Eigen::VectorXd::Ones(kEntries);
    posterior.element_sd = Eigen::VectorXd::Constant(kEntries, 0.2 + 0.1 * i);
    folders.push_back(Store("element_" + std::to_string(i), posterior));
  }
  const MaterialSpace space = BuildMaterialSpace(ReadFabricBeliefs(folders, SpaceBy::kWeight), {});
  EXPECT_FALSE(space.has_population());
  double divergence = 0.0;
  for (int k = 0; k < kEntries; ++k) {
    const double off = FabricFactors(0)[k] - FabricFactors(1)[k];
    divergence += std::log(0.3 / 0.2) + (0.04 + off * off) / (2 * 0.09) - 0.5;
  }
  EXPECT_NEAR(space.pairs[0].all[0].divergence, divergence, 1e-9 * divergence);
  EXPECT_NEAR(space.pairs[0].share_of_prior[0], 0.0, 1e-9);
}

TEST(ShortNames, LeaveOutWhatAllPathsShare) {
  EXPECT_EQ(ShortNames({"a/wool", "b/cotton/"}), (std::vector<std::string>{"wool", "cotton"}));
  EXPECT_EQ(ShortNames({"/o/fabric_1/sample_1", "/o/fabric_2/sample_1"}),
            (std::vector<std::string>{"fabric_1", "fabric_2"}));
  EXPECT_EQ(ShortNames({"o/1/fit", "o/2/fit", "o/2/more/fit"}),
            (std::vector<std::string>{"1", "2", "2/more"}));
  EXPECT_EQ(ShortNames({"fit", "fit"}), (std::vector<std::string>{"fit", "fit"}));
}

}  // namespace
}  // namespace drape::test
