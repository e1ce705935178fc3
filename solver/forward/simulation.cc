// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/simulation.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include "physics/simulation/backend.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kLongestPiece = 20;  // steps between two reports of the progress

// The status of a load path that ended at this share of the load.
std::string LostStability(double share) {
  return share > 0.0 ? Format("lost stability at %.2g %% of the load", 100.0 * share)
                     : "not stable under any share of the load";
}

class Simulation {
 public:
  Simulation(Backend& backend, const SimulationTask& task, const RunControl& control)
      : backend_(backend), task_(task), control_(control) {
    result_.end = task.start;
    step_.h = task.h;
    step_.cancel = control.cancel;
  }

  SimulationResult Run() {
    RunSteps();
    if (task_.newton && IsDone()) RunNewton();
    return std::move(result_);
  }

 private:
  bool IsDone() const { return result_.outcome == SimulationOutcome::kDone; }

  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - lap_).count();
    lap_ = now;
    return seconds;
  }

  void Stop(bool cancelled, const std::string& status) {
    result_.outcome = cancelled ? SimulationOutcome::kCancelled : SimulationOutcome::kFailed;
    result_.status = status;
  }

  void ShowState() const {
    if (task_.on_state) task_.on_state(result_.steps, result_.end);
  }

  void ShowStateAtStop() const {
    if (std::find(task_.stops.begin(), task_.stops.end(), result_.steps) != task_.stops.end())
      ShowState();
  }

  // From here to the next stop.
  int NextPiece() const {
    int end = std::min(task_.steps, result_.steps + kLongestPiece);
    for (const int stop : task_.stops)
      if (stop > result_.steps) end = std::min(end, stop);
    return end - result_.steps;
  }

  // Advances until a step fails.
  RolloutStatus Advance(int steps) {
    const RolloutInput input{task_.material, &result_.end};
    RolloutOptions piece = step_;
    piece.steps = steps;
    RolloutResult next = backend_.Rollouts({&input, 1}, piece, nullptr)[0];
    const RolloutStatus status = next.status;
    if (status == RolloutStatus::kNotFinite) {  // its end has the velocity of the step that failed
      piece.steps = next.steps;
      next = backend_.Rollouts({&input, 1}, piece, nullptr)[0];
    }
    result_.end = std::move(next.end);
    result_.steps += next.steps;
    return status;
  }

  // Consecutive rollouts are bitwise one rollout: a state is all that one hands to the next. Where
  // the cloth touches itself they are to rounding: each begins with the model's own pattern.
  void RunSteps() {
    ShowStateAtStop();
    while (result_.steps < task_.steps) {
      const RolloutStatus status = Advance(NextPiece());
      if (status != RolloutStatus::kOk) {
        Stop(status == RolloutStatus::kCancelled, ToString(status));
        ShowState();
        break;
      }
      ShowStateAtStop();
      Report();
    }
    result_.seconds.emplace_back("steps", Lap());
  }

  void Report() const {
    control_.Report(double(result_.steps) / task_.steps,
                    "step " + std::to_string(result_.steps) + " of " + std::to_string(task_.steps));
  }

  EquilibriumOptions NewtonOptions() const {
    EquilibriumOptions newton;
    newton.cancel = control_.cancel;
    const Scene& scene = backend_.model().scene;
    // The vertices of a fine strip are so light that μM matters to its membrane at this shift only.
    if (!SupportRadius(scene)) newton.shift.most = 1e12;
    if (!scene.load) return newton;
    // The residual of a pulled strip is relative to its load: its weight is negligible beside it.
    const double weight = CharacteristicForce(backend_.model(), *task_.material);
    newton.tolerance *= std::max(1.0, scene.load->force.norm() / weight);
    newton.residual_regime = std::numeric_limits<double>::infinity();
    return newton;
  }

  void RunNewton() {
    const RolloutInput input{task_.material, &result_.end};
    const EquilibriumOptions options = NewtonOptions();
    const EquilibriumResult rest = task_.load_path
                                       ? SolveFromRest(backend_, *task_.material, options)
                                       : backend_.Equilibria({&input, 1}, options)[0];
    result_.newton_iterations = rest.iterations;
    result_.status = ToString(rest.status);
    result_.end = {rest.x, Eigen::VectorXd::Zero(rest.x.size())};
    const bool cancelled = rest.status == EquilibriumStatus::kCancelled;
    if (!cancelled && rest.load_share < 1.0)  // the residual is that of this share, which converged
      result_.status =
          LostStability(rest.load_share) +
          Format(": no larger share converges, after %d Newton steps", rest.iterations);
    else if (rest.status == EquilibriumStatus::kNotConverged)
      result_.status += Format(
          ": a force residual of %.2g of the weight after %d Newton steps, "
          "expected at most %.2g",
          rest.residual, rest.iterations, options.tolerance);
    if (cancelled || rest.status == EquilibriumStatus::kNotConverged)
      Stop(cancelled, result_.status);
    result_.seconds.emplace_back("newton", Lap());
  }

  Backend& backend_;
  const SimulationTask& task_;
  const RunControl& control_;
  std::chrono::steady_clock::time_point lap_ = std::chrono::steady_clock::now();
  RolloutOptions step_;
  SimulationResult result_;
};

}  // namespace

SimulationResult Simulate(Backend& backend, const SimulationTask& task, const RunControl& control) {
  return Simulation(backend, task, control).Run();
}

}  // namespace drape
