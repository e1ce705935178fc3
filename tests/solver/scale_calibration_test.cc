// SPDX-License-Identifier: Apache-2.0
// Factors by which falling drapes look like those seen.
#include "solver/scale_calibration.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

// A fabric that was fitted, and drapes of another seed of one whose faces differ.
class ScaleCalibrationTest : public testing::Test {
 protected:
  static constexpr ScaleFactors kUp = {0.5, 3.0}, kDown = {1.0, 0.5};

  std::vector<PredictedDrape> Draw(uint64_t seed, const ScaleFactors& up,
                                   const ScaleFactors& down) const {
    PredictionOptions options = options_;
    options.seed = seed;
    options.specimens = 10;
    options.up = up;
    options.down = down;
    const auto backend = MakeCpuBackend(model_, 2);
    return DrawDrapes(
        *backend, [](int) { return TestMaterial(); }, options);
  }
  std::vector<SeenCapture> Seen(bool with_faces) const {
    std::vector<SeenCapture> seen;
    for (PredictedDrape& drape : Draw(77, kUp, kDown))
      if (drape.seen)
        seen.push_back({{.fabric = 1,
                         .sample = 1,
                         .capture = 1,
                         .face = with_faces ? drape.face : ClothFace::kUnknown},
                        std::move(*drape.seen)});
    return seen;
  }
  ScaleCalibration Calibrate(int threads, const std::vector<SeenCapture>& learnt,
                             const std::function<void(int)>& progress = {}) const {
    const auto backend = MakeCpuBackend(model_, threads);
    return CalibrateScales(
        *backend, [](int) { return TestMaterial(); }, options_, learnt, calibration_, progress);
  }
  // How far the mean drape coefficient of draws is from that of those seen.
  static double CoefficientError(const std::vector<PredictedDrape>& drapes,
                                 const std::vector<SeenCapture>& seen) {
    const FeatureScore dc = ScorePrediction(drapes, seen)->features[0];
    return std::abs(dc.predicted_mean - dc.observed_mean);
  }

  const std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth", 100);
  PredictionOptions options_{.faces = {ClothFace::kUp, ClothFace::kDown},
                             .settle = {.steps = {.h = 0.1, .steps = 30}}};
  CalibrationOptions calibration_{.specimens = 10};
};

// Stretch and bend trade against each other, so it is their effect that must be found again.
TEST_F(ScaleCalibrationTest, BringsDrapesOfEachFaceToThoseSeen) {
  const std::vector<SeenCapture> seen = Seen(true);
  ASSERT_GE(seen.size(), 15u);
  const ScaleCalibration found = Calibrate(2, seen);
  EXPECT_FALSE(found.cancelled);
  const auto calibrated = Draw(5, found.up, found.down), as_fitted = Draw(5, {}, {});
  for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
    std::vector<SeenCapture> of_face;
    for (const SeenCapture& each : seen)
      if (each.capture.face == face) of_face.push_back(each);
    EXPECT_LT(CoefficientError(calibrated, of_face), 0.03) << ClothFaceName(face);
    EXPECT_GT(CoefficientError(as_fitted, of_face), 0.05) << ClothFaceName(face);
  }
}

TEST_F(ScaleCalibrationTest, TheBestTrialIsTheAnswer) {
  calibration_.specimens = 4;
  const ScaleCalibration found = Calibrate(2, Seen(true));
  EXPECT_EQ(found.trials.front().face, ClothFace::kUp);
  EXPECT_EQ(found.trials.front().factors, ScaleFactors());
  for (const ScaleTrial& trial : found.trials) {
    const ScaleFactors& factors = trial.face == ClothFace::kUp ? found.up : found.down;
    for (const ScaleTrial& other : found.trials) {
      if (other.face != trial.face || other.factors != factors) continue;
      EXPECT_LE(other.objective, trial.objective);
    }
  }
}

TEST_F(ScaleCalibrationTest, FacesThatAreNotKnownShareTheirFactors) {
  calibration_.specimens = 2;
  const ScaleCalibration found = Calibrate(2, Seen(false));
  EXPECT_EQ(found.up, found.down);
  EXPECT_EQ(found.trials.front().face, ClothFace::kUnknown);
}

TEST_F(ScaleCalibrationTest, AFaceWithoutDrapesHasTheFactorsOfTheOther) {
  calibration_.specimens = 2;
  std::vector<SeenCapture> seen = Seen(true);
  std::erase_if(seen, [](const SeenCapture& s) { return s.capture.face == ClothFace::kUp; });
  const ScaleCalibration found = Calibrate(2, seen);
  EXPECT_EQ(found.up, found.down);
  EXPECT_EQ(found.trials.front().face, ClothFace::kDown);
}

TEST_F(ScaleCalibrationTest, IsTheSameOnEachCountOfThreads) {
  calibration_.specimens = 2;
  const std::vector<SeenCapture> seen = Seen(false);
  const ScaleCalibration one = Calibrate(1, seen), two = Calibrate(2, seen);
  ASSERT_EQ(one.trials.size(), two.trials.size());
  for (std::size_t i = 0; i < one.trials.size(); ++i)
    EXPECT_EQ(one.trials[i].objective, two.trials[i].objective) << i;
}

TEST_F(ScaleCalibrationTest, ANarrowPriorKeepsTheFit) {
  calibration_ = {.sigma = 1e-3, .specimens = 2};
  const ScaleCalibration found = Calibrate(2, Seen(false));
  EXPECT_EQ(found.up, ScaleFactors());
  EXPECT_EQ(found.trials.size(), 13u);  // the middle, and four neighbours at each step
}

TEST_F(ScaleCalibrationTest, AClothThatFindsNoRestIsStiffened) {
  const std::vector<SeenCapture> seen = Seen(false);
  const auto factors = [&](double least) {
    FakeBackend backend;
    backend.fails = [&](double, double b) { return b < least; };
    return CalibrateScales(backend, [](int) { return TestMaterial(); }, options_, seen,
                           {.specimens = 2});
  };
  EXPECT_GE(std::log(factors(1.5).up.bend), 1.5);
  EXPECT_EQ(factors(9).up, ScaleFactors());  // never: as fitted
  EXPECT_EQ(factors(9).trials.front().at_rest, 0);
}

TEST_F(ScaleCalibrationTest, EndsEarlyWhenCancelled) {
  std::atomic<bool> cancel = false;
  const std::vector<SeenCapture> seen = Seen(true);
  options_.settle.steps.cancel = &cancel;
  calibration_.specimens = 2;
  const ScaleCalibration found = Calibrate(2, seen, [&](int trials) { cancel = trials == 2; });
  EXPECT_TRUE(found.cancelled);
  EXPECT_EQ(found.trials.size(), 2u);
}

}  // namespace
}  // namespace drape::test
