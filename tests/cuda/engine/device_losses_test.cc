// SPDX-License-Identifier: Apache-2.0
// Outlines and soft silhouettes that a device reads by itself, held to losses/ on the host.
#include <algorithm>
#include <limits>
#include <tuple>

#include "cuda/device/device.h"
#include "cuda/factor/plan/front_plan.h"
#include "cuda/readout/device_readouts.h"
#include "losses/readout/readouts.h"
#include "losses/silhouette/silhouette_edges.h"
#include "physics/cloth/start_shape.h"
#include "tests/cuda/engine/gpu_fixture.h"
#include "tests/losses/disc.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/row_readout.h"

namespace drape {
namespace {

using test::RelativeError;

// Batches of a size, one fabric per rollout, random starts; both cameras, each with its own centre.
class DeviceLossesTest : public testing::TestWithParam<std::tuple<int, int, CameraKind>> {
 protected:
  void SetUp() override {
    DRAPE_NEEDS_GPU();
    device_ = MakeCudaBackend(model_, 1);
    const int count = std::get<1>(GetParam());
    std::mt19937_64 random(17);
    for (int i = 0; i < count; ++i) {
      fields_.push_back(test::TestMaterial(1.0 + 0.1 * i));
      if (i % 3 == 1) fields_.back() = test::Scatter(fields_.back(), model_->mesh, 0.2, random);
      starts_.push_back(model_->RestState());
      starts_.back().x = ApplyStartShape(model_->mesh, 0.09, RandomStartShape(i, 5e-3));
      cameras_.emplace_back().kind = std::get<2>(GetParam());
      cameras_.back().cx += 0.37 * i;
    }
    for (int i = 0; i < count; ++i) {
      inputs_.push_back({&fields_[i], &starts_[i]});
      weights_.push_back(&fields_[i]);
    }
  }
  // A rollout that fails among the others.
  void Spoil(std::size_t i) {
    if (i < starts_.size()) starts_[i].x[0] = std::numeric_limits<double>::quiet_NaN();
  }
  // Targets of two values, shared by the rollouts of each.
  ReadoutLoss MakeLoss(const Readout& readout, double a, double b, double sigma) {
    targets_ = {Eigen::VectorXd::Constant(readout.size(), a),
                Eigen::VectorXd::Constant(readout.size(), b)};
    ReadoutLoss loss{&readout, {}, sigma};
    for (std::size_t i = 0; i < inputs_.size(); ++i) loss.targets.push_back(&targets_[i % 2]);
    return loss;
  }
  void ExpectEqualLosses(const ReadoutLoss& loss, std::size_t spoilt, double tolerance) {
    const auto found = device_->LossGradients(inputs_, options_, loss);
    const auto again = device_->LossGradients(inputs_, options_, loss);
    const auto expected = host_->LossGradients(inputs_, options_, loss);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      EXPECT_EQ(found[i].status, expected[i].status) << i;
      ASSERT_EQ(found[i].loss.has_value(), expected[i].loss.has_value()) << i;
      EXPECT_EQ(found[i].loss.has_value(), i != spoilt) << i;
      if (!found[i].loss) continue;
      EXPECT_NEAR(*found[i].loss, *expected[i].loss, 1e-8 * *expected[i].loss) << i;
      EXPECT_LT(RelativeError(found[i].material.stretch, expected[i].material.stretch), tolerance);
      EXPECT_LT(RelativeError(found[i].material.bend, expected[i].material.bend), tolerance) << i;
      EXPECT_EQ(*again[i].loss, *found[i].loss) << i;
      EXPECT_EQ(again[i].material.stretch, found[i].material.stretch) << i;
      EXPECT_EQ(again[i].material.bend, found[i].material.bend) << i;
    }
  }

  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", std::get<0>(GetParam()));
  std::unique_ptr<Backend> device_, host_ = MakeCpuBackend(model_, 2);
  std::vector<MaterialField> fields_;
  std::vector<State> starts_;
  std::vector<Camera> cameras_;
  std::vector<RolloutInput> inputs_;
  std::vector<const MaterialField*> weights_;
  std::vector<Eigen::VectorXd> targets_;
  RolloutOptions options_{.h = 0.05, .steps = 12};
};

TEST_P(DeviceLossesTest, OutlineTangentsAreEquivalentToReference) {
  Spoil(2);
  const OutlineReadout readout(model_->mesh, cameras_, 73);
  const auto found = device_->ReadoutTangents(inputs_, weights_, options_, readout);
  const auto again = device_->ReadoutTangents(inputs_, weights_, options_, readout);
  const auto expected = host_->ReadoutTangents(inputs_, weights_, options_, readout);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(found[i].rollout.status, expected[i].rollout.status) << i;
    EXPECT_EQ(found[i].read.r.size(), i == 2 ? 0 : 73) << i;
    EXPECT_LT(RelativeError(found[i].read.r, expected[i].read.r), 1e-9) << i;
    EXPECT_LT(RelativeError(found[i].read.dr, expected[i].read.dr), 1e-8) << i;
    EXPECT_EQ(again[i].read.r, found[i].read.r) << i;
    EXPECT_EQ(again[i].read.dr, found[i].read.dr) << i;
  }
}

TEST_P(DeviceLossesTest, OutlinesWithAMissingAngleAreNotRead) {
  for (Camera& camera : cameras_) camera.kind = CameraKind::kOrthographic;
  starts_[0].x.array() += 1.0;  // beside the axis
  const OutlineReadout readout(model_->mesh, cameras_, 36);
  const auto found = device_->ReadoutTangents(inputs_, weights_, {.h = 0.05, .steps = 0}, readout);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(found[i].rollout.status, RolloutStatus::kOk);
    EXPECT_EQ(found[i].read.r.size(), i == 0 ? 0 : 36) << i;
  }
}

TEST_P(DeviceLossesTest, LossGradientsAreEquivalentToReference) {
  Spoil(2);
  const OutlineReadout outline(model_->mesh, cameras_, 73);
  ExpectEqualLosses(MakeLoss(outline, 90.0, 101.0, 2.0), 2, 1e-7);
  const SilhouetteReadout silhouette(model_->mesh, cameras_, {1.5});
  ExpectEqualLosses(MakeLoss(silhouette, 0.3, 0.6, 0.5), 2, 1e-7);
}

// More crossings than a slot has room for, in the first shape of the larger discs.
TEST_P(DeviceLossesTest, CrumpledClothIsReadOnTheHost) {
  starts_[0].x += 2e-2 * RandomVector(model_->num_dofs(), 9);
  options_.steps = 0;
  const SilhouetteReadout silhouette(model_->mesh, cameras_, {1.5});
  ExpectEqualLosses(MakeLoss(silhouette, 0.3, 0.6, 0.5), inputs_.size(), 1e-7);
}

TEST_P(DeviceLossesTest, OtherReadoutsAreReadOnTheHost) {
  const OutlineReadout outline(model_->mesh, cameras_, 36);
  const test::HostReadout readout(outline);
  ExpectEqualLosses(MakeLoss(readout, 90.0, 101.0, 2.0), inputs_.size(), 1e-7);
}

TEST_P(DeviceLossesTest, ReadoutsOfEquilibriaAreEquivalentToReference) {
  const auto relaxed = host_->Rollouts(inputs_, {.h = 0.1, .steps = 40}, nullptr);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    starts_[i] = relaxed[i].end;
    const auto rest = host_->Equilibria({&inputs_[i], 1}, {});
    starts_[i].x = rest[0].x;
  }
  const OutlineReadout readout(model_->mesh, cameras_, 36);
  const auto found = device_->EquilibriumReadoutTangents(inputs_, weights_, readout);
  const auto expected = host_->EquilibriumReadoutTangents(inputs_, weights_, readout);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_LT(RelativeError(found[i].r, expected[i].r), 1e-10) << i;
    EXPECT_LT(RelativeError(found[i].dr, expected[i].dr), 1e-7) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Batches, DeviceLossesTest,
                         testing::Values(std::tuple(297, 1, CameraKind::kOrthographic),
                                         std::tuple(297, 5, CameraKind::kPinhole),
                                         std::tuple(131, 33, CameraKind::kOrthographic),
                                         std::tuple(131, 5, CameraKind::kOrthographic)));

// Shapes given outright, folds that hang over the hem among them, straight to the kernels.
class DeviceSilhouettesTest : public testing::TestWithParam<CameraKind> {
 protected:
  void SetUp() override {
    DRAPE_NEEDS_GPU();
    const int shared_bytes = FindDevices().at(0).shared_bytes;
    cloth_ = std::make_unique<DeviceCloth>(
        model_, MakeFrontPlan(model_->pattern, model_->mesh.uv, {.shared_bytes = shared_bytes}),
        shared_bytes);
    const int dofs = model_->num_dofs();
    std::vector<double> x(kSlots * dofs);
    for (int s = 0; s < kSlots; ++s) {
      const DrapeShape shape{.folds = 4 + s, .amplitude = 0.2, .twist = 0.15 * s};
      const double noise = s == kCrumpled ? 3e-2 : 1e-3;
      shapes_.push_back(Deform(model_->mesh, shape) + noise * RandomVector(dofs, 5 + s));
      if (s == kBad) shapes_[s][7] = std::numeric_limits<double>::infinity();
      cloth_->ToEliminationOrder(shapes_[s].data(), 1, 1, x.data() + s * dofs);
      cameras_.emplace_back().kind = GetParam();
      cameras_[s].height = 250;
      cameras_[s].cy += 0.21 * s;
      targets_.push_back(0.5 * Eigen::VectorXd::Ones(256 * 250) +
                         0.2 * RandomVector(256 * 250, 40 + s));
    }
    x_ = DeviceBuffer<double>(x);
  }
  ShapesToRead Shapes(const Readout& readout) const {
    ShapesToRead shapes{cloth_.get(), x_.data(), {}};
    for (int s = 0; s < kSlots; ++s) shapes.readouts.push_back(readout.device(s));
    return shapes;
  }
  std::vector<const Eigen::VectorXd*> Targets() const {
    std::vector<const Eigen::VectorXd*> targets;
    for (const Eigen::VectorXd& target : targets_) targets.push_back(&target);
    return targets;
  }
  Eigen::VectorXd LossDerivative(DeviceLosses& losses, int slot) const {
    std::vector<double> dL_dx(model_->num_dofs());
    CopyToHost<double>(losses.dL_dx(slot), dL_dx);
    Eigen::VectorXd result(dL_dx.size());
    cloth_->ToMeshOrder(dL_dx.data(), 1, 1, result.data());
    return result;
  }

  static constexpr int kSlots = 6, kBad = 3, kCrumpled = 5;
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 601);
  std::unique_ptr<DeviceCloth> cloth_;
  std::vector<Eigen::VectorXd> shapes_, targets_;
  std::vector<Camera> cameras_;
  DeviceBuffer<double> x_;
};

TEST_P(DeviceSilhouettesTest, IsEquivalentToReferencePixelByPixel) {
  const SilhouetteReadout readout(model_->mesh, cameras_, {1.5});
  const ShapesToRead shapes = Shapes(readout);
  const auto targets = Targets();
  DeviceLosses losses(shapes, targets, 0.4), again(shapes, targets, 0.4);
  const DeviceSilhouettes found(shapes, &losses, nullptr);
  const DeviceSilhouettes repeated(shapes, &again, nullptr);
  int cuts = 0;
  for (int s = 0; s < kSlots; ++s) {
    ASSERT_EQ(found.Status()[s], s == kBad ? kUnreadable : s == kCrumpled ? kNoRoom : kRead);
    EXPECT_EQ(losses.Download()[s], again.Download()[s]) << s;
    EXPECT_EQ(LossDerivative(losses, s), LossDerivative(again, s)) << s;
    if (found.Status()[s] != kRead) {
      EXPECT_EQ(LossDerivative(losses, s).norm(), 0.0);
      continue;
    }
    SoftSilhouette soft;
    ASSERT_TRUE(RenderSoft(model_->mesh, shapes_[s], cameras_[s], {1.5}, &soft));
    const std::vector<double> coverage = found.Coverage(s);
    EXPECT_EQ(coverage, repeated.Coverage(s)) << s;
    const Eigen::Map<const Eigen::VectorXd> pixels(coverage.data(), coverage.size());
    EXPECT_LT((pixels - soft.coverage).cwiseAbs().maxCoeff(), 1e-9) << s;
    const Eigen::VectorXd residual = (soft.coverage - targets_[s]) / 0.4;
    EXPECT_NEAR(losses.Download()[s], 0.5 * residual.squaredNorm(), 1e-9 * residual.squaredNorm());
    Eigen::VectorXd dL_dx = Eigen::VectorXd::Zero(model_->num_dofs());
    AdjRenderSoft(soft, shapes_[s], cameras_[s], residual / 0.4, &dL_dx);
    EXPECT_LT(RelativeError(LossDerivative(losses, s), dL_dx), 1e-9) << s;
    Eigen::Matrix2Xd points;
    ASSERT_TRUE(ProjectVertices(shapes_[s], cameras_[s], &points));
    EXPECT_EQ(found.Cuts(s), 2 * FindSilhouetteEdges(model_->mesh, points).crossings.size());
    cuts += found.Cuts(s);
  }
  EXPECT_GT(cuts, 100);  // folds do cover folds here
}

INSTANTIATE_TEST_SUITE_P(Cameras, DeviceSilhouettesTest,
                         testing::Values(CameraKind::kOrthographic, CameraKind::kPinhole));

}  // namespace
}  // namespace drape
