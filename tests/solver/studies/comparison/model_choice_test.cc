// SPDX-License-Identifier: Apache-2.0
// The simplest model within one standard error of the best.
#include "solver/studies/comparison/model_choice.h"

#include <gmock/gmock.h>

#include <cmath>

namespace drape {
namespace {

TEST(ModelChoice, AClearlyBetterModelIsChosenThoughItIsNotSimple) {
  const ModelChoice choice =
      ChooseSimplest({{"homogeneous", {3, 4, 5, 4}}, {"bayes", {1, 2, 3, 1.9}}});
  EXPECT_EQ(choice.best, "bayes");
  EXPECT_EQ(choice.chosen, "bayes");
  EXPECT_EQ(choice.captures, 4);
  EXPECT_DOUBLE_EQ(choice.differences[0].mean_score, 4);
  EXPECT_NEAR(choice.differences[0].mean, 2.025, 1e-12);
}

// Differences 1, −1, 2, −1: mean .25, standard deviation 1.5, standard error .75.
TEST(ModelChoice, WithinOneStandardErrorTheSimplerIsChosen) {
  const ModelChoice choice =
      ChooseSimplest({{"homogeneous", {2, 1, 4, 3}}, {"bayes", {1, 2, 2, 4}}});
  EXPECT_EQ(choice.best, "bayes");
  EXPECT_EQ(choice.chosen, "homogeneous");
  EXPECT_NEAR(choice.differences[0].mean, 0.25, 1e-12);
  EXPECT_NEAR(choice.differences[0].standard_error, 0.75, 1e-12);
}

// The scores scatter by tens, their differences do not: only the paired error sees it.
TEST(ModelChoice, TheErrorIsThatOfPairs) {
  const ModelChoice choice =
      ChooseSimplest({{"homogeneous", {10.2, 20.3, 30.2, 40.3}}, {"bdp", {10, 20, 30, 40}}});
  EXPECT_EQ(choice.chosen, "bdp");
  EXPECT_LT(choice.differences[0].standard_error, 0.05);
}

TEST(ModelChoice, OfEqualsTheSimplestIsBest) {
  const ModelChoice choice =
      ChooseSimplest({{"homogeneous", {2, 1}}, {"heterogeneous", {1, 2}}, {"bayes", {1.5, 1.5}}});
  EXPECT_EQ(choice.best, "homogeneous");
  EXPECT_EQ(choice.chosen, "homogeneous");
}

TEST(ModelChoice, TheSecondSimplestCanBeChosen) {
  const ModelChoice choice = ChooseSimplest(
      {{"homogeneous", {9, 9, 9}}, {"heterogeneous", {2, 1.2, 2.2}}, {"bdp", {2.1, 1, 2.1}}});
  EXPECT_EQ(choice.best, "bdp");
  EXPECT_EQ(choice.chosen, "heterogeneous");
}

// Without a second capture nothing is known of the error: the best is taken.
TEST(ModelChoice, OneCaptureHasNoError) {
  EXPECT_EQ(ChooseSimplest({{"homogeneous", {1.001}}, {"bayes", {1}}}).chosen, "bayes");
  EXPECT_EQ(ChooseSimplest({{"homogeneous", {1}}, {"bayes", {1}}}).chosen, "homogeneous");
}

TEST(ModelChoice, WithoutModelsThereIsNone) { EXPECT_EQ(ChooseSimplest({}).chosen, ""); }

TEST(ModelChoiceDeathTest, AllModelsHaveTheSameCaptures) {
  EXPECT_DEATH(ChooseSimplest({{"homogeneous", {1, 2}}, {"bayes", {1}}}), "size");
}

}  // namespace
}  // namespace drape
