// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "solver/studies/stability/methods/integrator.h"

namespace drape {
namespace {

class ExplicitEuler final : public Integrator {
 public:
  ExplicitEuler(std::shared_ptr<const ClothModel> model, const MaterialField& material, double h,
                double drag)
      : model_(std::move(model)),
        material_(material),
        h_(h),
        slowing_(1.0 / (1.0 + h * drag)),
        inverse_mass_(model_->LumpedMass(material.density).cwiseInverse()) {
    CHECK_GT(h, 0.0);
    CHECK_GE(drag, 0.0);
  }

  IntegratorStatus Advance(State& state) override {
    AssembleForce(*model_, material_, state.x, force_);
    state.v = slowing_ * (state.v + h_ * inverse_mass_.cwiseProduct(force_));
    state.x += h_ * state.v;
    return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
  }

 private:
  std::shared_ptr<const ClothModel> model_;
  MaterialField material_;
  double h_, slowing_;
  Eigen::VectorXd inverse_mass_, force_;
};

}  // namespace

std::unique_ptr<Integrator> MakeExplicitEuler(std::shared_ptr<const ClothModel> model,
                                              const MaterialField& material, double h,
                                              double drag) {
  return std::make_unique<ExplicitEuler>(std::move(model), material, h, drag);
}

}  // namespace drape
