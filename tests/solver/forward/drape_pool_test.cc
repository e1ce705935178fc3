// SPDX-License-Identifier: Apache-2.0
// Numbers of specimens, the drapes simulated from them, and predictions by their distributions.
#include "solver/forward/drape_pool.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/metrics/metrics.h"
#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "physics/util/stored/stored_json.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/prediction/generative/fake_pool.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

class DrapePoolTest : public testing::Test {
 protected:
  DrapePool Simulate(int drapes, int threads, const std::atomic<bool>* cancel = nullptr) const {
    const auto backend = MakeCpuBackend(model_, threads);
    return SimulatePool(*backend, Options(drapes), {.cancel = cancel});
  }
  PoolOptions Options(int drapes) const {
    return {.mesh = "disc:100", .drapes = drapes, .settle = {.steps = {.h = 0.1, .steps = 30}}};
  }
  const std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth", 100);
  const std::string path_ = testing::TempDir() + "/" +
                            testing::UnitTest::GetInstance()->current_test_info()->name() +
                            "_pool.json";
};

void ExpectSame(const DrapePool& a, const DrapePool& b) {
  EXPECT_EQ(a.simulated, b.simulated);
  ASSERT_EQ(a.drapes.size(), b.drapes.size());
  for (std::size_t i = 0; i < a.drapes.size(); ++i) {
    EXPECT_EQ(a.drapes[i].numbers, b.drapes[i].numbers) << i;
    EXPECT_EQ(a.drapes[i].shape.features, b.drapes[i].shape.features) << i;
    EXPECT_EQ(a.drapes[i].shape.radius, b.drapes[i].shape.radius) << i;
  }
}

TEST_F(DrapePoolTest, IsTheSameOnAnyThreadsAndFromItsFile) {
  const DrapePool pool = Simulate(12, 2);
  EXPECT_EQ(pool.simulated, 12);
  EXPECT_GE(pool.drapes.size(), 8u);
  ExpectSame(pool, Simulate(12, 1));
  WritePool(path_, pool);
  const DrapePool read = ReadPool(path_);
  ExpectSame(pool, read);
  EXPECT_EQ(pool.LogProposal(), read.LogProposal());
}

// Found in a pool of 16,384 drapes: rounding to seven digits moved a number below its range.
TEST_F(DrapePoolTest, ANumberAtTheEndOfItsRangeIsRead) {
  DrapePool pool = Simulate(4, 2);
  pool.drapes[0].numbers[kLogBendingLength] = -5.403678;
  ASSERT_LT(pool.drapes[0].numbers[kLogBendingLength], NumberRanges()[kLogBendingLength].low);
  WritePool(path_, pool);
  ExpectSame(pool, ReadPool(path_));
}

TEST_F(DrapePoolTest, AFileIsContinuedByDrapesOfTheSameKindOnly) {
  std::filesystem::remove(path_);
  const auto backend = MakeCpuBackend(model_, 2);
  const DrapePool begun = ReadOrSimulatePool(path_, *backend, Options(4), {});
  ExpectSame(begun, ReadOrSimulatePool(path_, *backend, Options(3), {}));
  const DrapePool whole = Simulate(9, 2);
  ExpectSame(whole, ReadOrSimulatePool(path_, *backend, Options(9), {}));
  ExpectSame(whole, ReadPool(path_));
  EXPECT_EQ(ReadPool(path_).rounds.front().drapes, 9);
  const auto message = [&](const PoolOptions& options) -> std::string {
    try {
      ReadOrSimulatePool(path_, *backend, options, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  PoolOptions other = Options(4);
  other.mesh = "disc:200";
  EXPECT_THAT(message(other), testing::HasSubstr("mesh disc:100, expected disc:200"));
  other.mesh = path_;  // the contents of a file stand for it
  EXPECT_THAT(message(other), testing::HasSubstr("disc:100, expected of SHA-256 "));
  other = Options(4);
  other.seed = 2;
  EXPECT_THAT(message(other), testing::HasSubstr("seed 1, expected 2"));
  other = Options(4);
  other.settle.steps.h = 0.05;
  EXPECT_THAT(message(other), testing::HasSubstr("30 steps of 0.1 s, expected"));
}

// With a checksum that is right; found by fuzzing.
TEST_F(DrapePoolTest, AFileWithOtherMembersIsRefusedByName) {
  WritePool(path_, Simulate(4, 2));
  const StoredFormat format = {"drapefit-drape-pool", 1};
  const nlohmann::json members = ReadStoredJson(path_, format);
  const auto expect = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json other = members;
    other[key] = value;
    WriteStoredJson(path_, format, other);
    EXPECT_INPUT_ERROR(ReadPool(path_), std::string("key '") + key + "'");
  };
  for (const nlohmann::json& seed : {nlohmann::json("1"), nlohmann::json(-1)}) expect("seed", seed);
  expect("simulated", 0);
}

TEST_F(DrapePoolTest, EndsEarlyWhenCancelled) {
  const std::atomic<bool> cancel = true;
  EXPECT_EQ(Simulate(8, 2, &cancel).simulated, 0);
}

TEST(SpecimenDistributionTest, ADrapeHardlyDependsOnTheDensity) {
  const auto model = SmallDisc("smooth", 100);
  const auto backend = MakeCpuBackend(model, 2);
  const SpecimenNumbers numbers = FakeFabric().mean[0];
  std::vector<MaterialField> materials;
  for (const double density : {0.15, 0.25}) materials.push_back(SpecimenMaterial(numbers, density));
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support, SpecimenStart(numbers, 7));
  const std::vector<RolloutInput> inputs = {{&materials[0], &start}, {&materials[1], &start}};
  const auto drapes = Settle(*backend, inputs, {});
  ASSERT_TRUE(drapes[0].IsUsable(SolveMode::kStatic));
  // What is left is that the springs of the support give way.
  EXPECT_LT((drapes[0].rest.x - drapes[1].rest.x).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SpecimenDistributionTest, NumbersAreThoseOfTheMaterialAndStart) {
  SpecimenNumbers numbers = FakeFabric().mean[0];
  numbers[kBendAnisotropy] = 0.8;
  const MaterialField material = SpecimenMaterial(numbers, 0.25);
  EXPECT_TRUE(test::ResistsAllStrains(material));
  const auto& bend = material.bend[0].b;
  EXPECT_NEAR(std::log(bend[0][0] / bend[2][0]), 0.8, 1e-12);
  EXPECT_NEAR(BendingLength(std::sqrt(bend[0][0] * bend[2][0]) / kBendPerRigidity, 0.25), 0.016,
              1e-12);
  std::vector<double> squares;
  for (uint64_t seed = 0; seed < 2000; ++seed)
    squares.push_back(std::pow(HemRms(SpecimenStart(numbers, seed)), 2));
  EXPECT_NEAR(std::sqrt(SpreadOfValues(squares).mean) / std::exp(numbers[kLogStartHeight]), 1.0,
              0.03);
}

TEST(SpecimenDistributionTest, SamplesHaveTheDensityOfTheRoundsThatTheyAreDrawnFrom) {
  // The integral of a distribution's density, estimated from drapes of three rounds.
  const SpecimenDistribution fabric = FakeFabric();
  SpecimenDistribution wide = fabric;
  wide.deviation *= 1.3;
  const DrapePool pool =
      Join(Join(FakePool(2000), FakePoolAround(fabric, 3000)), FakePoolAround(wide, 3000));
  const Eigen::VectorXd log_proposal = pool.LogProposal();
  for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
    double sum = 0.0;
    for (std::size_t i = 0; i < pool.drapes.size(); ++i)
      sum += std::exp(LogDensity(fabric, face, pool.drapes[i].numbers) - log_proposal[i]);
    EXPECT_NEAR(sum / pool.simulated, 1.0, 0.08) << ClothFaceName(face);
  }
}

TEST(SpecimenDistributionTest, FacesOfASpecimenShareTheirChance) {
  const SpecimenDistribution fabric = FakeFabric();
  const SpecimenNumbers up = SampleNumbers(fabric, ClothFace::kUp, 4),
                        down = SampleNumbers(fabric, ClothFace::kDown, 4);
  EXPECT_NEAR(down[kLogBendingLength] - up[kLogBendingLength], std::log(0.019 / 0.016), 1e-12);
  EXPECT_EQ(up[kLogStartHeight], down[kLogStartHeight]);
}

// Draped, learned and draped again, on a coarse mesh.
TEST_F(DrapePoolTest, ALearnedFabricDrapesAsItsSamples) {
  const auto backend = MakeCpuBackend(model_, 2);
  const PredictionOptions draws{.specimens = 10,
                                .faces = {ClothFace::kUp, ClothFace::kDown},
                                .settle = {.steps = {.h = 0.1, .steps = 30}},
                                .batch = 2};
  DistributionFit generating;
  generating.best = FakeFabric();
  std::vector<ObservedCapture> seen;
  for (PredictedDrape& drape : SampleSpecimens(*backend, generating, draws))
    if (drape.seen)
      seen.push_back({{.fabric = 1, .sample = drape.specimen, .capture = 1, .face = drape.face},
                      std::move(*drape.seen)});
  ASSERT_GE(seen.size(), 14u);
  const std::string file = testing::TempDir() + "/learned_pool.json";
  std::filesystem::remove(file);
  const LearnedFabric learned = LearnFabric(*backend, seen,
                                            {.pool = Options(200),
                                             .pool_file = file,
                                             .round_drapes = 50,
                                             .rounds = 1,
                                             .fit = {.least_effective = 20.0, .resamples = 4}},
                                            {});
  EXPECT_EQ(learned.simulated, 250);
  for (const int face : {0, 1})
    EXPECT_NEAR(learned.fit.best.mean[face][kLogBendingLength],
                generating.best.mean[face][kLogBendingLength], 0.15)
        << face;
  WriteDistributionFit(path_, learned.fit);
  const DistributionFit read = ReadDistributionFit(path_);
  PredictionOptions again = draws;
  again.seed = 9;
  const auto drapes = SampleSpecimens(*backend, read, again);
  const auto direct = SampleSpecimens(*backend, learned.fit, again);
  ASSERT_EQ(drapes.size(), direct.size());
  for (std::size_t i = 0; i < drapes.size(); ++i) EXPECT_EQ(drapes[i].x, direct[i].x) << i;
  const auto score = ScorePrediction(drapes, seen);
  ASSERT_TRUE(score.has_value());
  EXPECT_LT(std::abs(score->features[0].predicted_mean - score->features[0].observed_mean), 0.04);
}

}  // namespace
}  // namespace drape::test
