// SPDX-License-Identifier: Apache-2.0
// Losses of images through the rollout: exact gradients against differences of the whole.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <thread>

#include "losses/outline/shape_features.h"
#include "losses/readout/readouts.h"
#include "physics/cloth/start_shape.h"
#include "physics/simulation/backend.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// Finds nothing at any shape, and notes on which threads.
class NotingReadout final : public Readout {
 public:
  int size() const override { return 1; }
  bool Read(std::size_t, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard lock(mutex_);
    threads_.insert(std::this_thread::get_id());
    *r = Eigen::VectorXd::Zero(1);
    if (dr_dx != nullptr) dr_dx->resize(1, x.size());
    return true;
  }
  int TakeThreads() {
    const int count = static_cast<int>(threads_.size());
    threads_.clear();
    return count;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::set<std::thread::id> threads_;
};

class LossGradientTest : public testing::Test {
 protected:
  LossGradientTest() {
    start_.x = ApplyStartShape(model_->mesh, DrapeDiscs().support, RandomStartShape(3, 3e-3));
    camera_.cx += 0.3;
  }
  LossGradient At(const MaterialField& material, const ReadoutLoss& loss) const {
    const RolloutInput input{&material, &start_};
    return MakeCpuBackend(model_, 1)->LossGradients({&input, 1}, {.h = 0.05, .steps = steps_},
                                                    loss)[0];
  }
  // Along the logarithms of all entries. Truncation falls with h, rounding and the kinks of pixels
  // that change their nearest edge do not.
  void ExpectGradient(const ReadoutLoss& loss, double tolerance) const {
    const MaterialField material = test::TestMaterial();
    const LossGradient exact = At(material, loss);
    ASSERT_TRUE(exact.loss.has_value());
    const double along = exact.material.Contract(material).sum();
    double best = 1.0;
    for (const double h : {1e-3, 1e-4, 1e-5, 1e-6}) {
      MaterialField up = material, down = material;
      for (StretchTable& t : up.stretch)
        for (auto& row : t.c)
          for (double& c : row) c *= 1 + h;
      for (BendTable& t : up.bend)
        for (auto& row : t.b)
          for (double& b : row) b *= 1 + h;
      for (StretchTable& t : down.stretch)
        for (auto& row : t.c)
          for (double& c : row) c *= 1 - h;
      for (BendTable& t : down.bend)
        for (auto& row : t.b)
          for (double& b : row) b *= 1 - h;
      const double difference = (*At(up, loss).loss - *At(down, loss).loss) / (2 * h);
      best = std::min(best, std::abs(difference - along) / std::abs(along));
    }
    EXPECT_LT(best, tolerance);
  }

  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 150);
  State start_ = model_->RestState();
  Camera camera_;
  int steps_ = 12;
};

TEST_F(LossGradientTest, ReadsOnTheThreadsOfItsBackend) {
  const MaterialField material = test::TestMaterial();
  const std::vector<RolloutInput> batch(16, {&material, &start_});
  const std::vector<const MaterialField*> weights(batch.size(), &material);
  const Eigen::VectorXd target = Eigen::VectorXd::Zero(1);
  NotingReadout readout;
  const ReadoutLoss loss{&readout, std::vector<const Eigen::VectorXd*>(batch.size(), &target)};
  const RolloutOptions once{.h = 0.05, .steps = 1};
  for (const int threads : {1, 2}) {
    const auto backend = MakeCpuBackend(model_, threads);
    backend->LossGradients(batch, once, loss);
    EXPECT_EQ(readout.TakeThreads(), threads);
    backend->ReadoutTangents(batch, weights, once, readout);
    EXPECT_EQ(readout.TakeThreads(), threads);
    backend->EquilibriumReadoutTangents(batch, weights, readout);
    EXPECT_LE(readout.TakeThreads(), threads);
  }
}

TEST_F(LossGradientTest, OfTheOutline) {
  const OutlineReadout readout(model_->mesh, {camera_}, 72);
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 100.0);
  ExpectGradient({&readout, {&target}, 2.0}, 1e-6);
}

TEST_F(LossGradientTest, OfTheSoftSilhouette) {
  const SilhouetteReadout readout(model_->mesh, {camera_}, {2.0});
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 0.4);
  ExpectGradient({&readout, {&target}, 0.5}, 1e-5);
}

TEST_F(LossGradientTest, NoneWhereTheShapeCannotBeRead) {
  steps_ = 0;
  start_.x.array() += 2.0;  // the cloth lies beside the axis
  const OutlineReadout readout(model_->mesh, {camera_}, 36);
  const Eigen::VectorXd target = Eigen::VectorXd::Zero(36);
  const LossGradient found = At(test::TestMaterial(), {&readout, {&target}, 1.0});
  EXPECT_EQ(found.status, RolloutStatus::kOk);
  EXPECT_FALSE(found.loss.has_value());
  EXPECT_EQ(found.material.stretch.size(), 0);
}

}  // namespace
}  // namespace drape
