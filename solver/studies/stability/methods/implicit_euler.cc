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

  IntegratorStatus Advance(State& state) override { return euler_.Advance(state); }

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
