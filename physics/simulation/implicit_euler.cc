// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/implicit_euler.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/contact/barrier.h"
#include "physics/simulation/statics/statics.h"

namespace drape {
namespace {

// Above ω² of any cloth, needles of 1 : 1000 included, so that it is reached by no shape but one
// that is lost.
constexpr double kMostShift = 1e13;  // [s⁻²]

ImplicitEulerFailure FindWorst(const Eigen::VectorXd& x, const Eigen::VectorXd& unbalanced) {
  ImplicitEulerFailure worst;
  double most = -1.0;
  for (int i = 0; 3 * i < x.size() && std::isfinite(most); ++i) {
    const double force = unbalanced.segment<3>(3 * i).norm();
    if (force <= most) continue;
    most = force;
    worst = {.vertex = i, .place = x.segment<3>(3 * i)};
  }
  return worst;
}

}  // namespace

ImplicitEuler::ImplicitEuler(std::shared_ptr<const ClothModel> model, const MaterialField& material,
                             double h, const ImplicitEulerOptions& options)
    : material_(material),
      h_(h),
      options_(options),
      solver_(std::move(model)),
      stiffness_(solver_, material_),
      mass_by_h2_(solver_.model().LumpedMass(material.density) / (h * h)),
      weight_(CharacteristicForce(solver_.model(), material)) {
  CHECK_GT(h, 0.0);
  CHECK_GT(options.creep_speed, 0.0);
}

const Contact* ImplicitEuler::contact() const {
  if (around_.contact != nullptr) return around_.contact;
  const std::optional<Contact>& of_scene = solver_.model().scene.contact;
  return of_scene ? &*of_scene : nullptr;
}

IntegratorStatus ImplicitEuler::Advance(State& state, const Surroundings& around) {
  around_ = around;
  CHECK(around.contact == nullptr || !solver_.model().scene.contact) << "contact twice";
  coasted_ = state.x + h_ * state.v;
  cost_ = {};
  failure_ = {};
  Eigen::VectorXd start = state.x;
  if (contact() != nullptr) {
    PushOut(*contact(), start);
    clearance_ = Clearance(*contact(), start);
  }
  rubs_.clear();
  const bool rubs = contact() != nullptr && options_.friction > 0.0;
  if (rubs) FindRubs(state.x, start);
  Trial here = At(start);
  for (;;) {
    if (const IntegratorStatus status = Minimise(here); status != IntegratorStatus::kOk) {
      failure_ = FindWorst(here.x, here.unbalanced);
      return status;
    }
    ++cost_.friction_rounds;
    if (!rubs || cost_.friction_rounds == options_.friction_rounds ||
        FindRubs(state.x, here.x) < options_.friction_change)
      break;
    here = At(here.x);
  }
  state.v = (here.x - state.x) / h_;
  state.x = here.x;
  return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
}

IntegratorStatus ImplicitEuler::Minimise(Trial& here) {
  constexpr int kMostRises = 20;
  double least = here.residual;
  int rises = 0;  // of the potential
  // A force that is not a number is not in balance.
  for (int i = 0; !(here.residual <= options_.tolerance); ++i) {
    if (!std::isfinite(here.residual)) return IntegratorStatus::kNotFinite;
    if (i == options_.max_iterations) return IntegratorStatus::kNotConverged;
    if (!Factor(here.x)) return IntegratorStatus::kNotPositiveDefinite;
    Eigen::VectorXd dx = here.unbalanced;
    solver_.linear().Solve(dx);
    ++cost_.newton_steps;
    const double potential = here.potential;
    if (!Backtrack(dx, rises < kMostRises ? here.residual : least, here))
      return IntegratorStatus::kNotConverged;
    least = std::min(least, here.residual);
    rises += here.potential >= potential;
    if (options_.on_accept) options_.on_accept(here.x);
  }
  return IntegratorStatus::kOk;
}

ImplicitEuler::Trial ImplicitEuler::At(const Eigen::VectorXd& x) const {
  Trial trial{.x = x, .unbalanced = {}};
  AssembleForce(solver_.model(), material_, x, trial.unbalanced);
  const Eigen::VectorXd inertia = mass_by_h2_.cwiseProduct(x - coasted_);
  trial.unbalanced -= inertia;
  trial.potential = Energy(solver_.model(), material_, x) + 0.5 * inertia.dot(x - coasted_);
  AddSurroundings(trial);
  trial.residual = trial.unbalanced.norm() / weight_;
  return trial;
}

void ImplicitEuler::AddSurroundings(Trial& trial) const {
  const ClothModel& model = solver_.model();
  if (around_.contact != nullptr)
    for (int i = 0; i < model.mesh.num_vertices(); ++i) {
      const Eigen::Vector3d x = trial.x.segment<3>(3 * i);
      if (!clearance_.MayTouch(i, x)) continue;
      trial.unbalanced.segment<3>(3 * i) += ContactForce(*around_.contact, model.vertex_area[i], x);
      trial.potential += ContactEnergy(*around_.contact, model.vertex_area[i], x);
    }
  for (const Pin& pin : around_.pins) {
    const Eigen::Vector3d away = trial.x.segment<3>(3 * pin.vertex) - pin.place;
    trial.unbalanced.segment<3>(3 * pin.vertex) -= pin.stiffness * away;
    trial.potential += 0.5 * pin.stiffness * away.squaredNorm();
  }
  for (const Rub& rub : rubs_) {
    const RubForce rubbing = Rubbing(rub, trial.x.segment<3>(3 * rub.vertex));
    trial.unbalanced.segment<3>(3 * rub.vertex) += rubbing.force;
    trial.potential += rubbing.potential;
  }
}

// M/h² + K or, where that is not positive definite, with a larger multiple of M.
bool ImplicitEuler::Factor(const Eigen::VectorXd& x) {
  const ClothModel& model = solver_.model();
  stiffness_.Assemble(x);
  if (around_.contact != nullptr)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      if (clearance_.MayTouch(i, x.segment<3>(3 * i)))
        stiffness_.AddDiagonal(
            i, ContactStepStiffness(*around_.contact, model.vertex_area[i], x.segment<3>(3 * i)));
  for (const Pin& pin : around_.pins)
    stiffness_.AddDiagonal(pin.vertex, pin.stiffness * Eigen::Matrix3d::Identity());
  for (const Rub& rub : rubs_)
    stiffness_.AddDiagonal(rub.vertex, Rubbing(rub, x.segment<3>(3 * rub.vertex)).stiffness);
  double mu = 1.0 / (h_ * h_);
  return stiffness_.FactorShifted(0.0, &mu, [](double failed) {
    return 4.0 * failed > kMostShift ? std::nullopt : std::optional(4.0 * failed);
  });
}

// Halves the step until it lowers the potential, or the residual by a tenth: near the end the
// potential is rounded, and nonlinear tables have none. The same shapes could so be visited again
// and again, which is why the residual to be lowered is in the end the least so far. Each vertex
// goes as far as obstacles let it: a step so short that none is in the way has the direction of
// Newton's.
bool ImplicitEuler::Backtrack(const Eigen::VectorXd& dx, double residual, Trial& here) const {
  double length = 1.0;
  for (int k = 0; k <= options_.max_halvings; ++k, length *= 0.5) {
    Eigen::VectorXd moves = length * dx;
    if (contact() != nullptr) clearance_.ShortenMoves(here.x, moves);
    Trial next = At(here.x + moves);
    const bool better = next.potential < here.potential || next.residual < 0.9 * residual;
    if (!better || !std::isfinite(next.residual)) continue;
    here = std::move(next);
    return true;
  }
  return false;
}

ImplicitEuler::RubForce ImplicitEuler::Rubbing(const Rub& rub, const Eigen::Vector3d& x) const {
  const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - rub.normal * rub.normal.transpose();
  const Eigen::Vector3d slip = along * (x - rub.start);
  const double limit = options_.friction * rub.normal_force;  // [N]
  const double speed = slip.norm() / h_, creep = options_.creep_speed;
  if (speed < creep) {
    const double slope = (2.0 - speed / creep) / (creep * h_);  // of the force by the slip
    const Eigen::Vector3d direction = slip / std::max(slip.norm(), 1e-300);
    return {.potential = limit * h_ * speed * speed / creep * (1.0 - speed / (3.0 * creep)),
            .force = -limit * slope * slip,
            .stiffness = limit * (slope * along - speed / (creep * creep * h_) * direction *
                                                      direction.transpose())};
  }
  const Eigen::Vector3d direction = slip / slip.norm();
  return {.potential = limit * h_ * (speed - creep / 3.0),
          .force = -limit * direction,
          .stiffness = limit / slip.norm() * (along - direction * direction.transpose())};
}

double ImplicitEuler::FindRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x) {
  const ClothModel& model = solver_.model();
  std::vector<double> old(model.mesh.num_vertices(), 0.0), now = old;
  for (const Rub& rub : rubs_) old[rub.vertex] += rub.normal_force;
  rubs_.clear();
  for (int i = 0; i < model.mesh.num_vertices(); ++i) {
    const Eigen::Vector3d here = x.segment<3>(3 * i);
    if (!clearance_.MayTouch(i, here)) continue;
    for (const Obstacle& obstacle : contact()->obstacles) {
      const ObstacleDistance distance = DistanceTo(obstacle, here);
      const double gap = distance.value - 0.5 * contact()->thickness;
      if (gap >= contact()->range) continue;
      const double force = -contact()->stiffness * model.vertex_area[i] *
                           EvaluateBarrier(gap, contact()->range).slope * distance.normal.norm();
      rubs_.push_back({.vertex = i,
                       .normal_force = force,
                       .normal = distance.normal.normalized(),
                       .start = before.segment<3>(3 * i) + SurfaceMove(obstacle, here)});
      now[i] += force;
    }
  }
  double sum = 0.0, change = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    sum += now[i];
    change += std::abs(now[i] - old[i]);
  }
  return sum > 0.0 ? change / sum : 0.0;
}

}  // namespace drape
