// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/implicit_euler.h"

#include <utility>

#include "solver/studies/stability/methods/integrator.h"

namespace drape {
namespace {

class ImplicitEulerIntegrator final : public Integrator {
 public:
  ImplicitEulerIntegrator(std::shared_ptr<const ClothModel> model, const MaterialField& material,
                          double h, const ImplicitEulerOptions& options)
      : euler_(std::move(model), material, h, options) {}

  IntegratorStatus Advance(State& state) override {
    switch (euler_.Advance(state)) {
      case ImplicitEulerStatus::kOk:
        return IntegratorStatus::kOk;
      case ImplicitEulerStatus::kNotPositiveDefinite:
        return IntegratorStatus::kNotPositiveDefinite;
      case ImplicitEulerStatus::kNotConverged:
        return IntegratorStatus::kNotConverged;
      case ImplicitEulerStatus::kNotFinite:
        return IntegratorStatus::kNotFinite;
    }
    return IntegratorStatus::kNotFinite;
  }

 private:
  ImplicitEuler euler_;
};

}  // namespace

std::unique_ptr<Integrator> MakeImplicitEuler(std::shared_ptr<const ClothModel> model,
                                              const MaterialField& material, double h,
                                              const ImplicitEulerOptions& options) {
  return std::make_unique<ImplicitEulerIntegrator>(std::move(model), material, h, options);
}

}  // namespace drape
