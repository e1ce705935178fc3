// SPDX-License-Identifier: Apache-2.0
// Losses of images through the rollout: exact gradients against differences of the whole.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "losses/outline/outline.h"
#include "losses/readout/readouts.h"
#include "physics/cloth/state.h"
#include "physics/simulation/backend.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// L = ½ Σ_k ((r_k − target_k)/sigma)² of the numbers that `readout` finds at the end of a rollout.
struct Loss {
  const Readout& readout;
  Eigen::VectorXd target;
  double sigma;
};
struct LossGradient {
  double loss = 0.0;
  MaterialGradient material;
};

class LossGradientTest : public testing::Test {
 protected:
  LossGradientTest() {
    start_.x = ApplyStartShape(model_->mesh, DrapeDiscs().support, RandomStartShape(3, 3e-3));
    camera_.cx += 0.3;
  }
  LossGradient At(const MaterialField& material, const Loss& loss) const {
    const RolloutInput input{&material, &start_};
    const RolloutOptions options{.h = 0.05, .steps = 12};
    const auto backend = MakeCpuBackend(model_, 1);
    std::vector<Recording> recordings;
    const RolloutResult rollout = backend->Rollouts({&input, 1}, options, &recordings)[0];
    Eigen::VectorXd r;
    ReadoutJacobian dr_dx;
    EXPECT_EQ(rollout.status, RolloutStatus::kOk);
    EXPECT_TRUE(loss.readout.Read(0, rollout.end.x, &r, &dr_dx));
    const Eigen::VectorXd residual = (r - loss.target) / loss.sigma;
    const RowMatrix dL_dx = dr_dx.transpose() * (residual / loss.sigma);
    const auto adjoint = backend->Adjoints({&input, 1}, recordings, {&dL_dx, 1}, options)[0];
    return {0.5 * residual.squaredNorm(), adjoint.material};
  }
  // Along the logarithms of all entries. Truncation falls with h, rounding and the kinks of pixels
  // that change their nearest edge do not.
  void ExpectGradient(const Loss& loss, double tolerance) const {
    const MaterialField material = test::TestMaterial();
    const LossGradient exact = At(material, loss);
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
      const double difference = (At(up, loss).loss - At(down, loss).loss) / (2 * h);
      best = std::min(best, std::abs(difference - along) / std::abs(along));
    }
    EXPECT_LT(best, tolerance);
  }

  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 150);
  State start_ = model_->RestState();
  Camera camera_;
};

TEST_F(LossGradientTest, OfTheOutline) {
  const OutlineReadout readout(model_->mesh, {camera_}, 72);
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 100.0);
  ExpectGradient({readout, target, 2.0}, 1e-6);
}

TEST_F(LossGradientTest, OfTheSoftSilhouette) {
  const SilhouetteReadout readout(model_->mesh, {camera_}, {2.0});
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 0.4);
  ExpectGradient({readout, target, 0.5}, 1e-5);
}

}  // namespace
}  // namespace drape
