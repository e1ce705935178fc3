// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/contact/contact_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "physics/mesh/self_intersection.h"
#include "solver/studies/stability/methods/integrator.h"
#include "solver/studies/stability/methods/penalty_step.h"

namespace drape {
namespace {

using Scenario = StabilityScenario;
using Method = StabilityMethod;

// One step of a case, within what is around it at its end.
class ContactStep {
 public:
  ContactStep(const StabilityCase& run, const ContactScene& scene, double h,
              const std::atomic<bool>& cancel)
      : contact_(scene.contact_at(0.0)) {
    if (run.method == Method::kPenalty) {
      step_ =
          MakePenaltyStep(scene.model, scene.material, h, &contact_, {.friction = run.friction});
    } else if (run.method == Method::kStep) {
      Scene with_contact = scene.model->scene;
      with_contact.contact = contact_;
      step_ = MakeLinearlyImplicitEuler(
          std::make_shared<ClothModel>(scene.model->mesh, with_contact, scene.model->law),
          scene.material, h, StepLinearSolver::kDirect);
    } else {
      ImplicitEulerOptions options{.friction = run.friction,
                                   .self_friction = run.friction,
                                   .creep_speed = run.creep_speed,
                                   .friction_rounds = static_cast<int>(run.friction_rounds),
                                   .cancel = &cancel};
      if (scene.is_self_contact)
        options.self_contact = Contact{.thickness = run.thickness, .range = run.range};
      newton_ = std::make_unique<ImplicitEuler>(scene.model, scene.material, h, options);
    }
  }

  IntegratorStatus Advance(const Contact& around, State& state) {
    contact_ = around;
    return newton_ ? newton_->Advance(state, {.contact = &contact_}) : step_->Advance(state);
  }

 private:
  Contact contact_;
  std::unique_ptr<Integrator> step_;
  std::unique_ptr<ImplicitEuler> newton_;
};

double Inradius(const StabilityCase& run) {
  return run.scenario == Scenario::kPlate ? 0.5 * kPlateThickness : run.radius;
}

// How deep the segment from a to b is in a solid [m], 0 if it is not: of convex ones the distance
// is convex along it.
double DepthBetween(const Contact& contact, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  constexpr int kRounds = 40;
  double depth = 0.0;
  for (const Obstacle& obstacle : contact.obstacles) {
    const auto at = [&](double s) { return DistanceTo(obstacle, a + s * (b - a)).value; };
    if (at(0.0) > (b - a).norm()) continue;
    double low = 0.0, high = 1.0;
    for (int i = 0; i < kRounds; ++i) {
      const double one = low + (high - low) / 3.0, other = high - (high - low) / 3.0;
      if (at(one) < at(other))
        high = other;
      else
        low = one;
    }
    depth = std::max({depth, -at(0.0), -at(1.0), -at(low)});
  }
  return depth;
}

double DepthOnTheWay(const Contact& contact, const Eigen::VectorXd& from,
                     const Eigen::VectorXd& to) {
  double depth = 0.0;
  for (Eigen::Index i = 0; i < to.size(); i += 3)
    depth = std::max(depth, DepthBetween(contact, from.segment<3>(i), to.segment<3>(i)));
  return depth;
}

double DepthOfFaces(const Mesh& mesh, const Contact& contact, const Eigen::VectorXd& x) {
  double depth = 0.0;
  for (const Face& face : mesh.faces)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d a = x.segment<3>(3 * face.vertex[k]);
      const Eigen::Vector3d b = x.segment<3>(3 * face.vertex[(k + 1) % 3]);
      const Eigen::Vector3d c = x.segment<3>(3 * face.vertex[(k + 2) % 3]);
      depth =
          std::max({depth, DepthBetween(contact, a, b), DepthBetween(contact, a, 0.5 * (b + c))});
    }
  return depth;
}

// Whether a face of one sheet meets one of the other.
bool DoSheetsMeet(const Mesh& mesh, const Eigen::VectorXd& x) {
  constexpr int kMost = 1000;
  const auto triangles = ListTriangles(mesh);
  const auto meetings = FindSelfIntersections(triangles, x, kMost);
  const int half = mesh.num_vertices() / 2;
  return std::any_of(meetings.begin(), meetings.end(), [&](const auto& pair) {
    return (triangles[pair.first][0] < half) != (triangles[pair.second][0] < half);
  });
}

// Whether two sheets meet, or have changed places and still move as they were thrown.
bool HavePassed(const StabilityCase& run, const ContactScene& scene, const State& state) {
  if (scene.sheets == 1) return false;
  const Eigen::Index half = state.x.size() / 2;
  Eigen::Vector2d upper = Eigen::Vector2d::Zero();  // height and speed over those of the other
  for (Eigen::Index i = 2; i < half; i += 3)
    upper += Eigen::Vector2d(state.x[i + half] - state.x[i], state.v[i + half] - state.v[i]);
  upper *= 3.0 / static_cast<double>(half);
  return (run.scenario == Scenario::kSheets && upper[0] < 0.0 && upper[1] < -0.5 * run.speed) ||
         DoSheetsMeet(scene.model->mesh, state.x);
}

Eigen::Vector3d MeanVelocity(const State& state) {
  return state.v.reshaped(3, state.v.size() / 3).rowwise().mean();
}

bool IsOffTheLaw(const StabilityCase& run, double duration, const State& start, const State& end) {
  constexpr double kShare = 0.05, kNoise = 1e-5;  // [1], [m/s]
  if (run.scenario != Scenario::kSlope && run.scenario != Scenario::kSkid) return false;
  const Eigen::Vector3d gain = MeanVelocity(end) - MeanVelocity(start);
  const double law = SpeedByLaw(run, duration, gain.z()), speed = MeanVelocity(end).x();
  // A contact that does not creep is no mistake.
  const bool is_static = run.scenario == Scenario::kSlope && run.friction > kSlopeTangent;
  const double low = is_static ? -kNoise : (1.0 - kShare) * law - kNoise;
  return !(speed >= low && speed <= (1.0 + kShare) * law + kNoise);
}

// Whether some vertex has no place out of the obstacles.
bool HasNoRoom(const Contact& around, Eigen::VectorXd x) {
  PushOut(around, x);
  return !(SmallestGap(around, x) > 0.0);
}

std::optional<StabilityOutcome> Reported(IntegratorStatus status) {
  switch (status) {
    case IntegratorStatus::kNotFinite:
      return StabilityOutcome::kDiverged;
    case IntegratorStatus::kNotPositiveDefinite:
      return StabilityOutcome::kFactorFailed;
    case IntegratorStatus::kNotConverged:
      return StabilityOutcome::kNotConverged;
    case IntegratorStatus::kPinched:
      return StabilityOutcome::kPinched;
    default:
      return std::nullopt;
  }
}

// What is found on the way of a run.
struct Course {
  IntegratorStatus status = IntegratorStatus::kOk;
  int steps = 0;
  double h = 0.0;
  double depth = 0.0;
  bool passed = false, is_slow = false, has_no_room = false;
};

Course Follow(const StabilityCase& run, const ContactScene& scene, const ContactLimits& limits,
              const std::atomic<bool>& cancel, State& state) {
  const auto begin = std::chrono::steady_clock::now();
  const int steps =
      std::clamp(static_cast<int>(std::ceil(scene.duration / run.h)), 3, limits.max_steps);
  Course course{.h = run.h};
  ContactStep step(run, scene, run.h, cancel);
  while (course.steps < steps && !course.passed && !cancel) {
    const Contact around = scene.contact_at((course.steps + 1) * run.h);
    State next = state;
    course.status = step.Advance(around, next);
    ++course.steps;
    if (course.status != IntegratorStatus::kOk) {
      course.has_no_room = HasNoRoom(around, state.x);
      break;
    }
    // A ball that closes is where it is at the end of a step.
    const Eigen::VectorXd& from = run.scenario == Scenario::kPinch ? next.x : state.x;
    course.depth = std::max({course.depth, DepthOnTheWay(around, from, next.x),
                             DepthOfFaces(scene.model->mesh, around, next.x)});
    state = std::move(next);
    course.passed = course.depth > 0.5 * Inradius(run) || HavePassed(run, scene, state);
    course.is_slow =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() >
        limits.max_seconds;
    if (course.is_slow) break;
  }
  return course;
}

}  // namespace

double SpeedByLaw(const StabilityCase& run, double duration, double normal_gain) {
  if (run.scenario == Scenario::kSkid) return std::max(0.0, run.speed - run.friction * normal_gain);
  const double angle = std::atan(kSlopeTangent);
  if (run.friction > kSlopeTangent)
    return run.creep_speed * (1.0 - std::sqrt(1.0 - kSlopeTangent / run.friction));
  return kContactGravity * (std::sin(angle) - run.friction * std::cos(angle)) * duration;
}

std::optional<ContactRun> RunContact(const StabilityCase& run, const MaterialField& material,
                                     const ContactLimits& limits, const std::atomic<bool>& cancel) {
  const ContactScene scene = MakeContactScene(run, material);
  State state = scene.start;
  const Course course = Follow(run, scene, limits, cancel, state);
  if (cancel) return std::nullopt;
  ContactRun result{.steps = course.steps};
  if (state.x.allFinite() && state.v.allFinite()) {
    result.speed = std::sqrt(3.0) * state.v.norm() / std::sqrt(static_cast<double>(state.v.size()));
    result.distance = course.depth;
  }
  if (course.has_no_room)
    result.outcome = StabilityOutcome::kPinched;
  else if (const std::optional<StabilityOutcome> reported = Reported(course.status))
    result.outcome = *reported;
  else if (course.passed)
    result.outcome = StabilityOutcome::kPassedThrough;
  else if (course.is_slow)
    result.outcome = StabilityOutcome::kNotConverged;
  else if (course.depth > 0.1 * run.thickness)
    result.outcome = StabilityOutcome::kCutsIn;
  else if (IsOffTheLaw(run, course.steps * course.h, scene.start, state))
    result.outcome = StabilityOutcome::kOffTheLaw;
  return result;
}

}  // namespace drape
