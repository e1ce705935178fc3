// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_theory.h"

#include <algorithm>
#include <cmath>

#include "physics/simulation/statics/modes.h"

namespace drape {
namespace {

bool StaysBounded(const StabilityRunner& runner, const StabilityCase& run,
                  const StabilityScene& scene, int steps) {
  const std::unique_ptr<Integrator> step = runner.MakeStep(run, scene);
  State state = scene.start;
  for (int i = 0; i < steps; ++i)
    if (step->Advance(state) != IntegratorStatus::kOk || IsLost(state.x, runner.setting().rules))
      return false;
  return true;
}

std::optional<double> TheoreticalLimit(const StabilityScene& scene, double drag) {
  StepSolver solver(scene.model);
  const std::optional<double> omega2 =
      HighestEigenvalue(solver, scene.material, scene.model->mesh.rest_x);
  if (!omega2 || !(*omega2 > 0.0)) return std::nullopt;
  return (drag + std::sqrt(drag * drag + 4.0 * *omega2)) / *omega2;
}

// Of a vibration with amplitude a and velocity b along a mode: √(ω²a² + b²).
double EnergyNorm(const State& state, const Eigen::VectorXd& rest, const Eigen::VectorXd& weighed,
                  double omega) {
  return std::hypot(omega * weighed.dot(state.x - rest), weighed.dot(state.v));
}

}  // namespace

ExplicitLimit MeasureLimit(const StabilityRunner& runner, StabilityCase run, int steps) {
  constexpr double kPrecision = 1.03, kSearch = 8.0;
  run.method = StabilityMethod::kExplicit;
  const StabilityScene scene = runner.MakeScene(run);
  ExplicitLimit limit{.theory = TheoreticalLimit(scene, runner.setting().drag), .measured = {}};
  if (!limit.theory) return limit;
  const auto holds = [&](double h) {
    run.h = h;
    return StaysBounded(runner, run, scene, steps);
  };
  double low = *limit.theory / kSearch, high = *limit.theory * kSearch;
  if (!holds(low) || holds(high)) return limit;
  while (high > kPrecision * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  limit.measured = std::sqrt(low * high);
  return limit;
}

std::optional<StepDamping> MeasureDamping(StabilityRunner& runner, const StabilityCase& run,
                                          int mode) {
  constexpr double kMove = 1e-5, kDecay = 3.0;  // largest at first [m]; of the logarithm in all
  const Eigen::VectorXd& rest = runner.ReferenceShape(run);
  if (rest.size() == 0) return std::nullopt;
  const StabilityScene scene = runner.MakeScene(run);
  StepSolver solver(scene.model);
  const VibrationModes modes = LowestModes(solver, scene.material, rest, mode + 1);
  if (modes.eigenvalues.size() <= mode || !(modes.eigenvalues[mode] > 0.0)) return std::nullopt;
  StepDamping damping{.omega = std::sqrt(modes.eigenvalues[mode])};
  const Eigen::VectorXd shape = modes.shapes.col(mode);
  const Eigen::VectorXd weighed =
      scene.model->LumpedMass(scene.material.density).cwiseProduct(shape);
  const double decay = 0.5 * std::log1p(std::pow(run.h * damping.omega, 2));
  damping.theory = std::exp(-decay);
  damping.steps = static_cast<int>(std::clamp(std::round(kDecay / decay), 1.0, 1000.0));
  const std::unique_ptr<Integrator> step = runner.MakeStep(run, scene);
  State state{rest + kMove / shape.cwiseAbs().maxCoeff() * shape,
              Eigen::VectorXd::Zero(rest.size())};
  const double first = EnergyNorm(state, rest, weighed, damping.omega);
  for (int i = 0; i < damping.steps; ++i)
    if (step->Advance(state) != IntegratorStatus::kOk) return std::nullopt;
  damping.measured =
      std::pow(EnergyNorm(state, rest, weighed, damping.omega) / first, 1.0 / damping.steps);
  return damping;
}

}  // namespace drape
