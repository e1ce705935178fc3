// SPDX-License-Identifier: Apache-2.0
// Draws of drapes: what they start from, what becomes of them, how they are scored.
#include "solver/prediction/prediction.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

const MaterialSource kSame = [](int) { return TestMaterial(); };

Eigen::VectorXd Heights(const DrapeTask& task) {
  return task.start.x.reshaped(3, task.start.x.size() / 3).row(2);
}

double Rms(const Eigen::VectorXd& values) { return values.norm() / std::sqrt(values.size()); }

class PredictedStarts : public testing::Test {
 protected:
  DrapeTask Task(int drape) const { return MakeDrapeTask(*model_, kSame, options_, drape); }

  std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth", 200);
  PredictionOptions options_{
      .specimens = 300, .repeats = 2, .faces = {ClothFace::kUp, ClothFace::kDown}};
};

TEST_F(PredictedStarts, FollowFromTheSeed) {
  const DrapeTask first = Task(6);
  EXPECT_EQ(first.start.x, Task(6).start.x);
  EXPECT_EQ(first.start.v, Eigen::VectorXd::Zero(model_->num_dofs()));
  options_.seed = 2;
  EXPECT_GT((first.start.x - Task(6).start.x).norm(), 1e-3);
}

TEST_F(PredictedStarts, MoreDrawsLeaveTheFirstAsTheyAre) {
  const DrapeTask up = Task(8), down = Task(10);  // of specimen 2
  options_.specimens = 3;
  options_.repeats = 5;
  EXPECT_EQ(Task(20).start.x, up.start.x);
  EXPECT_EQ(Task(25).start.x, down.start.x);
  options_.faces = {ClothFace::kDown};
  EXPECT_EQ(Task(10).start.x, down.start.x);
}

TEST_F(PredictedStarts, OfTheOtherFaceIsMirrored) {
  options_.capture_rms = 0;
  const DrapeTask up = Task(4), down = Task(6);
  EXPECT_GT(Rms(Heights(up)), 1e-4);
  EXPECT_EQ(Heights(up), -Heights(down));
  EXPECT_EQ(Task(5).start.x, up.start.x);                    // a repeat
  EXPECT_GT((Heights(up) - Heights(Task(8))).norm(), 1e-3);  // another specimen
}

TEST_F(PredictedStarts, HaveTheSizesAskedFor) {
  options_.capture_rms = 0;
  const Eigen::VectorXd radius =
      model_->mesh.rest_x.reshaped(3, model_->mesh.num_vertices()).topRows<2>().colwise().norm();
  double hem = 0, count = 0;
  for (int specimen = 0; specimen < options_.specimens; ++specimen) {
    const Eigen::VectorXd z = Heights(Task(4 * specimen));
    for (int i = 0; i < z.size(); ++i)
      if (radius[i] > 0.1499) hem += z[i] * z[i], ++count;
  }
  EXPECT_NEAR(std::sqrt(hem / count), options_.start_rms, 0.1 * options_.start_rms);
  const Eigen::VectorXd relaxed = Heights(Task(0));
  options_.capture_rms = 2e-4;
  const Eigen::VectorXd noise = Heights(Task(0)) - relaxed;
  constexpr double kEdge = DrapeDiscs().support + 1e-6;
  const double outside = (radius.array() > kEdge).count();
  EXPECT_NEAR(noise.norm() / std::sqrt(outside), 2e-4, 3e-5);
  EXPECT_EQ((radius.array() <= kEdge).select(noise, 0.0).norm(), 0.0);
  EXPECT_GT(Rms(noise - (Heights(Task(1)) - relaxed)), 1e-4);  // another capture, other noise
}

TEST_F(PredictedStarts, ScalesAreOfTheSpecimen) {
  options_.specimen_stretch_sigma = 0.2;
  options_.specimen_bend_sigma = 0.4;
  Eigen::MatrixX2d logs(options_.specimens, 2);
  for (int i = 0; i < options_.specimens; ++i)
    logs.row(i) = FakeBackend::Logs(Task(4 * i).material);
  EXPECT_EQ(FakeBackend::Logs(Task(7).material), Eigen::Vector2d(logs.row(1)));
  EXPECT_NEAR(Rms(logs.col(0)), 0.2, 0.03);
  EXPECT_NEAR(Rms(logs.col(1)), 0.4, 0.06);
  EXPECT_NEAR(logs.col(0).dot(logs.col(1)) / options_.specimens, 0.0, 0.015);
}

TEST_F(PredictedStarts, EachSpecimenAsksForItsMaterial) {
  const MaterialSource denser = [](int specimen) {
    MaterialField material = TestMaterial();
    material.density = 1.0 + specimen;
    return material;
  };
  EXPECT_EQ(MakeDrapeTask(*model_, denser, options_, 11).material.density, 3.0);
}

TEST(Prediction, DoesNotDependOnBatchesAndThreads) {
  const auto model = SmallDisc("smooth", 100);
  const MaterialField material = TestMaterial();
  PredictionOptions options{.specimens = 3,
                            .faces = {ClothFace::kUp, ClothFace::kDown},
                            .specimen_bend_sigma = 0.3,
                            .settle = {.steps = {.h = 0.1, .steps = 40}}};
  const auto draw = [&](int batch, int threads) {
    options.batch = batch;
    const auto backend = MakeCpuBackend(model, threads);
    return SampleDrapes(
        *backend, [&](int) { return material; }, options);
  };
  const auto alone = draw(1, 1);
  ASSERT_EQ(alone.size(), 6u);
  for (const auto& [batch, threads] : {std::pair(4, 2), std::pair(64, 1)}) {
    const auto joined = draw(batch, threads);
    ASSERT_EQ(joined.size(), 6u);
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(joined[i].x, alone[i].x) << i;
      EXPECT_EQ(joined[i].status, alone[i].status);
      EXPECT_EQ(joined[i].specimen, i / 2);
      EXPECT_EQ(joined[i].face, i % 2 == 0 ? ClothFace::kUp : ClothFace::kDown);
    }
  }
  EXPECT_GT(ObservedDrapes(alone, ClothFace::kUnknown).size(), 3u);
}

TEST(Prediction, CountsDrawsWithoutRest) {
  FakeBackend backend;
  backend.fails = [](double, double b) { return b > 0; };
  PredictionOptions options{.specimens = 40, .repeats = 2, .specimen_bend_sigma = 0.1};
  const auto drapes = SampleDrapes(backend, kSame, options);
  ASSERT_EQ(drapes.size(), 80u);
  size_t failed = 0;
  for (int i = 0; i < 80; ++i) {
    const bool fails =
        FakeBackend::Logs(MakeDrapeTask(backend.model(), kSame, options, i).material)[1] > 0;
    failed += fails;
    EXPECT_EQ(drapes[i].seen.has_value(), !fails);
    EXPECT_EQ(drapes[i].status, fails ? ToString(RolloutStatus::kNotPositiveDefinite)
                                      : ToString(EquilibriumStatus::kStable));
  }
  EXPECT_GT(failed, 20u);
  EXPECT_EQ(ObservedDrapes(drapes, ClothFace::kUp).size(), 80 - failed);
  EXPECT_TRUE(ObservedDrapes(drapes, ClothFace::kDown).empty());
}

TEST(Prediction, ADrapeThatIsNotSeenSaysWhy) {
  FakeBackend backend;
  PredictionOptions options{.specimens = 2};
  options.camera.cx = -400;
  const auto drapes = SampleDrapes(backend, kSame, options);
  EXPECT_FALSE(drapes[0].seen);
  EXPECT_THAT(drapes[0].status, testing::HasSubstr("the outline has gaps"));
  EXPECT_GT(drapes[0].x.size(), 0);
}

TEST(Prediction, EndsEarlyWhenCancelled) {
  FakeBackend backend;
  std::atomic<bool> cancel = false;
  PredictionOptions options{.specimens = 10, .batch = 3};
  options.settle.steps.cancel = &cancel;
  const auto some = SampleDrapes(backend, kSame, options, [&](int done) { cancel = done >= 4; });
  EXPECT_EQ(some.size(), 6u);
  cancel = false;
  EXPECT_EQ(SampleDrapes(backend, kSame, options).size(), 10u);
  const MaterialSource stops_at_4 = [&](int specimen) {
    if (specimen == 4) cancel = true;
    return TestMaterial();
  };
  EXPECT_EQ(SampleDrapes(backend, stops_at_4, options).size(), 3u);  // none of those under way
}

PredictedDrape Disc(ClothFace face, double radius) {
  PredictedDrape drape;
  drape.face = face;
  drape.seen = ObserveDisc(radius, Camera(), {});
  return drape;
}

ObservedCapture Seen(ClothFace face, double radius) {
  return {{.fabric = 1, .sample = 1, .capture = 1, .face = face},
          ObserveDisc(radius, Camera(), {})};
}

TEST(PredictionScore, IsOfTheSameFace) {
  const auto up = ClothFace::kUp, down = ClothFace::kDown;
  std::vector<PredictedDrape> drapes = {Disc(up, 0.10), Disc(up, 0.10), Disc(down, 0.13),
                                        Disc(down, 0.13)};
  drapes.emplace_back();  // found no rest
  const auto score = ScorePrediction(drapes, {Seen(up, 0.11), Seen(down, 0.13)});
  ASSERT_TRUE(score);
  EXPECT_EQ(score->observed, 2);
  EXPECT_NEAR(score->outline_energy, 0.005, 2e-4);
  const auto unknown = ScorePrediction(drapes, {Seen(ClothFace::kUnknown, 0.13)});
  ASSERT_TRUE(unknown);
  EXPECT_NEAR(unknown->outline_energy, 0.015 - 0.01, 2e-4);  // E|X − y| − ½ E|X − X'|, 4 of 6 pairs
  drapes.pop_back();
  drapes.pop_back();
  EXPECT_FALSE(ScorePrediction(drapes, {Seen(up, 0.11), Seen(down, 0.13)}));
  EXPECT_TRUE(ScorePrediction(drapes, {Seen(up, 0.11)}));
  EXPECT_FALSE(ScorePrediction(drapes, {}));
}

}  // namespace
}  // namespace drape::test
