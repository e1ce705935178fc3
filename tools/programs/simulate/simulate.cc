// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/simulate.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "physics/cloth/state_io.h"
#include "physics/mesh/obj_io.h"
#include "physics/simulation/load_path.h"
#include "physics/simulation/statics/modes.h"
#include "physics/util/errors.h"
#include "tools/cli/output_folder.h"
#include "tools/inputs/backend_option.h"
#include "tools/programs/simulate/material_gradient.h"
#include "tools/programs/simulate/simulate_summary.h"

namespace drape {
namespace {

constexpr int kReportedModes = 3;
constexpr int kLongestPiece = 20;  // steps between two reports of the progress

// The input, read and checked.
struct Input {
  explicit Input(const SimulateOptions& options)
      : camera(MakeCamera(options.camera)), scene(LoadScene(options.scene)) {
    const bool on_support = SupportRadius(scene.model->scene).has_value();
    if (!options.image.empty() && !on_support) {
      throw InputError("option 'image'", "needs a drape over a support, which the scene " +
                                             options.scene.scene + " has not");
    }
    const bool only_newton =
        options.integrator == "static" || (options.integrator == "hybrid" && options.steps == 0);
    if (only_newton && options.scene.start == "flat" && on_support) {
      throw InputError("option 'solve'", options.integrator +
                                             " without steps needs a start near the drape (a state "
                                             "or a start shape), not flat");
    }
    if (options.integrator != "dynamic" && !scene.model->scene.handles) {
      throw InputError("option 'solve'", options.integrator +
                                             " needs a scene that holds the cloth, which " +
                                             options.scene.scene + " does not");
    }
    if (!options.image.empty()) ReadImage(options);
    if (!options.gradient_weights.empty()) {
      weights = ReadLossWeights(options.gradient_weights, scene.model->num_dofs());
    }
  }

  void ReadImage(const SimulateOptions& options) {
    image = ReadSilhouette(options.image);
    if (image->width != camera.width || image->height != camera.height) {
      const auto size = [](int w, int h) { return std::to_string(w) + "×" + std::to_string(h); };
      throw InputError(options.image, "found " + size(image->width, image->height) +
                                          " pixels, expected those of the camera, " +
                                          size(camera.width, camera.height));
    }
    LOG_IF(WARNING, camera.kind == CameraKind::kPinhole)
        << "the published images were not taken by this pinhole camera: through it a perfect drape "
           "is 4-8 % too small";
  }

  Camera camera;
  LoadedScene scene;
  std::optional<GrayImage> image;
  std::optional<Eigen::VectorXd> weights;
};

void CheckOptions(const SimulateOptions& options) {
  if (options.integrator == "static" && !options.dump_steps.empty())
    throw InputError("option 'dump_steps'", "static takes no steps, expected dynamic or hybrid");
  for (const int step : options.dump_steps) {
    if (step <= options.steps) continue;
    throw InputError("option 'dump_steps'",
                     "found " + std::to_string(step) +
                         ", expected at most steps = " + std::to_string(options.steps));
  }
  const bool is_dynamic = options.integrator == "dynamic";
  if (!is_dynamic && !options.gradient_weights.empty()) {
    throw InputError("option 'gradient_weights'", "needs integrator = dynamic");
  }
}

class Simulation {
 public:
  Simulation(const SimulateOptions& options, const SimulateCallbacks& callbacks)
      : options_(options),
        callbacks_(callbacks),
        input_(options),
        backend_(MakeLoggedBackend(options.backend, input_.scene.model, 1, callbacks.log)),
        out_(options.out),
        state_(input_.scene.start) {
    step_.h = options.h;
    step_.cancel = callbacks.cancel;
    summary_.backend = backend_->name();
    summary_.seconds.emplace_back("setup", Lap());
  }

  SimulateResult Run() {
    RunSteps();
    if (options_.integrator != "dynamic" && summary_.outcome == SimulateOutcome::kDone) RunNewton();
    if (input_.weights && summary_.outcome == SimulateOutcome::kDone) RunGradient();
    WriteDrape();
    out_.Publish();
    return {summary_.outcome, summary_.status, SummaryLine(summary_)};
  }

 private:
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - lap_).count();
    lap_ = now;
    return seconds;
  }

  const MaterialField& material() const { return input_.scene.material.field; }

  void Stop(bool cancelled, const std::string& status) {
    summary_.outcome = cancelled ? SimulateOutcome::kCancelled : SimulateOutcome::kFailed;
    summary_.status = status;
  }

  void WriteStateOfStep() {
    WriteState(out_.Staged("state_" + std::to_string(summary_.steps) + ".json"), state_);
  }

  void DumpState() {
    const auto& steps = options_.dump_steps;
    if (std::find(steps.begin(), steps.end(), summary_.steps) != steps.end()) WriteStateOfStep();
  }

  // From here to the next state that is to be written.
  int NextPiece(int steps) const {
    int end = std::min(steps, summary_.steps + kLongestPiece);
    for (const int dump : options_.dump_steps)
      if (dump > summary_.steps) end = std::min(end, dump);
    return end - summary_.steps;
  }

  // On failure as far as it goes.
  RolloutStatus Advance(int steps) {
    const RolloutInput input{&material(), &state_};
    RolloutOptions piece = step_;
    piece.steps = steps;
    RolloutResult next = backend_->Rollouts({&input, 1}, piece, nullptr)[0];
    const RolloutStatus status = next.status;
    if (status == RolloutStatus::kNotFinite) {  // its end has the velocity of the step that failed
      piece.steps = next.steps;
      next = backend_->Rollouts({&input, 1}, piece, nullptr)[0];
    }
    state_ = std::move(next.end);
    summary_.steps += next.steps;
    return status;
  }

  // Rollouts one after the other are bitwise one rollout: a state is all that they hand on.
  void RunSteps() {
    const int steps = options_.integrator == "static" ? 0 : options_.steps;
    DumpState();
    while (summary_.steps < steps) {
      const RolloutStatus status = Advance(NextPiece(steps));
      if (status != RolloutStatus::kOk) {
        Stop(status == RolloutStatus::kCancelled, ToString(status));
        WriteStateOfStep();
        break;
      }
      DumpState();
      Report(steps);
    }
    summary_.seconds.emplace_back("steps", Lap());
  }

  void Report(int steps) const {
    if (!callbacks_.progress) return;
    // A gradient costs about as much as two more rollouts.
    const double share = input_.weights ? 1.0 / 3.0 : 1.0;
    callbacks_.progress(share * summary_.steps / steps,
                        "step " + std::to_string(summary_.steps) + " of " + std::to_string(steps));
  }

  EquilibriumOptions NewtonOptions() const {
    EquilibriumOptions newton;
    newton.cancel = callbacks_.cancel;
    const Scene& scene = input_.scene.model->scene;
    // The vertices of a fine strip are so light that μM matters to its membrane at this shift only.
    if (!SupportRadius(scene)) newton.shift.most = 1e12;
    if (!scene.load) return newton;
    // A pulled strip is judged by its load, beside which its weight is nothing.
    const double weight = CharacteristicForce(*input_.scene.model, material());
    newton.tolerance *= std::max(1.0, scene.load->force.norm() / weight);
    newton.residual_regime = std::numeric_limits<double>::infinity();
    return newton;
  }

  void RunNewton() {
    const bool from_rest = options_.integrator == "static" && options_.scene.start == "flat";
    const RolloutInput input{&material(), &state_};
    const EquilibriumResult rest = from_rest
                                       ? SolveFromRest(*backend_, material(), NewtonOptions())
                                       : backend_->Equilibria({&input, 1}, NewtonOptions())[0];
    summary_.newton_iterations = rest.iterations;
    summary_.status = ToString(rest.status);
    state_ = {rest.x, Eigen::VectorXd::Zero(rest.x.size())};
    const bool cancelled = rest.status == EquilibriumStatus::kCancelled;
    if (cancelled || rest.status == EquilibriumStatus::kNotConverged)
      Stop(cancelled, summary_.status);
    if (state_.x.allFinite()) WriteState(out_.Staged("state_rest.json"), state_);
    summary_.seconds.emplace_back("newton", Lap());
  }

  void RunGradient() {
    RolloutOptions all = step_;
    all.steps = options_.steps;
    const RolloutGradient gradient =
        DifferentiateRollout(*backend_, material(), input_.scene.start, all, *input_.weights);
    if (gradient.status == RolloutStatus::kOk) {
      WriteLossGradient(out_.Staged("gradient.json"), gradient);
      summary_.gradient_disagreement = gradient.Disagreement();
    } else {
      Stop(gradient.status == RolloutStatus::kCancelled,
           std::string("gradient: ") + ToString(gradient.status));
    }
    summary_.seconds.emplace_back("gradient", Lap());
  }

  void WriteDrape() {
    const Mesh& mesh = input_.scene.model->mesh;
    const GrayImage* image = input_.image ? &*input_.image : nullptr;
    summary_.force_residual = ForceResidual(*input_.scene.model, material(), state_.x);
    if (state_.x.allFinite()) {
      StepSolver solver(input_.scene.model);
      summary_.lowest_eigenvalues = LowestEigenvalues(solver, material(), state_.x, kReportedModes);
      WriteObj(out_.Staged("drape.obj"), mesh, state_.x);
      if (SupportRadius(input_.scene.model->scene)) {
        summary_.view = ViewDrape(*input_.scene.model, state_.x, input_.camera, image);
      } else {
        summary_.bench = ViewBench(*input_.scene.model, state_.x);
      }
    }
    if (summary_.view) WritePng(summary_.view->silhouette, out_.Staged("silhouette.png"));
    summary_.seconds.emplace_back("output", Lap());
    WriteSummary(out_.Staged("summary.json"), options_, input_.scene, input_.camera, summary_);
  }

  const SimulateOptions& options_;
  const SimulateCallbacks& callbacks_;
  std::chrono::steady_clock::time_point lap_ = std::chrono::steady_clock::now();
  Input input_;
  std::unique_ptr<Backend> backend_;
  OutputFolder out_;
  State state_;
  RolloutOptions step_;
  SimulateSummary summary_;
};

}  // namespace

SimulateResult Simulate(const SimulateOptions& given, const SimulateCallbacks& callbacks) {
  SimulateOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  CheckOptions(options);
  SimulateResult result = Simulation(options, callbacks).Run();
  if (!picked.empty()) result.line = picked + "\n" + result.line;
  return result;
}

}  // namespace drape
