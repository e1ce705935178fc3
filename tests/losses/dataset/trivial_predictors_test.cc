// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/trivial_predictors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "losses/image/segmentation.h"
#include "tests/losses/dataset/synthetic_dataset.h"

namespace drape {
namespace {

// The mean squared error of two concentric discs whose areas differ by `area` [m²].
double ErrorOfArea(double area) { return std::abs(area) * 719.5 * 719.5 / (256 * 256); }
double DiscError(double a, double b) { return ErrorOfArea(M_PI * (a * a - b * b)); }

// Grey pixels on the edges of both discs count less than black ones: the difference is at most
// this.
constexpr double kGreyEdges = 3.5e-3;

ObservedCapture Disc(int fabric, int sample, int capture, double radius) {
  const ClothFace face = capture <= 2 ? ClothFace::kUp : ClothFace::kDown;
  return {{.fabric = fabric, .sample = sample, .capture = capture, .face = face},
          ObserveDisc(radius, Camera(), {})};
}

const PredictorRow& Row(const TrivialPredictors& predictors, const std::string& name) {
  for (const PredictorRow& row : predictors.rows)
    if (row.name == name) return row;
  static const PredictorRow none;
  ADD_FAILURE() << "no row " << name;
  return none;
}

class TrivialPredictorsOfDiscs : public testing::Test {
 protected:
  // Samples of radius 10, 11 and 12 cm; the other face is 14 cm wide and must not be used.
  const std::vector<ObservedCapture> train_ = {Disc(1, 1, 1, 0.10), Disc(1, 1, 2, 0.10),
                                               Disc(1, 2, 1, 0.11), Disc(1, 2, 3, 0.14)};
  const std::vector<ObservedCapture> held_out_ = {Disc(1, 3, 1, 0.12), Disc(1, 3, 2, 0.125)};
};

TEST_F(TrivialPredictorsOfDiscs, InClosedForm) {
  const auto predictors = EvaluateTrivialPredictors(train_, held_out_, Camera());
  const PredictorRow& repeat = Row(predictors, "same sample, same face");
  EXPECT_EQ(repeat.pairs, 2);
  EXPECT_NEAR(repeat.mean.mse, DiscError(0.12, 0.125), kGreyEdges);
  EXPECT_NEAR(repeat.mean.outline_hausdorff, 0.005, 4e-4);
  EXPECT_NEAR(repeat.aligned_mean->mse, repeat.mean.mse, 1e-3);
  const PredictorRow& other = Row(predictors, "another sample, same face");
  EXPECT_EQ(other.pairs, 6);
  EXPECT_NEAR(other.mean.mse,
              (2 * DiscError(0.10, 0.12) + DiscError(0.11, 0.12) + 2 * DiscError(0.10, 0.125) +
               DiscError(0.11, 0.125)) /
                  6,
              kGreyEdges);
  EXPECT_NEAR(other.median.mse, 0.5 * (DiscError(0.10, 0.12) + DiscError(0.11, 0.125)), 2e-2);
  EXPECT_NEAR(other.mean.iou,
              (4 * 0.01 / (0.12 * 0.12) / 2 + 0.0121 / (0.12 * 0.12) + 2 * 0.01 / (0.125 * 0.125) +
               0.0121 / (0.125 * 0.125)) /
                  6,
              5e-3);
  const double mean_radius = std::sqrt((2 * 0.01 + 0.0121) / 3);
  const PredictorRow& circle = Row(predictors, "circle of the mean area");
  EXPECT_EQ(circle.pairs, 2);
  EXPECT_FALSE(circle.aligned_mean);
  EXPECT_NEAR(circle.mean.mse, 0.5 * (DiscError(mean_radius, 0.12) + DiscError(mean_radius, 0.125)),
              kGreyEdges);
  EXPECT_NEAR(circle.mean.profile_rms, 0.1225 - mean_radius, 2e-4);
  // Two thirds of the samples are white in the ring between 10 and 11 cm.
  const double ring = 4.0 / 9 * M_PI * (0.0121 - 0.01);
  const PredictorRow& grey = Row(predictors, "grey mean image");
  EXPECT_NEAR(grey.mean.mse,
              ErrorOfArea(ring) + 0.5 * (DiscError(0.11, 0.12) + DiscError(0.11, 0.125)),
              kGreyEdges);
  EXPECT_EQ(predictors.rows.size(), 4u);
  ASSERT_TRUE(predictors.other_samples);
  EXPECT_EQ(predictors.other_samples->observed, 2);
  EXPECT_NEAR(predictors.other_samples->mean_image_mse, grey.mean.mse, 1e-6);
  // The features of the other samples by their mean and scatter, wider by what three samples leave
  // of the mean.
  ASSERT_TRUE(predictors.normal);
  const FeatureScore &normal = predictors.normal->features[0],
                     &samples = predictors.other_samples->features[0];
  EXPECT_EQ(predictors.normal->observed, 2);
  EXPECT_NEAR(normal.predicted_mean, samples.predicted_mean, 0.1 * samples.predicted_sd);
  EXPECT_NEAR(normal.predicted_sd / samples.predicted_sd, std::sqrt(4.0 / 3.0), 0.06);
  EXPECT_TRUE(std::isnan(predictors.normal->mean_image_mse));
  // A prediction without scatter scores its distance.
  ASSERT_TRUE(predictors.circle);
  EXPECT_NEAR(predictors.circle->mean_image_mse, circle.mean.mse, 1e-6);
  EXPECT_NEAR(predictors.circle->outline_energy, circle.mean.profile_rms, 1e-9);
  EXPECT_EQ(predictors.circle->features[0].ninety.width, 0);
}

TEST_F(TrivialPredictorsOfDiscs, TheSameListLeavesEachSampleOut) {
  std::vector<ObservedCapture> all = train_;
  all.insert(all.end(), held_out_.begin(), held_out_.end());
  const auto predictors = EvaluateTrivialPredictors(all, all, Camera(), false);
  EXPECT_EQ(Row(predictors, "same sample, same face").pairs, 4);
  EXPECT_EQ(Row(predictors, "another sample, same face").pairs, 16);
  EXPECT_EQ(Row(predictors, "circle of the mean area").pairs, 5);  // none for the other face
  EXPECT_FALSE(Row(predictors, "same sample, same face").aligned_mean);
  EXPECT_FALSE(predictors.other_samples);
  EXPECT_FALSE(predictors.normal);
  EXPECT_FALSE(predictors.circle);
}

TEST_F(TrivialPredictorsOfDiscs, AnotherFabricAndFacesThatAreNotKnown) {
  std::vector<ObservedCapture> train = train_;
  train.push_back(Disc(2, 1, 1, 0.15));
  std::vector<ObservedCapture> held_out = held_out_;
  for (const int sample : {3, 4}) {
    held_out.push_back(Disc(1, sample, 7, 0.12));
    held_out.back().capture.face = ClothFace::kUnknown;
  }
  const auto predictors = EvaluateTrivialPredictors(train, held_out, Camera(), false);
  EXPECT_EQ(Row(predictors, "another fabric").pairs, 4);
  EXPECT_NEAR(Row(predictors, "another fabric").median.mse, DiscError(0.15, 0.12), kGreyEdges);
  EXPECT_EQ(Row(predictors, "same sample, same face").pairs, 2);
  EXPECT_EQ(Row(predictors, "another sample, same face").pairs, 6);
}

TEST(ObserveCaptures, ReadsTheSilhouette) {
  const SyntheticDataset tree;
  const Capture capture{.fabric = 1, .sample = 1, .capture = 1, .image = tree.AddImage("a.jpg")};
  const auto seen = ObserveCaptures({capture}, Camera());
  EXPECT_EQ(seen[0].drape.image.coverage, ReadSilhouette(capture.image).image.coverage);
  EXPECT_EQ(seen[0].drape.shape.folds, 5);
}

}  // namespace
}  // namespace drape
