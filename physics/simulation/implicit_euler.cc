// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/implicit_euler.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/simulation/statics/statics.h"

namespace drape {
namespace {

// Above ω² of any cloth, needles of 1 : 1000 included, so that it is reached by no shape but one
// that is lost.
constexpr double kMostShift = 1e13;  // [s⁻²]
// A round is solved to this share of its first residual if another round follows.
constexpr double kEarlyShare = 0.1;
// The largest multiple of M/h² after a step that was slow.
constexpr double kSlowShift = 64.0;
// Newton steps without a trial of M/h² + K, at most: where it was not positive definite it often is
// not so in the next step either.
constexpr int kMostWaits = 3;

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
    : model_(std::move(model)),
      material_(material),
      h_(h),
      options_(options),
      mass_by_h2_(model_->LumpedMass(material.density) / (h * h)),
      weight_(CharacteristicForce(*model_, material)) {
  CHECK_GT(h, 0.0);
  CHECK_GT(options.creep_speed, 0.0);
  CHECK(!HasSelfContact(model_->scene)) << "self-contact is one of the options";
  CHECK(!material.dynamics.Acts()) << "damping and air are in linearly implicit steps only";
  if (options_.linear_solver == nullptr) options_.linear_solver = MakeLinearSolver(model_->pattern);
  linear_ = std::make_unique<Linear>(model_, material_, options_.linear_solver->Clone(),
                                     options_.threads);
  if (options.self_contact)
    surfaces_.emplace(model_->mesh, model_->vertex_area, options.self_contact);
}

const Contact* ImplicitEuler::contact() const {
  if (around_.contact != nullptr) return around_.contact;
  const std::optional<Contact>& of_scene = model_->scene.contact;
  return of_scene ? &*of_scene : nullptr;
}

IntegratorStatus ImplicitEuler::Advance(State& state, const Surroundings& around) {
  around_ = around;
  CHECK(around.contact == nullptr || !model_->scene.contact) << "contact twice";
  coasted_ = state.x + h_ * state.v;
  cost_ = {};
  failure_ = {};
  rubs_.clear();
  SetObstacles();
  Eigen::VectorXd start;
  if (const IntegratorStatus status = Start(state.x, start); status != IntegratorStatus::kOk)
    return status;
  const bool rubs = (contact() != nullptr && options_.friction > 0.0) ||
                    (surfaces_ && options_.self_friction > 0.0);
  if (rubs) FindRubs(state.x, start);
  Trial here = At(start);
  for (bool last = !rubs;;) {
    last = last || cost_.friction_rounds + 1 == options_.friction_rounds;
    const double enough =
        last ? options_.tolerance : std::max(options_.tolerance, kEarlyShare * here.residual);
    if (const IntegratorStatus status = Minimise(enough, here); status != IntegratorStatus::kOk) {
      failure_ = FindWorst(here.x, here.unbalanced);
      return status;
    }
    ++cost_.friction_rounds;
    if (last) break;
    last = FindRubs(state.x, here.x) < options_.friction_change;
    if (last && here.residual <= options_.tolerance) break;
    here = At(here.x);
  }
  state.v = (here.x - state.x) / h_;
  state.x = here.x;
  return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
}

void ImplicitEuler::SetObstacles() {
  const Contact none, &around = contact() == nullptr ? none : *contact();
  const bool has_meshes =
      std::any_of(around.obstacles.begin(), around.obstacles.end(), [](const Obstacle& obstacle) {
        return std::holds_alternative<std::shared_ptr<const SurfaceObstacle>>(obstacle);
      });
  if (has_meshes && !surfaces_)
    surfaces_.emplace(model_->mesh, model_->vertex_area, options_.self_contact);
  if (!surfaces_) return;
  surfaces_->UseThreads(options_.threads);
  surfaces_->SetObstacles(around);
}

IntegratorStatus ImplicitEuler::Pinched(int vertex, const Eigen::VectorXd& x) {
  failure_ = {.vertex = vertex, .place = x.segment<3>(3 * vertex)};
  return IntegratorStatus::kPinched;
}

// The shape with which Newton's method starts: out of all obstacles. Where layers lie on a moving
// obstacle, the inner one can only leave it if all follow.
IntegratorStatus ImplicitEuler::Start(const Eigen::VectorXd& from, Eigen::VectorXd& start) {
  start = from;
  if (contact() != nullptr) PushOut(*contact(), start, options_.threads);
  if (surfaces_) {
    Eigen::VectorXd moves = start - from;
    if (!IsStepFree(*surfaces_, from, moves)) {
      start = from;
      FollowObstacles(*contact(), start, options_.threads);
      PushOut(*contact(), start, options_.threads);
      moves = start - from;
      if (!surfaces_->HasObstacles())
        LimitStep(*surfaces_, from, moves);
      else if (const std::optional<int> vertex = FindFreeStep(*surfaces_, from, moves))
        return Pinched(*vertex, from);
    }
    start = from + moves;
    if (surfaces_->HasObstacles()) {
      moves = start;
      PushOut(*contact(), moves, options_.threads);
      moves -= start;
      LimitStep(*surfaces_, start, moves);
      start += moves;
    }
  }
  if (contact() == nullptr) return IntegratorStatus::kOk;
  clearance_ = Clearance(*contact(), start, options_.threads);
  if (surfaces_)
    for (int i = 0; i < model_->mesh.num_vertices(); ++i)
      if (!(clearance_.gap(i) > 0.0)) return Pinched(i, start);
  return IntegratorStatus::kOk;
}

IntegratorStatus ImplicitEuler::Minimise(double enough, Trial& here) {
  LastStep last;
  // A force that is not a number is not in balance.
  for (int i = 0; !(here.residual <= enough); ++i) {
    if (!std::isfinite(here.residual)) return IntegratorStatus::kNotFinite;
    if (Cancelled()) return IntegratorStatus::kCancelled;
    if (i == options_.max_iterations) return IntegratorStatus::kNotConverged;
    if (!Factor(here.x, &last)) return IntegratorStatus::kNotPositiveDefinite;
    Eigen::VectorXd dx = here.unbalanced;
    linear_->solver.linear().Solve(dx);
    ++cost_.newton_steps;
    if (!Backtrack(dx, here, &last))
      return Cancelled() ? IntegratorStatus::kCancelled : IntegratorStatus::kNotConverged;
    if (options_.on_accept) options_.on_accept(here.x);
  }
  return IntegratorStatus::kOk;
}

ImplicitEuler::Trial ImplicitEuler::At(const Eigen::VectorXd& x) {
  Trial trial{.x = x, .elastic = {}, .unbalanced = {}};
  AssembleForce(*model_, material_, x, trial.elastic, nullptr, linear_->solver.parts());
  const Eigen::VectorXd inertia = mass_by_h2_.cwiseProduct(x - coasted_);
  trial.unbalanced = trial.elastic - inertia;
  trial.potential = 0.5 * inertia.dot(x - coasted_);
  AddSurroundings(trial);
  trial.residual = trial.unbalanced.norm() / weight_;
  return trial;
}

void ImplicitEuler::AddSurroundings(Trial& trial) {
  if (contact() != nullptr) AddContact(trial);
  if (surfaces_)
    trial.potential += AddPairForces(surfaces_->FindActivePairs(trial.x), trial.unbalanced);
  for (const Pin& pin : around_.pins) {
    const Eigen::Vector3d away = trial.x.segment<3>(3 * pin.vertex) - pin.place;
    trial.unbalanced.segment<3>(3 * pin.vertex) -= pin.stiffness * away;
    trial.potential += 0.5 * pin.stiffness * away.squaredNorm();
  }
  for (const Rub& rub : rubs_) {
    const RubForce rubbing = Rubbing(rub, trial.x);
    for (int k = 0; k < 4; ++k)
      trial.unbalanced.segment<3>(3 * rub.vertex[k]) += rub.weight[k] * rubbing.force;
    trial.potential += rubbing.potential;
  }
}

void ImplicitEuler::AddContact(Trial& trial) const {
  const int vertices = model_->mesh.num_vertices();
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(vertices);
#pragma omp parallel for schedule(dynamic, 64) \
    num_threads(options_.threads) if (options_.threads > 1)
  for (int i = 0; i < vertices; ++i) {
    const Eigen::Vector3d x = trial.x.segment<3>(3 * i);
    if (!clearance_.MayTouch(i, x)) continue;
    const double area = model_->vertex_area[i];
    const Eigen::Vector3d force = ContactForce(*contact(), area, x);
    // The model has the contact of a scene.
    if (around_.contact != nullptr)
      trial.unbalanced.segment<3>(3 * i) += force;
    else
      trial.elastic.segment<3>(3 * i) -= force;
    energy[i] = ContactEnergy(*contact(), area, x);
  }
  for (const double of_vertex : energy) trial.potential += of_vertex;
}

// The blocks of K that are not of the model.
void ImplicitEuler::AddBlocks(const Eigen::VectorXd& x, StiffnessPart part) {
  const auto add = [&](int i, int j, const Eigen::Matrix3d& block) {
    CHECK(linear_->stiffness.AddBlock(i, j, block));
  };
  if (around_.contact != nullptr)
    for (int i = 0; i < model_->mesh.num_vertices(); ++i)
      if (clearance_.MayTouch(i, x.segment<3>(3 * i)))
        add(i, i,
            ContactStepStiffness(*around_.contact, model_->vertex_area[i], x.segment<3>(3 * i)));
  for (const Pin& pin : around_.pins)
    add(pin.vertex, pin.vertex, pin.stiffness * Eigen::Matrix3d::Identity());
  if (surfaces_) ForEachPairStiffness(surfaces_->FindActivePairs(x), part, add);
  for (const Rub& rub : rubs_) {
    const Eigen::Matrix3d stiffness = Rubbing(rub, x).stiffness;
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < 4; ++l)
        if (rub.vertex[k] <= rub.vertex[l] && rub.weight[k] * rub.weight[l] != 0.0)
          add(rub.vertex[k], rub.vertex[l], rub.weight[k] * rub.weight[l] * stiffness);
  }
}

bool ImplicitEuler::HasBlocksOfPairs(const Eigen::VectorXd& x) {
  const BlockPattern& pattern = linear_->solver.model().pattern;
  const ActivePairs& pairs = surfaces_->FindActivePairs(x);
  return std::all_of(pairs.begin(), pairs.end(),
                     [&](const ActivePair& active) {
                       return active.of_obstacle() || pattern.HasAllBlocks(active.pair.vertex);
                     }) &&
         std::all_of(rubs_.begin(), rubs_.end(),
                     [&](const Rub& rub) { return pattern.HasAllBlocks(rub.vertex); });
}

// Analyses a pattern with the blocks of all pairs that are in contact or soon may be.
void ImplicitEuler::Widen(const Eigen::VectorXd& x) {
  std::vector<std::array<int, 4>> groups = surfaces_->ListNear(x);
  for (const Rub& rub : rubs_) groups.push_back(rub.vertex);
  auto wide = std::make_shared<ClothModel>(*model_);
  wide->pattern = AddGroups(model_->pattern, groups);
  std::unique_ptr<LinearSolver> solver = linear_->solver.linear().Adapt(wide->pattern);
  linear_ =
      std::make_unique<Linear>(std::move(wide), material_, std::move(solver), options_.threads);
  ++cost_.analyses;
}

void ImplicitEuler::Assemble(const Eigen::VectorXd& x, StiffnessPart part) {
  if (surfaces_ && !HasBlocksOfPairs(x)) Widen(x);
  if (part == StiffnessPart::kPositive)
    linear_->stiffness.AssemblePositive(x);
  else
    linear_->stiffness.Assemble(x);
  AddBlocks(x, part);
}

// M/h² + K, which converges quadratically, `near` the end; from further off, and where that is not
// positive definite, the positive parts of all forces. A larger multiple of M would slow all of the
// cloth down for the sake of a wrinkle; where a cloth is about to buckle as a whole, so that the
// positive parts converge slowly, it is the better way.
bool ImplicitEuler::Factor(const Eigen::VectorXd& x, LastStep* last) {
  const double own = 1.0 / (h_ * h_), most = last->slow ? kSlowShift * own : own;
  double mu = own;
  if (last->whole && --last->waits < 0) {
    Assemble(x, StiffnessPart::kWhole);
    if (linear_->stiffness.FactorShifted(0.0, &mu, [&](double failed) {
          return 4.0 * failed > most ? std::nullopt : std::optional(4.0 * failed);
        })) {
      last->failures = 0;
      return true;
    }
    last->waits = std::min(++last->failures, kMostWaits);
    mu = own;
  }
  Assemble(x, StiffnessPart::kPositive);
  return linear_->stiffness.FactorShifted(0.0, &mu, [](double failed) {
    return 4.0 * failed > kMostShift ? std::nullopt : std::optional(4.0 * failed);
  });
}

// Halves the step until the forces do work on the way: by the potential of those that have one, by
// the trapezoidal rule for the elastic ones, which have none where tables are not linear. Each
// vertex goes as far as obstacles and other cloth let it: a step so short that none is in the way
// has the direction of Newton's.
bool ImplicitEuler::Backtrack(const Eigen::VectorXd& dx, Trial& here, LastStep* last) {
  constexpr double kRounded = 1e-12;
  double length = 1.0;
  for (int k = 0; k <= options_.max_halvings && !Cancelled(); ++k, length *= 0.5) {
    Eigen::VectorXd moves = length * dx;
    if (contact() != nullptr) clearance_.ShortenMoves(here.x, moves);
    if (surfaces_) LimitStep(*surfaces_, here.x, moves);
    Trial next = At(here.x + moves);
    const double rise =
        next.potential - here.potential - 0.5 * (here.elastic + next.elastic).dot(moves);
    if (!(rise <= kRounded * here.potential) || !std::isfinite(next.residual)) continue;
    last->whole = moves == dx;
    last->slow = last->whole && next.residual > 0.5 * here.residual;
    for (Rub& rub : rubs_)
      rub.share = ShareAfter(rub, rub.Point(here.x), rub.Point(next.x), options_.creep_speed, h_);
    here = std::move(next);
    return true;
  }
  return false;
}

RubForce ImplicitEuler::Rubbing(const Rub& rub, const Eigen::VectorXd& x) const {
  return EvaluateRub(rub, rub.Point(x), options_.creep_speed, h_);
}

double ImplicitEuler::FindRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x) {
  const auto by_vertex = [&] {
    Eigen::VectorXd limits = Eigen::VectorXd::Zero(model_->mesh.num_vertices());
    for (const Rub& rub : rubs_)
      for (int k = 0; k < 4; ++k) limits[rub.vertex[k]] += rub.limit * std::abs(rub.weight[k]);
    return limits;
  };
  const Eigen::VectorXd old = by_vertex();
  const std::vector<Rub> known = std::exchange(rubs_, {});
  if (contact() != nullptr && options_.friction > 0.0) AddObstacleRubs(before, x);
  if (surfaces_) AddSurfaceRubs(before, x);
  KeepShares(known);
  const Eigen::VectorXd now = by_vertex();
  return now.sum() > 0.0 ? (now - old).cwiseAbs().sum() / now.sum() : 0.0;
}

// Keeps the shares of contacts that were there before. Both lists are in the same order.
void ImplicitEuler::KeepShares(const std::vector<Rub>& known) {
  std::map<std::array<int, 4>, const Rub*> of;
  for (const Rub& rub : known) of[rub.vertex] = &rub;
  for (Rub& rub : rubs_)
    if (const auto found = of.find(rub.vertex); found != of.end())
      rub.share = found->second->share - rub.normal.dot(found->second->share) * rub.normal;
}

void ImplicitEuler::AddObstacleRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x) {
  for (int i = 0; i < model_->mesh.num_vertices(); ++i) {
    const Eigen::Vector3d here = x.segment<3>(3 * i);
    if (!clearance_.MayTouch(i, here)) continue;
    for (const Obstacle& obstacle : contact()->obstacles) {
      const ObstacleDistance distance = DistanceTo(obstacle, here);
      const double gap = distance.value - contact()->offset();
      if (gap >= contact()->range) continue;
      const double force = -contact()->stiffness * model_->vertex_area[i] *
                           EvaluateBarrier(gap, contact()->range).slope * distance.normal.norm();
      rubs_.push_back({.vertex = {i, i, i, i},
                       .limit = options_.friction * force,
                       .normal = distance.normal.normalized(),
                       .start = before.segment<3>(3 * i) + SurfaceMove(obstacle, here)});
    }
  }
}

void ImplicitEuler::AddSurfaceRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x) {
  for (const ActivePair& active : surfaces_->FindActivePairs(x)) {
    const double friction = active.of_obstacle() ? options_.friction : options_.self_friction;
    if (friction == 0.0) continue;
    rubs_.push_back(MakeRub(active, before));
    rubs_.back().limit = friction * NormalForce(active);
  }
}

}  // namespace drape
