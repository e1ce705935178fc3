// SPDX-License-Identifier: Apache-2.0
// Baselines of the published drapes without a model, see losses/README.md; the data are read in
// place.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "losses/dataset/trivial_predictors.h"

namespace drape {
namespace {

class CusickMetrics : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(root_)) GTEST_SKIP() << "no public data set at " << root_;
  }
  std::vector<ObservedCapture> See(const Selection& selection) const {
    return ObserveCaptures(Select(ReadDataset(root_), selection), Camera());
  }
  const std::string root_ = DRAPE_SHARED_DIR "/cusick";
};

const PredictorRow& Row(const TrivialPredictors& predictors, const std::string& name) {
  for (const PredictorRow& row : predictors.rows) {
    if (row.name != name) continue;
    std::printf("%s: %d pairs, mse %.4f (median %.4f), Hausdorff %.4f m\n", name.c_str(), row.pairs,
                row.mean.mse, row.median.mse, row.mean.outline_hausdorff);
    return row;
  }
  static const PredictorRow none;
  ADD_FAILURE() << "no row " << name;
  return none;
}

// Each sample of fabrics 1–5 is left out in turn, without alignment.
TEST_F(CusickMetrics, TrivialPredictorsAreThoseOfTheTable) {
  const auto captures = See({.fabrics = {1, 2, 3, 4, 5}});
  const auto predictors = EvaluateTrivialPredictors(captures, captures, Camera(), false);
  const PredictorRow& repeat = Row(predictors, "same sample, same face");
  EXPECT_EQ(repeat.pairs, 240);
  EXPECT_NEAR(repeat.mean.mse, 0.018, 5e-4);
  EXPECT_NEAR(repeat.median.mse, 0.0085, 5e-5);
  EXPECT_NEAR(repeat.mean.outline_hausdorff, 0.0112, 2e-4);
  const PredictorRow& sample = Row(predictors, "another sample, same face");
  EXPECT_EQ(sample.pairs, 5280);
  EXPECT_NEAR(sample.mean.mse, 0.048,
              1.5e-3);  // .0489: the choice of pairs of the table is not documented
  EXPECT_NEAR(sample.mean.outline_hausdorff, 0.0237, 5e-4);
  const PredictorRow& fabric = Row(predictors, "another fabric");
  EXPECT_NEAR(fabric.mean.mse, 0.118, 3e-3);
  EXPECT_NEAR(fabric.mean.outline_hausdorff, 0.039, 1e-3);
  const PredictorRow& circle = Row(predictors, "circle of the mean area");
  EXPECT_NEAR(circle.mean.mse, 0.040, 5e-4);
  EXPECT_NEAR(circle.mean.outline_hausdorff, 0.0185, 1e-4);
  EXPECT_NEAR(Row(predictors, "grey mean image").mean.mse, 0.026, 5e-4);
}

// Other samples of the fabric are the best prediction there is: their intervals are calibrated.
TEST_F(CusickMetrics, OtherSamplesAreACalibratedPrediction) {
  const auto captures = See({.fabrics = {2, 5}});
  const auto predictors = EvaluateTrivialPredictors(captures, captures, Camera(), false);
  ASSERT_TRUE(predictors.other_samples);
  const FeatureScore& dc = predictors.other_samples->features[0];
  EXPECT_NEAR(dc.half.nominal, 0.5, 1e-12);
  EXPECT_NEAR(dc.half.coverage, 0.5, 0.1);
  EXPECT_NEAR(dc.ninety.nominal, 0.9, 1e-12);
  EXPECT_NEAR(dc.ninety.coverage, 0.9, 0.06);
  EXPECT_NEAR(dc.observed_mean, dc.predicted_mean, 1e-3);
  EXPECT_NEAR(predictors.other_samples->mean_image_mse, Row(predictors, "grey mean image").mean.mse,
              1e-9);
}

// A selection of pairs: captures 1 and 3, samples up to three apart.
TEST_F(CusickMetrics, AlignedOtherSamples) {
  const auto captures = See({.fabrics = {1, 2, 3, 4, 5}, .captures = {1, 3}});
  double mse = 0, hausdorff = 0;
  int pairs = 0;
  for (const ObservedCapture& a : captures) {
    for (const ObservedCapture& b : captures) {
      const int apart = b.capture.sample - a.capture.sample;
      if (a.capture.fabric != b.capture.fabric || a.capture.face != b.capture.face) continue;
      if (apart < 1 || apart > 3) continue;
      const auto c = CompareDrapes(a.drape, b.drape, Camera()).aligned;
      mse += c.mse;
      hausdorff += c.outline_hausdorff;
      ++pairs;
    }
  }
  EXPECT_EQ(pairs, 5 * 2 * 30);
  EXPECT_NEAR(mse / pairs, 0.032, 2e-3);
  // .0195: alignment by the MSE of the images instead gives .0211 for .0199 on 30 pairs.
  EXPECT_NEAR(hausdorff / pairs, 0.0209, 2e-3);
}

TEST_F(CusickMetrics, AlignedRepeats) {
  const auto captures = See({.fabrics = {1, 2, 3, 4, 5}});
  double mse = 0, hausdorff = 0;
  for (size_t i = 0; i < captures.size(); i += 2) {  // captures 1 and 2, 3 and 4
    const auto c = CompareDrapes(captures[i].drape, captures[i + 1].drape, Camera()).aligned;
    mse += c.mse / 120;
    hausdorff += c.outline_hausdorff / 120;
  }
  EXPECT_NEAR(mse, 0.014, 5e-4);
  EXPECT_NEAR(hausdorff, 0.0104, 6e-4);
}

}  // namespace
}  // namespace drape
