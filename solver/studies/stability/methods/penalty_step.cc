// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/methods/penalty_step.h"

#include <algorithm>
#include <utility>

#include "physics/simulation/rollout.h"

namespace drape {
namespace {

// The velocity of a vertex after the springs of one step of h; omega2: their stiffness by mass.
Eigen::Vector3d Pushed(const Contact& contact, const PenaltyOptions& options, double omega2,
                       const Eigen::Vector3d& x, Eigen::Vector3d v, double h) {
  for (const Obstacle& obstacle : contact.obstacles) {
    const ObstacleDistance distance = DistanceTo(obstacle, x);
    const double depth = contact.offset() - distance.value;
    if (depth <= 0.0) continue;
    const double normal = v.dot(distance.normal);
    const double push = std::max(
        0.0, (normal + h * omega2 * depth) / (1.0 + h * h * omega2) - normal);  // implicit Euler
    Eigen::Vector3d slip = v - normal * distance.normal;
    const double speed = slip.norm(), loss = options.friction * push;
    slip *= speed > loss ? 1.0 - loss / speed : 0.0;
    v = slip + (normal + push) * distance.normal;
  }
  return v;
}

class PenaltyStep final : public Integrator {
 public:
  PenaltyStep(const std::shared_ptr<const ClothModel>& model, const MaterialField& material,
              double h, const Contact* contact, const PenaltyOptions& options)
      : material_(material),
        h_(h),
        mass_(model->LumpedMass(material.density)),
        contact_(contact),
        options_(options),
        solver_(model) {}

  IntegratorStatus Advance(State& state) override {
    const Eigen::VectorXd before = state.x;
    const RolloutStatus status = AdvanceOneStep(solver_, material_, mass_, h_, state);
    if (status == RolloutStatus::kNotPositiveDefinite)
      return IntegratorStatus::kNotPositiveDefinite;
    if (status != RolloutStatus::kOk) return IntegratorStatus::kNotFinite;
    for (Eigen::Index i = 0; i < before.size(); i += 3)
      state.v.segment<3>(i) = Pushed(*contact_, options_, options_.stiffness / material_.density,
                                     before.segment<3>(i), state.v.segment<3>(i), h_);
    state.x = before + h_ * state.v;
    return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
  }

 private:
  MaterialField material_;
  double h_;
  Eigen::VectorXd mass_;
  const Contact* contact_;
  PenaltyOptions options_;
  StepSolver solver_;
};

}  // namespace

std::unique_ptr<Integrator> MakePenaltyStep(std::shared_ptr<const ClothModel> model,
                                            const MaterialField& material, double h,
                                            const Contact* contact, const PenaltyOptions& options) {
  return std::make_unique<PenaltyStep>(model, material, h, contact, options);
}

}  // namespace drape
