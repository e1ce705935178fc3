// SPDX-License-Identifier: Apache-2.0
// Batches of drapes as functions of factors on their tables and of their starts.
#include "solver/prediction/drape_batch.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>

#include "losses/readout/readouts.h"
#include "physics/util/errors.h"
#include "tests/physics/cloth_fixture.h"

namespace drape::test {
namespace {

class DrapeBatchTest : public testing::TestWithParam<SolveMode> {
 protected:
  static constexpr int kBatch = 3;

  DrapeBatchTest() {
    inputs_ = Random(0.1, 1e-3, 1e-2);
    for (int i = 0; i < kBatch; ++i) inputs_.start.row(i) += model_->mesh.rest_x;
    inputs_.dynamics = RowMatrix::Constant(kBatch, 6, 0.1);
    options_ = {.h = 0.1, .steps = 60, .solve_mode = GetParam()};
  }
  DrapeInputs Random(double log_factors, double start, double velocity) {
    const int dofs = model_->num_dofs();
    return {log_factors * RandomMatrix(kBatch, 7, random_),
            start * RandomMatrix(kBatch, dofs, random_),
            velocity * RandomMatrix(kBatch, dofs, random_), RandomMatrix(kBatch, 6, random_)};
  }
  // The change of drape i by each of the inputs.
  static double Dot(const DrapeInputs& gradient, const DrapeInputs& change, int i) {
    return gradient.log_factors.row(i).dot(change.log_factors.row(i)) +
           gradient.start.row(i).dot(change.start.row(i)) +
           gradient.velocity.row(i).dot(change.velocity.row(i)) +
           gradient.dynamics.row(i).dot(change.dynamics.row(i));
  }
  DrapeBatch Simulated() {
    DrapeBatch batch(*backend_, {TestMaterial()}, inputs_, options_);
    batch.Run();
    return batch;
  }

  std::mt19937_64 random_{29};
  std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth");
  std::unique_ptr<Backend> backend_ = MakeCpuBackend(model_, 2);
  DrapeInputs inputs_;
  DrapeBatchOptions options_;
};

TEST_P(DrapeBatchTest, VjpIsTheTransposeOfJvp) {
  for (const bool record : {false, true}) {
    options_.record = record;
    const DrapeBatch batch = Simulated();
    ASSERT_THAT(batch.IsFound(), testing::Each(true)) << batch.status()[0];
    const FeatureReadout features(model_->mesh, {});
    const PositionReadout positions(model_->mesh);
    for (const Readout* readout :
         {static_cast<const Readout*>(&features), static_cast<const Readout*>(&positions)}) {
      const DrapeInputs change = Random(1.0, 1e-3, 1e-2);
      const RowMatrix jvp = batch.Jvp(*readout, change);
      const RowMatrix u = RandomMatrix(kBatch, readout->size(), random_);
      const DrapeInputs vjp = batch.Vjp(*readout, u);
      for (int i = 0; i < kBatch; ++i) {
        EXPECT_NEAR(Dot(vjp, change, i), u.row(i).dot(jvp.row(i)),
                    5e-10 * u.row(i).norm() * jvp.row(i).norm());
        EXPECT_GT(jvp.row(i).norm(), 0.0);
      }
    }
  }
}

TEST_P(DrapeBatchTest, VjpOfFramesIsTheTransposeOfTheirJvp) {
  options_.frames = {0, 5, 60};
  if (GetParam() == SolveMode::kStatic) {
    EXPECT_THROW(Simulated(), InputError);
    return;
  }
  const DrapeBatch batch = Simulated();
  const DrapeFrames frames = batch.Frames();
  EXPECT_EQ(RowMatrix(frames.x.rightCols(model_->num_dofs())), batch.Positions());
  const DrapeInputs change = Random(1.0, 1e-3, 1e-2);
  const DrapeFrames jvp = batch.FrameJvp(change);
  const DrapeFrames u{RandomMatrix(kBatch, jvp.x.cols(), random_),
                      RandomMatrix(kBatch, jvp.v.cols(), random_)};
  const DrapeInputs vjp = batch.FrameVjp(u);
  for (int i = 0; i < kBatch; ++i) {
    const double expected = u.x.row(i).dot(jvp.x.row(i)) + u.v.row(i).dot(jvp.v.row(i));
    EXPECT_NEAR(Dot(vjp, change, i), expected, 1e-10 * u.v.row(i).norm() * jvp.v.row(i).norm());
  }
}

TEST_P(DrapeBatchTest, FactorsAreThoseOfTheTables) {
  inputs_.log_factors = RowMatrix::Constant(kBatch, 1, std::log(2.0));
  const RowMatrix by_factor = Simulated().Positions();
  MaterialField stiff = TestMaterial();
  for (double& entry : std::span(stiff.bend[0].entries(), kBendEntries)) entry *= 2.0;
  inputs_.log_factors.setZero();
  DrapeBatch batch(*backend_, std::vector<MaterialField>(kBatch, stiff), inputs_, options_);
  batch.Run();
  EXPECT_LT((batch.Positions() - by_factor).norm(), 1e-9 * by_factor.norm());
}

TEST_P(DrapeBatchTest, NumbersOfADrapeThatFailsAreNaN) {
  inputs_.velocity.row(1).setConstant(1e300);
  const DrapeBatch batch = Simulated();
  EXPECT_EQ(batch.status()[1], "step matrix not positive definite");
  EXPECT_THAT(batch.IsFound(), testing::ElementsAre(true, false, true));
  const PositionReadout readout(model_->mesh);
  const DrapeInputs vjp = batch.Vjp(readout, RowMatrix::Ones(kBatch, model_->num_dofs()));
  const DrapeInputs change = Random(1.0, 1e-3, 1e-2);
  for (const RowMatrix& rows :
       {batch.Positions(), batch.Velocities(), batch.Read(readout), RowMatrix(batch.Residuals()),
        batch.Jvp(readout, change), vjp.log_factors, vjp.start, vjp.velocity}) {
    EXPECT_TRUE(rows.row(0).allFinite());
    EXPECT_TRUE(rows.row(1).array().isNaN().all());
  }
}

TEST_P(DrapeBatchTest, RefusesOtherShapes) {
  const auto error = [&](const DrapeInputs& inputs, std::size_t materials) -> std::string {
    try {
      DrapeBatch(*backend_, std::vector<MaterialField>(materials, TestMaterial()), inputs,
                 options_);
    } catch (const InputError& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_EQ(error(inputs_, 1), "");
  EXPECT_EQ(error(inputs_, 2), "materials: found 2, expected 1 or 3, the number of drapes");
  DrapeInputs wrong = inputs_;
  wrong.start.conservativeResize(kBatch, 5);
  EXPECT_EQ(error(wrong, 1), "start: found the shape [3, 5], expected [3, 300]");
  wrong = inputs_;
  wrong.log_factors.conservativeResize(kBatch, 4);
  EXPECT_THAT(error(wrong, 1), testing::HasSubstr("found '4', expected one of 1, 2, 3, 7, 39"));
  wrong = inputs_;
  wrong.velocity(1, 2) = std::nan("");
  EXPECT_EQ(error(wrong, 1), "velocity: found a number that is not finite");
  options_.h = 0.0;
  EXPECT_EQ(error(inputs_, 1), "h: found a time step of 0 s, expected more than 0");
}

INSTANTIATE_TEST_SUITE_P(Modes, DrapeBatchTest,
                         testing::Values(SolveMode::kDynamic, SolveMode::kStatic));

}  // namespace
}  // namespace drape::test
