// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_study.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <utility>

#include "physics/material/laws/bend_element.h"
#include "physics/material/material_scaling.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "solver/forward/random_drapes.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr int kFewestSteps = 40;
// A run that was slower than this for so long ends early.
constexpr double kStandstill = 2e-5, kStandstillTime = 0.25;  // [m/s], [s]

std::vector<char> HeldVertices(const ClothModel& model) {
  std::vector<char> is_held(model.mesh.num_vertices());
  for (const int i : model.held) is_held[i] = true;
  return is_held;
}

// A triangle of the support whose normal points down.
bool LiesFaceDown(const ClothModel& model, const Eigen::VectorXd& x) {
  const std::vector<char> is_held = HeldVertices(model);
  const auto at = [&](int i) -> Eigen::Vector3d { return x.segment<3>(3 * i); };
  return std::any_of(model.mesh.faces.begin(), model.mesh.faces.end(), [&](const Face& face) {
    const int* v = face.vertex;
    if (!is_held[v[0]] || !is_held[v[1]] || !is_held[v[2]]) return false;
    return (at(v[1]) - at(v[0])).cross(at(v[2]) - at(v[0])).z() < 0.0;
  });
}

bool IsLost(const Eigen::VectorXd& x) {
  constexpr double kFar = 2.0;  // [m]
  return !x.allFinite() || x.cwiseAbs().maxCoeff() > kFar;
}

bool IsFoldedOver(const ClothModel& model, const Eigen::VectorXd& x) {
  constexpr double kFold = 2.88, kAbove = 0.03;  // [rad], 165°; [m]
  double highest = x[2];
  for (int i = 0; i < model.mesh.num_vertices(); ++i) highest = std::max(highest, x[3 * i + 2]);
  return highest > kAbove || LiesFaceDown(model, x) ||
         std::any_of(model.mesh.hinges.begin(), model.mesh.hinges.end(), [&](const Hinge& hinge) {
           return std::abs(DihedralAngle(GatherCorners(hinge, x.data()))) > kFold;
         });
}

// Vertices that may move: beyond the support, off the boundary.
std::vector<char> FreeVertices(const Mesh& mesh, double support_radius) {
  constexpr double kRounding = 1e-9;
  std::vector<char> is_free(mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i)
    is_free[i] = mesh.uv.col(i).norm() > support_radius * (1.0 + kRounding);
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (const int i : loop) is_free[i] = false;
  return is_free;
}

double MeanEdge(const Mesh& mesh) {
  double sum = 0.0;
  for (const Hinge& hinge : mesh.hinges) sum += hinge.rest_length;
  return sum / mesh.num_hinges();
}

// xy scaled about the origin, then the free vertices moved at random.
void Disturb(const ClothModel& model, const StabilityCase& run, int seed, Eigen::VectorXd& x) {
  for (int i = 0; i < model.mesh.num_vertices(); ++i) x.segment<2>(3 * i) *= run.compression;
  const std::vector<char> is_held = HeldVertices(model);
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const double size = run.tangle * MeanEdge(model.mesh);
  for (int k = 0; k < x.size(); ++k) {
    const double move = size * SampleNormal(random);
    if (!is_held[k / 3]) x[k] += move;
  }
}

// A run on its way.
struct Course {
  using Clock = std::chrono::steady_clock;

  const StabilitySetting& setting;
  const std::atomic<bool>& cancel;
  Clock::time_point begin = Clock::now();
  int steps = 0;

  double Seconds() const { return std::chrono::duration<double>(Clock::now() - begin).count(); }
  bool MustEnd() const { return cancel || Seconds() > setting.max_seconds; }
};

StabilityEnd RunInTime(const Integrator& step, State state, double h, int max_steps,
                       Course& course) {
  const int standstill = static_cast<int>(std::ceil(kStandstillTime / h)) + 3;
  StabilityEnd end;
  for (int num_still = 0;
       course.steps < max_steps && num_still < standstill && !course.MustEnd();) {
    end.status = step(state);
    ++course.steps;
    if (end.status != IntegratorStatus::kOk || IsLost(state.x)) break;
    num_still = VertexRms(state.v) < kStandstill ? num_still + 1 : 0;
  }
  end.x = std::move(state.x);
  end.speed = VertexRms(state.v);
  return end;
}

EquilibriumResult RunNewton(StabilityMethod method, const StabilityScene& scene,
                            const Eigen::VectorXd& x, EquilibriumOptions options) {
  StepSolver solver(scene.model);
  StepMatrix matrix;
  if (method == StabilityMethod::kStaticMassShift) options.shift.length = 0.0;
  if (method == StabilityMethod::kStaticNoShift || method == StabilityMethod::kStaticProjected)
    options.shift = kNoShift;
  if (method == StabilityMethod::kStaticProjected)
    matrix = [&scene](const Eigen::VectorXd& here, BlockMatrix& K) {
      AssembleProjectedStiffness(*scene.model, scene.material, here, K);
    };
  return SolveEquilibrium(solver, scene.material, x, options, matrix);
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

StabilityEnd RunAtRest(const StabilityCase& run, const StabilityScene& scene,
                       const Integrator& step, Course& course) {
  StabilityEnd end = RunInTime(step, scene.start, run.h, static_cast<int>(run.pre_steps), course);
  course.steps = 0;
  if (end.status != IntegratorStatus::kOk || IsLost(end.x)) return end;
  const EquilibriumResult rest =
      RunNewton(run.method, scene, end.x,
                {.max_iterations = course.setting.max_newton_steps, .cancel = &course.cancel});
  course.steps = rest.iterations;
  return {.status = StepStatus(run.method, rest), .x = rest.x, .speed = 0.0};
}

std::optional<Eigen::VectorXd> RestFrom(const StabilityScene& scene, const Eigen::VectorXd& x) {
  const EquilibriumResult rest = RunNewton(StabilityMethod::kStatic, scene, x, {});
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

std::optional<double> TheoreticalLimit(const StabilityScene& scene, double drag) {
  StepSolver solver(scene.model);
  const std::optional<double> omega2 =
      HighestEigenvalue(solver, scene.material, scene.model->mesh.rest_x);
  if (!omega2 || !(*omega2 > 0.0)) return std::nullopt;
  return (drag + std::sqrt(drag * drag + 4.0 * *omega2)) / *omega2;
}

enum class Kind { kRun, kLimit, kDamping };

struct Task {
  Kind kind;
  StabilityCase run;
  int mode = 0;  // of damping

  std::string Name() const {
    std::string name = CaseName(run);
    if (kind == Kind::kRun) return name;
    return kind == Kind::kLimit ? "limit of " + name
                                : "damping of " + name + " mode=" + std::to_string(mode + 1);
  }
  json Input() const {
    json input = CaseJson(run);
    input["kind"] = kind == Kind::kRun ? "run" : kind == Kind::kLimit ? "limit" : "damping";
    if (kind == Kind::kDamping) input["mode"] = mode + 1;
    return input;
  }
};

// The cases of an explicit map over the time step whose limit is measured, by the values of the
// other axis.
std::vector<StabilityCase> LimitCases(const StabilityMap& map) {
  std::vector<StabilityCase> cases;
  if (map.base.method != StabilityMethod::kExplicit) return cases;
  for (const int k : {0, 1}) {
    if (map.axis[k]->name != std::string("time_step")) continue;
    for (const double value : map.values[1 - k]) {
      cases.push_back(map.base);
      map.axis[1 - k]->Set(cases.back(), value);
    }
  }
  return cases;
}

std::vector<Task> ListTasks(const std::vector<StabilityMap>& maps,
                            const std::vector<double>& damping_h) {
  std::vector<Task> tasks;
  std::set<std::string> seen;
  const auto add = [&](const Task& task) {
    if (seen.insert(task.Name()).second) tasks.push_back(task);
  };
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : map.Cases()) add({Kind::kRun, run});
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : LimitCases(map)) add({Kind::kLimit, run});
  for (const StabilityMethod method : {StabilityMethod::kStep, StabilityMethod::kImplicit})
    for (const int mode : {0, 9})
      for (const double h : damping_h) add({Kind::kDamping, {.method = method, .h = h}, mode});
  return tasks;
}

std::optional<json> RunTask(StabilityRunner& runner, const Task& task,
                            const std::atomic<bool>& cancel) {
  if (task.kind == Kind::kLimit) return runner.MeasureLimit(task.run);
  if (task.kind == Kind::kDamping) return runner.MeasureDamping(task.run, task.mode);
  return runner.Run(task.run, cancel);
}

json SettingsJson(const StabilitySetting& setting) {
  return {{"seed", setting.seed},
          {"duration_s", setting.duration},
          {"max_steps", setting.max_steps},
          {"max_newton_steps", setting.max_newton_steps},
          {"max_explicit_steps", setting.max_explicit_steps},
          {"max_seconds", setting.max_seconds},
          {"drag", setting.drag}};
}

nlohmann::ordered_json AxisJson(const StabilityMap& map, int k) {
  return {{"axis", map.axis[k]->name}, {"label", map.axis[k]->label}, {"values", map.values[k]}};
}

}  // namespace

StabilityOutcome Classify(const ClothModel& model, const StabilityEnd& end,
                          const Eigen::VectorXd& reference, const RestOf& rest) {
  constexpr double kSpeed = 2e-3, kBranch = 3e-3;  // [m/s], [m]
  if (end.status == IntegratorStatus::kNotFinite || IsLost(end.x))
    return StabilityOutcome::kDiverged;
  if (end.status == IntegratorStatus::kNotPositiveDefinite) return StabilityOutcome::kFactorFailed;
  if (end.status == IntegratorStatus::kNotConverged) return StabilityOutcome::kNotConverged;
  if (IsFoldedOver(model, end.x)) return StabilityOutcome::kFoldedOver;
  if (!(end.speed <= kSpeed)) return StabilityOutcome::kStillMoving;
  const auto is_reference = [&](const Eigen::VectorXd& x) {
    return reference.size() == 0 || VertexDistance(x, reference) <= kBranch;
  };
  if (is_reference(end.x)) return StabilityOutcome::kSettled;
  const std::optional<Eigen::VectorXd> leads_to = rest(end.x);
  return leads_to && is_reference(*leads_to) ? StabilityOutcome::kStillMoving
                                             : StabilityOutcome::kOtherBranch;
}

Mesh AddSliverTriangles(const Mesh& mesh, double support_radius, double ratio) {
  CHECK(ratio > 0.0 && ratio <= 1.0) << ratio;
  std::vector<char> is_free = FreeVertices(mesh, support_radius);
  Eigen::Matrix2Xd uv = mesh.uv;
  bool any = false;
  for (const Hinge& hinge : mesh.hinges) {
    const int a = hinge.vertex[0], b = hinge.vertex[1];
    if (!is_free[a] || !is_free[b]) continue;
    any = true;
    const Eigen::Vector2d middle = 0.5 * (uv.col(a) + uv.col(b));
    for (const int i : {a, b}) uv.col(i) = middle + ratio * (uv.col(i) - middle);
    for (const Face& face : mesh.faces) {  // what touches the edge stays where it is
      const int* v = face.vertex;
      if (std::none_of(v, v + 3, [&](int i) { return i == a || i == b; })) continue;
      for (int k = 0; k < 3; ++k) is_free[v[k]] = false;
    }
  }
  if (!any) throw InputError("slivers", "the mesh has no edge between the support and the hem");
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i) x.segment<2>(3 * i) = uv.col(i);
  return BuildMesh(x, uv, ListTriangles(mesh), "slivers");
}

StabilityScene StabilityRunner::MakeScene(const StabilityCase& run) const {
  Scene cusick = CusickScene({.model = ContactModel::kNone});
  const double support_radius = *SupportRadius(cusick);
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

Integrator StabilityRunner::MakeStep(const StabilityCase& run, const StabilityScene& scene) const {
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

std::optional<json> StabilityRunner::Run(const StabilityCase& run,
                                         const std::atomic<bool>& cancel) {
  const StabilityScene scene = MakeScene(run);
  const Eigen::VectorXd& reference = ReferenceShape(run);
  Course course{setting_, cancel};
  const Integrator step = MakeStep(run, scene);
  const int wanted = std::max(kFewestSteps, static_cast<int>(std::ceil(setting_.duration / run.h)));
  const int budget =
      run.method == StabilityMethod::kExplicit ? setting_.max_explicit_steps : setting_.max_steps;
  const StabilityEnd end =
      IsStatic(run.method) ? RunAtRest(run, scene, step, course)
                           : RunInTime(step, scene.start, run.h, std::min(wanted, budget), course);
  if (cancel) return std::nullopt;
  const auto rest = [&](const Eigen::VectorXd& x) { return RestFrom(scene, x); };
  json result = {{"outcome", ToString(Classify(*scene.model, end, reference, rest))},
                 {"steps", course.steps},
                 {"seconds", course.Seconds()},
                 {"residual", nullptr},
                 {"speed_m_s", nullptr},
                 {"distance_m", nullptr}};
  if (IsLost(end.x)) return result;
  const double residual = ForceResidual(*scene.model, scene.material, end.x);
  if (std::isfinite(residual)) result["residual"] = residual;
  if (std::isfinite(end.speed)) result["speed_m_s"] = end.speed;
  if (reference.size() > 0) result["distance_m"] = VertexDistance(end.x, reference);
  return result;
}

bool StabilityRunner::StaysBounded(const StabilityCase& run, const StabilityScene& scene) const {
  constexpr int kSteps = 1500;
  const Integrator step = MakeStep(run, scene);
  State state = scene.start;
  for (int i = 0; i < kSteps; ++i)
    if (step(state) != IntegratorStatus::kOk || IsLost(state.x)) return false;
  return true;
}

json StabilityRunner::MeasureLimit(StabilityCase run) const {
  constexpr double kPrecision = 1.03, kSearch = 8.0;
  run.method = StabilityMethod::kExplicit;
  const StabilityScene scene = MakeScene(run);
  json limit = {{"theory_s", nullptr}, {"measured_s", nullptr}};
  const std::optional<double> theory = TheoreticalLimit(scene, setting_.drag);
  if (!theory) return limit;
  limit["theory_s"] = *theory;
  const auto holds = [&](double h) {
    run.h = h;
    return StaysBounded(run, scene);
  };
  double low = *theory / kSearch, high = *theory * kSearch;
  if (!holds(low) || holds(high)) return limit;
  while (high > kPrecision * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  limit["measured_s"] = std::sqrt(low * high);
  return limit;
}

json StabilityRunner::MeasureDamping(const StabilityCase& run, int mode) {
  constexpr double kMove = 1e-5, kDecay = 3.0;  // largest at first [m]; of the logarithm in all
  json none = {{"omega_1_s", nullptr}};
  const Eigen::VectorXd& rest = ReferenceShape(run);
  if (rest.size() == 0) return none;
  const StabilityScene scene = MakeScene(run);
  StepSolver solver(scene.model);
  const VibrationModes modes = LowestModes(solver, scene.material, rest, mode + 1);
  if (modes.eigenvalues.size() <= mode || !(modes.eigenvalues[mode] > 0.0)) return none;
  const double omega = std::sqrt(modes.eigenvalues[mode]);
  const Eigen::VectorXd shape = modes.shapes.col(mode);
  const Eigen::VectorXd weighed =
      scene.model->LumpedMass(scene.material.density).cwiseProduct(shape);
  const double decay = 0.5 * std::log1p(std::pow(run.h * omega, 2));
  const int steps = static_cast<int>(std::clamp(std::round(kDecay / decay), 1.0, 1000.0));
  const Integrator step = MakeStep(run, scene);
  State state{rest + kMove / shape.cwiseAbs().maxCoeff() * shape,
              Eigen::VectorXd::Zero(rest.size())};
  // The norm of amplitude a and velocity b along the mode: √(ω²a² + b²).
  const auto energy_norm = [&] {
    return std::hypot(omega * weighed.dot(state.x - rest), weighed.dot(state.v));
  };
  const double first = energy_norm();
  for (int i = 0; i < steps; ++i)
    if (step(state) != IntegratorStatus::kOk) return none;
  return {{"omega_1_s", omega},
          {"steps", steps},
          {"theory", std::exp(-decay)},
          {"measured", std::pow(energy_norm() / first, 1.0 / steps)}};
}

Study MakeStabilityStudy(StabilityRunner& runner, const std::vector<StabilityMap>& maps,
                         const std::vector<double>& damping_h) {
  for (const StabilityMap& map : maps) {
    runner.MakeScene(map.At(0, 0));
    runner.MakeScene(map.Cases().back());
  }
  const auto tasks = std::make_shared<std::vector<Task>>(ListTasks(maps, damping_h));
  Study study{.name = "stability", .settings = SettingsJson(runner.setting())};
  for (const auto& [outcome, name] : EnumNames(StabilityOutcome{}))
    study.outcomes.emplace_back(name);
  for (const Task& task : *tasks) study.cells.push_back({task.Name(), task.Input()});
  study.run = [&runner, tasks](std::size_t cell, const RunControl& control) {
    return RunTask(runner, (*tasks)[cell], *control.cancel);
  };
  return study;
}

nlohmann::ordered_json MapsJson(const std::vector<StabilityMap>& maps) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const StabilityMap& map : maps) {
    nlohmann::ordered_json json = {{"name", map.name},
                                   {"base", CaseJson(map.base)},
                                   {"across", AxisJson(map, 0)},
                                   {"up", AxisJson(map, 1)},
                                   {"runs", nlohmann::ordered_json::array()}};
    for (const StabilityCase& run : map.Cases()) json["runs"].push_back(CaseName(run));
    for (const StabilityCase& run : LimitCases(map))
      json["limits"].push_back(Task{Kind::kLimit, run}.Name());
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace drape
