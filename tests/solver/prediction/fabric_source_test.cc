// SPDX-License-Identifier: Apache-2.0
// Materials of unseen specimens from the files of a fit.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/parametrisation.h"
#include "solver/prediction/prediction.h"
#include "tests/losses/temp_folder.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

using testing::HasSubstr;

// The log factors of an element's tables on those of `base`: for c12 by the logit of its coupling
// (ApplyLogFactors).
Eigen::VectorXd LogFactors(const MaterialField& field, const MaterialField& base, int face = 0,
                           int hinge = 0) {
  Eigen::VectorXd logs(kMaterialEntries);
  for (int k = 0; k < kStretchEntries; ++k)
    logs[k] = std::log(field.stretch[face].entries()[k] / base.stretch[0].entries()[k]);
  for (int k = 0; k < kBendEntries; ++k)
    logs[kStretchEntries + k] =
        std::log(field.bend[hinge].entries()[k] / base.bend[0].entries()[k]);
  const auto logit = [](const double* row) {
    const double coupling = row[1] / std::sqrt(row[0] * row[2]);
    return std::log(coupling / (kLargestCoupling - coupling));
  };
  for (int r = 0; r < kStretchRows; ++r) {
    const int k = r * kStretchCols;
    logs[k + 1] = logit(field.stretch[face].c[r]) - logit(base.stretch[0].c[r]) +
                  0.5 * (logs[k] + logs[k + 2]);
  }
  return logs;
}

class FabricSourceTest : public testing::Test {
 protected:
  // Seven numbers of the fabric and two specimens, correlated.
  StoredPosterior Hierarchy() {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kColumns;
    posterior.specimens = 2;
    posterior.base = test::TestMaterial();
    posterior.mean = test::RandomMatrix(11, 1, random_);
    const Eigen::MatrixXd root = 0.3 * test::RandomMatrix(11, 11, random_);
    posterior.covariance = root * root.transpose();
    posterior.prior_sd = Eigen::VectorXd::Ones(11);
    posterior.prior_sd.tail(4) << 0.6, 0.3, 0.6, 0.3;
    return posterior;
  }
  StoredPosterior Elements() {
    StoredPosterior posterior;
    posterior.kind = PosteriorKind::kElements;
    posterior.base = test::TestMaterial();
    posterior.mean = 0.5 * test::RandomMatrix(39, 1, random_);
    posterior.prior_sd = Eigen::VectorXd::Ones(39);
    posterior.element_sd = Eigen::VectorXd::LinSpaced(39, 0.1, 0.3);
    return posterior;
  }
  // posterior.json of `posterior` with one thing wrong.
  std::string ComputeError(const StoredPosterior& posterior,
                           const std::function<void(nlohmann::json&)>& spoil) {
    WritePosterior(folder_.path(), posterior, "test");
    nlohmann::json file = ReadJsonFile(folder_ / "posterior.json");
    spoil(file);
    std::ofstream(folder_ / "posterior.json") << file;
    return ComputeError(folder_.path());
  }
  std::string ComputeError(const std::string& path) {
    try {
      ReadFabric(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const ClothModel& model() const { return backend_->model(); }

  const TempFolder folder_;
  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  std::mt19937_64 random_{3};
};

TEST_F(FabricSourceTest, AMeanOfNoFabricIsRefused) {
  StoredPosterior far = Hierarchy();
  far.mean[1] = -1e308;
  WritePosterior(folder_.path(), far, "test");
  EXPECT_INPUT_ERROR(ReadPosterior(folder_.path()), "expected a log factor of at most 100");
}

TEST_F(FabricSourceTest, APosteriorReadsBackBitForBit) {
  for (const StoredPosterior& written : {Hierarchy(), Elements()}) {
    WritePosterior(folder_.path(), written, "test");
    const StoredPosterior read = ReadPosterior(folder_.path());
    EXPECT_EQ(read.kind, written.kind);
    EXPECT_EQ(read.fabric, written.fabric);
    EXPECT_EQ(read.specimens, written.specimens);
    EXPECT_EQ(read.mean, written.mean);
    EXPECT_EQ(read.prior_sd, written.prior_sd);
    EXPECT_TRUE(read.covariance.isApprox(written.covariance, 1e-15) || read.covariance.size() == 0);
    EXPECT_EQ(read.element_sd.size(), written.element_sd.size());
    EXPECT_EQ(LogFactors(read.base, written.base).cwiseAbs().maxCoeff(), 0.0);
  }
}

// Log entries of unseen specimens: those of the fabric from the posterior, their scales sampled
// again.
TEST_F(FabricSourceTest, DrawsOfAHierarchyHaveItsMeanAndCovariance) {
  const StoredPosterior posterior = Hierarchy();
  WritePosterior(folder_.path(), posterior, "test");
  const FabricSource fabric = ReadFabric(folder_.path());
  EXPECT_EQ(fabric.kind, "hierarchy");
  const MaterialSource materials = MakeSpecimens(fabric, model().mesh, 5);
  constexpr int kDraws = 20000;
  Eigen::MatrixXd logs(kMaterialEntries, kDraws);
  for (int s = 0; s < kDraws; ++s) logs.col(s) = LogFactors(materials(s), posterior.base);
  const Eigen::MatrixXd tie = TyingMatrix(posterior.fabric);
  Eigen::MatrixXd expected = tie * posterior.covariance.topLeftCorner(7, 7) * tie.transpose();
  expected.topLeftCorner(24, 24).array() += 0.6 * 0.6;
  expected.bottomRightCorner(15, 15).array() += 0.3 * 0.3;
  const Eigen::VectorXd mean = logs.rowwise().mean();
  logs.colwise() -= mean;
  // Six standard errors of a mean and of a variance.
  const double largest = expected.diagonal().maxCoeff();
  EXPECT_LT((mean - tie * posterior.mean.head(7)).cwiseAbs().maxCoeff(),
            6 * std::sqrt(largest / kDraws));
  EXPECT_LT((logs * logs.transpose() / kDraws - expected).cwiseAbs().maxCoeff(),
            6 * largest * std::sqrt(2.0 / kDraws));
}

TEST_F(FabricSourceTest, ElementsDrawOnTheirOwn) {
  const StoredPosterior posterior = Elements();
  WritePosterior(folder_.path(), posterior, "test");
  const FabricSource fabric = ReadFabric(folder_.path());
  EXPECT_EQ(fabric.kind, "bdp");
  const MaterialSource materials = MakeSpecimens(fabric, model().mesh, 5);
  const int faces = model().mesh.num_faces(), hinges = model().mesh.num_hinges();
  constexpr int kSpecimens = 60;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(39), squares = sum, neighbours = sum;
  for (int s = 0; s < kSpecimens; ++s) {
    const MaterialField field = materials(s);
    ASSERT_EQ(field.stretch.size(), static_cast<std::size_t>(faces));
    ASSERT_EQ(field.bend.size(), static_cast<std::size_t>(hinges));
    Eigen::VectorXd last = Eigen::VectorXd::Zero(39);
    for (int e = 0; e < faces; ++e) {
      const Eigen::VectorXd noise = LogFactors(field, posterior.base, e, e) - posterior.mean;
      sum += noise;
      squares += noise.cwiseAbs2();
      neighbours += noise.cwiseProduct(last);
      last = noise;
    }
  }
  const double count = double(kSpecimens) * faces, error = 6 / std::sqrt(count);
  const Eigen::ArrayXd sd = posterior.element_sd.array();
  EXPECT_LT((sum.array() / count / sd).abs().maxCoeff(), error);
  EXPECT_LT((squares.array() / count / sd.square() - 1).abs().maxCoeff(), error * std::sqrt(2.0));
  EXPECT_LT((neighbours.array() / count / sd.square()).abs().maxCoeff(), error);
}

TEST_F(FabricSourceTest, ASpecimenFollowsFromSeedAndNumber) {
  for (const StoredPosterior& posterior : {Hierarchy(), Elements()}) {
    WritePosterior(folder_.path(), posterior, "test");
    const FabricSource fabric = ReadFabric(folder_.path());
    const auto entry = [&](uint64_t seed, int specimen) {
      return MakeSpecimens(fabric, model().mesh, seed)(specimen).bend[0].b[1][2];
    };
    const MaterialSource draws = MakeSpecimens(fabric, model().mesh, 1);
    draws(7);
    EXPECT_EQ(draws(3).bend[0].b[1][2], entry(1, 3));
    EXPECT_NE(entry(1, 3), entry(1, 4));
    EXPECT_NE(entry(1, 3), entry(2, 3));
  }
}

TEST_F(FabricSourceTest, OneTableAndAFieldAreTheSameForAll) {
  Material material = {.name = "a",
                       .field = test::TestMaterial(),
                       .source_convention = "arcsim",
                       .source = "",
                       .warnings = {}};
  WriteMaterial(folder_ / "material.json", material);
  EXPECT_EQ(ReadFabric(folder_.path()).kind, "table");
  const MaterialSource table = MakeSpecimens(ReadFabric(folder_.path()), model().mesh, 1);
  EXPECT_EQ(table(0).stretch.size(), 1u);
  EXPECT_EQ(table(9).bend[0].b[2][4], material.field.bend[0].b[2][4]);
  material.field.stretch.resize(model().mesh.num_faces(), material.field.stretch[0]);
  material.field.bend.resize(model().mesh.num_hinges(), material.field.bend[0]);
  WriteMaterialField(folder_ / "material.json", material, model().mesh);
  const FabricSource source = ReadFabric(folder_ / "material.json", {}, &model().mesh);
  EXPECT_EQ(source.kind, "field");
  const auto field = MakeSpecimens(source, model().mesh, 1)(4);
  EXPECT_EQ(field.stretch.size(), static_cast<std::size_t>(model().mesh.num_faces()));
}

// A later fit into the same folder leaves the files of an earlier one.
TEST_F(FabricSourceTest, TheSummarySaysWhoseFilesCount) {
  WritePosterior(folder_.path(), Elements(), "test");
  WriteMaterial(folder_ / "material.json", {.name = "a",
                                            .field = test::TestMaterial(),
                                            .source_convention = "arcsim",
                                            .source = "",
                                            .warnings = {}});
  std::ofstream(folder_ / "summary.json") << R"({"model": "homogeneous"})";
  EXPECT_EQ(ReadFabric(folder_.path()).kind, "table");
  std::ofstream(folder_ / "summary.json") << R"({"model": "bdp", "posterior": {}})";
  EXPECT_EQ(ReadFabric(folder_.path()).kind, "bdp");
}

TEST_F(FabricSourceTest, BadFilesAreOneClearLine) {
  EXPECT_THAT(ComputeError(folder_.path()), HasSubstr("found no material.json"));
  EXPECT_THAT(ComputeError(folder_ / "none.json"), HasSubstr("none.json"));
  const StoredPosterior hierarchy = Hierarchy();
  const auto error = [&](const auto& spoil) { return ComputeError(hierarchy, spoil); };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_THAT(error([](auto& f) { f["format"] = "drapefit-start-shape"; }),
              HasSubstr("posterior.json: found an object, expected a posterior, with \"format\""));
  EXPECT_THAT(error([](auto& f) { f["version"] = 1; }), HasSubstr("'version': found 1"));
  EXPECT_THAT(error([](auto& f) { f["kind"] = "gan"; }),
              HasSubstr("'kind': found 'gan', expected one of hierarchy, bdp"));
  EXPECT_THAT(error([](auto& f) { f["kind"] = "bdp"; }), HasSubstr("unknown key 'covariance'"));
  EXPECT_THAT(error([](auto& f) { f["names"][2] = "c21"; }), HasSubstr("'names': found"));
  EXPECT_THAT(error([](auto& f) { f["names"].erase(10); }), HasSubstr("'names': found"));
  EXPECT_THAT(error([](auto& f) { f["mean"].erase(3); }),
              HasSubstr("'mean': found an array of 10, expected an array of 11"));
  EXPECT_THAT(error([](auto& f) { f["prior_sd"][1] = -0.5; }), HasSubstr("'prior_sd[1]'"));
  EXPECT_THAT(error([](auto& f) { f["covariance"][4][1] = 9.0; }),
              HasSubstr("'covariance[4][1]': found 9.0, expected a symmetric matrix"));
  EXPECT_THAT(error([](auto& f) { f["covariance"][4][1] = f["covariance"][1][4] = 9.0; }),
              HasSubstr("expected a covariance without negative variances"));
  EXPECT_THAT(error([](auto& f) { f["covariance"][2][2] = -1.0; }),
              HasSubstr("key 'covariance[2][2]': found -1.0, expected a number from"));
  EXPECT_THAT(ComputeError(Elements(), [](auto& f) { f["element_sd"][38] = -1.0; }),
              HasSubstr("'element_sd[38]': found -1.0"));
  EXPECT_THAT(
      ComputeError(Elements(), [&](auto&) { std::filesystem::remove(folder_ / "base.json"); }),
      HasSubstr("base.json"));
}

}  // namespace
}  // namespace drape
