// SPDX-License-Identifier: Apache-2.0
// Factors on bend by which falling drapes look like those seen.
#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "solver/prediction/prediction.h"
#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

// A fabric that was fitted, and drapes of another seed of one whose faces differ.
class BendCalibrationTest : public testing::Test {
 protected:
  static constexpr BendFactors kTruth = {.up = 2.5, .down = 0.5};

  std::vector<PredictedDrape> Draw(uint64_t seed, const BendFactors& factors) const {
    PredictionOptions options = options_;
    options.seed = seed;
    options.specimens = 8;
    options.bend = factors;
    const auto backend = MakeCpuBackend(model_, 2);
    return SampleDrapes(
        *backend, [](int) { return TestMaterial(); }, options);
  }
  std::vector<ObservedCapture> Seen(bool with_faces) const {
    static const std::vector<PredictedDrape> drapes = Draw(77, kTruth);
    std::vector<ObservedCapture> seen;
    for (const PredictedDrape& drape : drapes)
      if (drape.seen)
        seen.push_back({{.fabric = 1,
                         .sample = 1,
                         .capture = 1,
                         .face = with_faces ? drape.face : ClothFace::kUnknown},
                        *drape.seen});
    return seen;
  }
  BendCalibration Calibrate(int threads, const std::vector<ObservedCapture>& training,
                            const std::function<void(int)>& progress = {}) const {
    const auto backend = MakeCpuBackend(model_, threads);
    return CalibrateBend(
        *backend, [](int) { return TestMaterial(); }, options_, training, calibration_, progress);
  }
  // How far the mean drape coefficient of samples is from that of those seen.
  static double CoefficientError(const std::vector<PredictedDrape>& drapes,
                                 const std::vector<ObservedCapture>& seen) {
    const FeatureScore dc = ScorePrediction(drapes, seen)->features[0];
    return std::abs(dc.predicted_mean - dc.observed_mean);
  }

  const std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth", 100);
  PredictionOptions options_{.faces = {ClothFace::kUp, ClothFace::kDown},
                             .settle = {.steps = {.h = 0.1, .steps = 30}}};
  CalibrationOptions calibration_{.specimens = 4};
};

TEST_F(BendCalibrationTest, BringsDrapesOfEachFaceToThoseSeen) {
  const std::vector<ObservedCapture> seen = Seen(true);
  ASSERT_GE(seen.size(), 12u);
  const BendCalibration found = Calibrate(2, seen);
  EXPECT_FALSE(found.cancelled);
  const auto calibrated = Draw(5, found.factors), as_fitted = Draw(5, {});
  for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
    std::vector<ObservedCapture> of_face;
    for (const ObservedCapture& each : seen)
      if (each.capture.face == face) of_face.push_back(each);
    EXPECT_LT(CoefficientError(calibrated, of_face), 0.03) << ClothFaceName(face);
    EXPECT_GT(CoefficientError(as_fitted, of_face), 0.05) << ClothFaceName(face);
  }
}

TEST_F(BendCalibrationTest, TheBestTrialIsTheAnswer) {
  calibration_.specimens = 2;
  const BendCalibration found = Calibrate(2, Seen(true));
  EXPECT_EQ(found.trials.front().face, ClothFace::kUp);
  EXPECT_EQ(found.trials.front().factor, 1.0);
  for (const BendTrial& trial : found.trials) {
    const double factor = found.factors.of(trial.face);
    for (const BendTrial& other : found.trials) {
      if (other.face != trial.face || other.factor != factor) continue;
      EXPECT_LE(other.objective, trial.objective);
    }
  }
}

TEST_F(BendCalibrationTest, FacesThatAreNotKnownShareTheirFactors) {
  calibration_.specimens = 2;
  const BendCalibration found = Calibrate(2, Seen(false));
  EXPECT_EQ(found.factors.up, found.factors.down);
  EXPECT_EQ(found.trials.front().face, ClothFace::kUnknown);
}

TEST_F(BendCalibrationTest, AFaceWithoutDrapesHasTheFactorsOfTheOther) {
  calibration_.specimens = 2;
  std::vector<ObservedCapture> seen = Seen(true);
  std::erase_if(seen, [](const ObservedCapture& s) { return s.capture.face == ClothFace::kUp; });
  const BendCalibration found = Calibrate(2, seen);
  EXPECT_EQ(found.factors.up, found.factors.down);
  EXPECT_EQ(found.trials.front().face, ClothFace::kDown);
}

TEST_F(BendCalibrationTest, IsTheSameOnEachCountOfThreads) {
  calibration_.specimens = 2;
  const std::vector<ObservedCapture> seen = Seen(false);
  const BendCalibration one = Calibrate(1, seen), two = Calibrate(2, seen);
  ASSERT_EQ(one.trials.size(), two.trials.size());
  for (std::size_t i = 0; i < one.trials.size(); ++i)
    EXPECT_EQ(one.trials[i].objective, two.trials[i].objective) << i;
}

TEST_F(BendCalibrationTest, ANarrowPriorKeepsTheFit) {
  calibration_ = {.sigma = 1e-3, .specimens = 2};
  const BendCalibration found = Calibrate(2, Seen(false));
  EXPECT_EQ(found.factors.up, 1.0);
  EXPECT_EQ(found.trials.size(), 7u);  // the middle, and two neighbours at each step
}

TEST_F(BendCalibrationTest, AClothThatFindsNoRestIsStiffened) {
  const std::vector<ObservedCapture> seen = Seen(false);
  const auto calibrated = [&](double least) {
    FakeBackend backend;
    backend.fails = [&](double, double b) { return b < least; };
    return CalibrateBend(backend, [](int) { return TestMaterial(); }, options_, seen,
                         {.specimens = 2});
  };
  EXPECT_GE(std::log(calibrated(1.5).factors.up), 1.5);
  EXPECT_EQ(calibrated(9).factors.up, 1.0);  // never: as fitted
  EXPECT_EQ(calibrated(9).trials.front().at_rest, 0);
}

TEST_F(BendCalibrationTest, EndsEarlyWhenCancelled) {
  std::atomic<bool> cancel = false;
  const std::vector<ObservedCapture> seen = Seen(true);
  options_.settle.steps.cancel = &cancel;
  calibration_.specimens = 2;
  const BendCalibration found = Calibrate(2, seen, [&](int trials) { cancel = trials == 2; });
  EXPECT_TRUE(found.cancelled);
  EXPECT_EQ(found.trials.size(), 2u);
}

}  // namespace
}  // namespace drape::test
