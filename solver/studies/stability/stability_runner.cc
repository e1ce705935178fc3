// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <utility>

#include "physics/material/material_scaling.h"
#include "physics/simulation/rollout.h"
#include "physics/util/math/random.h"
#include "solver/forward/random_drapes.h"
#include "solver/studies/stability/methods/projected_newton.h"
#include "solver/studies/stability/methods/slivers.h"

namespace drape {
namespace {

constexpr int kFewestSteps = 40;
// A run that was slower than this for so long ends early.
constexpr double kStandstill = 2e-5, kStandstillTime = 0.25;  // [m/s], [s]

double MeanEdge(const Mesh& mesh) {
  double sum = 0.0;
  for (const Hinge& hinge : mesh.hinges) sum += hinge.rest_length;
  return sum / mesh.num_hinges();
}

// xy scaled about the origin, then the free vertices moved at random.
void Disturb(const ClothModel& model, const StabilityCase& run, int seed, Eigen::VectorXd& x) {
  for (int i = 0; i < model.mesh.num_vertices(); ++i) x.segment<2>(3 * i) *= run.compression;
  std::vector<char> is_held(model.mesh.num_vertices());
  for (const int i : model.held) is_held[i] = true;
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const double size = run.tangle * MeanEdge(model.mesh);
  for (int k = 0; k < x.size(); ++k) {
    const double move = size * SampleNormal(random);
    if (!is_held[k / 3]) x[k] += move;
  }
}

double RmsSpeed(const Eigen::VectorXd& v) {
  return v.norm() / std::sqrt(static_cast<double>(v.size()) / 3.0);
}

class Clock {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// A run on its way.
struct Course {
  const StabilitySetting& setting;
  const std::atomic<bool>& cancel;
  Clock clock = {};
  int steps = 0;

  bool MustEnd() const { return cancel || clock.Seconds() > setting.max_seconds; }
};

StabilityEnd RunInTime(Integrator& step, State state, double h, int max_steps, Course& course) {
  const int standstill = static_cast<int>(std::ceil(kStandstillTime / h)) + 3;
  StabilityEnd end;
  for (int num_still = 0;
       course.steps < max_steps && num_still < standstill && !course.MustEnd();) {
    end.status = step.Advance(state);
    ++course.steps;
    if (end.status != IntegratorStatus::kOk || IsLost(state.x, course.setting.rules)) break;
    num_still = RmsSpeed(state.v) < kStandstill ? num_still + 1 : 0;
  }
  end.x = std::move(state.x);
  end.speed = RmsSpeed(state.v);
  return end;
}

EquilibriumResult RunNewton(StabilityMethod method, StepSolver& solver,
                            const MaterialField& material, const Eigen::VectorXd& x,
                            EquilibriumOptions options) {
  if (method == StabilityMethod::kStaticMassShift) options.shift.length = 0.0;
  if (method == StabilityMethod::kStaticNoShift || method == StabilityMethod::kStaticProjected)
    options.shift = kNoShift;
  return method == StabilityMethod::kStaticProjected
             ? SolveEquilibriumProjected(solver, material, x, options)
             : SolveEquilibrium(solver, material, x, options);
}

// Where a shift may grow, that it cannot grow on reads "not converged" too.
IntegratorStatus StepStatus(StabilityMethod method, const EquilibriumResult& result) {
  if (result.status == EquilibriumStatus::kStable || result.status == EquilibriumStatus::kUnstable)
    return IntegratorStatus::kOk;
  const bool is_bare =
      method == StabilityMethod::kStaticNoShift || method == StabilityMethod::kStaticProjected;
  return is_bare && EndedByFactorisation(result) ? IntegratorStatus::kNotPositiveDefinite
                                                 : IntegratorStatus::kNotConverged;
}

StabilityEnd RunAtRest(const StabilityCase& run, const StabilityScene& scene, Integrator& step,
                       Course& course) {
  StabilityEnd end = RunInTime(step, scene.start, run.h, static_cast<int>(run.pre_steps), course);
  course.steps = 0;
  if (end.status != IntegratorStatus::kOk || IsLost(end.x, course.setting.rules)) return end;
  StepSolver solver(scene.model);
  EquilibriumOptions options;
  options.max_iterations = course.setting.max_newton_steps;
  options.cancel = &course.cancel;
  const EquilibriumResult rest = RunNewton(run.method, solver, scene.material, end.x, options);
  course.steps = rest.iterations;
  return {.status = StepStatus(run.method, rest), .x = rest.x, .speed = 0.0};
}

std::optional<Eigen::VectorXd> RestFrom(const StabilityScene& scene, const Eigen::VectorXd& x) {
  StepSolver solver(scene.model);
  const EquilibriumResult rest = SolveEquilibrium(solver, scene.material, x, {});
  if (rest.status != EquilibriumStatus::kStable) return std::nullopt;
  return rest.x;
}

Eigen::VectorXd MakeReference(const StabilityScene& scene) {
  constexpr int kRounds = 4;
  StepSolver solver(scene.model);
  State state = scene.start;
  for (int round = 0; round < kRounds; ++round) {
    RolloutResult fallen = Rollout(solver, scene.material, state, {.h = 0.05, .steps = 150});
    if (fallen.status != RolloutStatus::kOk) break;
    state = std::move(fallen.end);
    if (const std::optional<Eigen::VectorXd> rest = RestFrom(scene, state.x)) return *rest;
  }
  return {};
}

}  // namespace

StabilityScene StabilityRunner::MakeScene(const StabilityCase& run) const {
  const bool has_contact = run.scenario == StabilityScenario::kSupport;
  Scene cusick = CusickScene({.model = has_contact ? ContactModel::kSupport : ContactModel::kNone,
                              .thickness = run.thickness});
  const double support_radius = *SupportRadius(cusick);
  if (has_contact) {
    cusick.contact->range = run.range;
    cusick.contact->obstacles = {MakeSupport(*cusick.contact, support_radius)};
  }
  cusick.handles->stiffness *= run.handle;
  Mesh mesh = run.sliver > 1.0 ? AddSliverTriangles(setting_.mesh, support_radius, 1.0 / run.sliver)
                               : setting_.mesh;
  StabilityScene scene;
  scene.model = std::make_shared<ClothModel>(std::move(mesh), cusick, MakeLaw(run.law));
  scene.material = Scaled(setting_.material, run.stretch, run.bend);
  scene.material.density = run.density;
  scene.start = scene.model->RestState();
  scene.start.x = ApplyStartShape(scene.model->mesh, support_radius, setting_.start);
  Disturb(*scene.model, run, setting_.seed, scene.start.x);
  return scene;
}

std::unique_ptr<Integrator> StabilityRunner::MakeStep(const StabilityCase& run,
                                                      const StabilityScene& scene) const {
  if (run.method == StabilityMethod::kExplicit)
    return MakeExplicitEuler(scene.model, scene.material, run.h, setting_.drag);
  if (run.method == StabilityMethod::kImplicit)
    return MakeImplicitEuler(scene.model, scene.material, run.h);
  const StepLinearSolver system = run.method == StabilityMethod::kStepPcg ? StepLinearSolver::kPcg
                                  : run.method == StabilityMethod::kStepFloat
                                      ? StepLinearSolver::kFloat
                                      : StepLinearSolver::kDirect;
  return MakeLinearlyImplicitEuler(scene.model, scene.material, run.h, system);
}

const Eigen::VectorXd& StabilityRunner::ReferenceShape(const StabilityCase& run) {
  const StabilityCase usual;
  StabilityCase clean = run;
  clean.method = usual.method;
  clean.h = usual.h;
  clean.pre_steps = usual.pre_steps;
  clean.compression = usual.compression;
  clean.tangle = usual.tangle;
  Reference* reference = nullptr;
  {
    const std::lock_guard lock(mutex_);
    std::unique_ptr<Reference>& slot = references_[CaseName(clean)];
    if (!slot) slot = std::make_unique<Reference>();
    reference = slot.get();
  }
  std::call_once(reference->once, [&] { reference->x = MakeReference(MakeScene(clean)); });
  return reference->x;
}

std::optional<StabilityRun> StabilityRunner::Run(const StabilityCase& run,
                                                 const std::atomic<bool>& cancel) {
  const StabilityScene scene = MakeScene(run);
  const Eigen::VectorXd& reference = ReferenceShape(run);
  Course course{setting_, cancel};
  const std::unique_ptr<Integrator> step = MakeStep(run, scene);
  const int wanted = std::max(kFewestSteps, static_cast<int>(std::ceil(setting_.duration / run.h)));
  const int budget =
      run.method == StabilityMethod::kExplicit ? setting_.max_explicit_steps : setting_.max_steps;
  const StabilityEnd end =
      IsStatic(run.method) ? RunAtRest(run, scene, *step, course)
                           : RunInTime(*step, scene.start, run.h, std::min(wanted, budget), course);
  if (cancel) return std::nullopt;
  StabilityRun result;
  result.steps = course.steps;
  result.seconds = course.clock.Seconds();
  const auto rest = [&](const Eigen::VectorXd& x) { return RestFrom(scene, x); };
  result.outcome = Classify(*scene.model, end, reference, rest, setting_.rules);
  if (IsLost(end.x, setting_.rules)) return result;
  const double residual = ForceResidual(*scene.model, scene.material, end.x);
  if (std::isfinite(residual)) result.residual = residual;
  if (std::isfinite(end.speed)) result.speed = end.speed;
  if (reference.size() > 0) result.distance = VertexDistance(end.x, reference);
  return result;
}

}  // namespace drape
