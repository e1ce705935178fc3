// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/simulate_tool.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "losses/image/segmentation.h"
#include "physics/cloth/state.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/errors.h"
#include "solver/prediction/exchange/geometry/drape_files.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/backend_option.h"
#include "tools/programs/simulate/gradient_io.h"
#include "tools/programs/simulate/simulate_summary.h"

namespace drape {
namespace {

constexpr int kReportedModes = 3;

double SecondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The input, read and checked.
struct Input {
  explicit Input(const SimulateOptions& options)
      : scene(LoadScene(options.scene)), camera(MakeCamera(options.camera, scene.discs)) {
    const bool on_support = SupportRadius(scene.model->scene).has_value();
    if (!options.image.empty() && !on_support) {
      throw InputError("option 'image'", "needs a drape over a support, which the scene " +
                                             options.scene.scene + " does not have");
    }
    const bool only_newton =
        options.solve == "static" || (options.solve == "hybrid" && options.steps == 0);
    if (only_newton && options.scene.start == "flat" && on_support) {
      throw InputError("option 'solve'", options.solve +
                                             " without steps needs a start near the drape (a state "
                                             "or a start shape), not flat");
    }
    if (options.solve != "dynamic" && !scene.model->scene.handles) {
      throw InputError("option 'solve'", options.solve +
                                             " needs a scene that holds the cloth, which " +
                                             options.scene.scene + " does not");
    }
    if (!options.image.empty()) ReadImage(options);
    if (!options.gradient_weights.empty()) {
      RequireOneTable(scene.fabric.material, "gradient_weights");
      weights = ReadLossWeights(options.gradient_weights, scene.model->num_dofs());
    }
  }

  void ReadImage(const SimulateOptions& options) {
    image = ReadSilhouette(options.image).image;
    camera = MakeCamera(options.camera, *image, scene.discs, options.image);
    LOG_IF(WARNING, options.camera.kind == CameraKind::kPinhole)
        << "the published images were not taken by this pinhole camera: a perfect drape "
           "appears 4-8 % too small in it";
  }

  LoadedScene scene;
  Camera camera;
  std::optional<GrayImage> image;
  std::optional<Eigen::VectorXd> weights;
};

void CheckOptions(const SimulateOptions& options) {
  if (options.solve == "static" && !options.dump_steps.empty())
    throw InputError("option 'dump_steps'",
                     "found solve = static, which takes no steps; expected dynamic or hybrid");
  for (const int step : options.dump_steps) {
    if (step <= options.steps) continue;
    throw InputError("option 'dump_steps'",
                     "found " + std::to_string(step) +
                         ", expected at most steps = " + std::to_string(options.steps));
  }
  for (const std::string& format : options.geometry)
    if (format != "vtu")
      throw InputError("option 'geometry'", "found " + format + ", expected vtu");
  const bool is_dynamic = options.solve == "dynamic";
  if (!is_dynamic && !options.gradient_weights.empty()) {
    throw InputError("option 'gradient_weights'",
                     "found solve = " + options.solve +
                         ", expected dynamic: the gradient is that of the time steps");
  }
}

bool Asks(const SimulateOptions& options, const std::string& format) {
  return std::find(options.geometry.begin(), options.geometry.end(), format) !=
         options.geometry.end();
}

void WriteFaces(const Input& input, const Eigen::VectorXd& x, const std::string& path) {
  const ClothModel& model = *input.scene.model;
  WriteVtu(path, model.mesh, x, ComputeFaceFields(model, input.scene.fabric.material.field, x));
}

// The end as --geometry asks for it, and the states of --dump_steps as a series.
void WriteGeometry(const SimulateOptions& options, const Input& input,
                   const SimulationResult& simulation, const OutputFolder& out) {
  const Eigen::VectorXd& x = simulation.end.x;
  if (!x.allFinite()) return;
  if (!Asks(options, "vtu")) return;
  WriteFaces(input, x, out.Staged("drape.vtu"));
  if (options.dump_steps.empty()) return;
  std::vector<TimedFile> series;
  for (const int step : options.dump_steps)
    if (step <= simulation.steps)
      series.push_back({options.h * step, "state_" + std::to_string(step) + ".vtu"});
  WritePvd(out.Staged("drape.pvd"), series);
}

SimulationTask MakeTask(const SimulateOptions& options, const Input& input,
                        const OutputFolder& out) {
  SimulationTask task;
  task.material = &input.scene.fabric.material.field;
  task.start = input.scene.start;
  task.load_path = options.solve == "static" && options.scene.start == "flat";
  task.steps = options.solve == "static" ? 0 : options.steps;
  task.h = options.h;
  task.newton = options.solve != "dynamic";
  task.stops = options.dump_steps;
  const bool with_vtu = Asks(options, "vtu");
  task.on_state = [&input, &out, with_vtu](int step, const State& state) {
    if (!state.x.allFinite() || !state.v.allFinite()) return;
    const std::string name = "state_" + std::to_string(step);
    WriteState(out.Staged(name + ".json"), state);
    if (with_vtu) WriteFaces(input, state.x, out.Staged(name + ".vtu"));
  };
  task.gradient_weights = input.weights;
  return task;
}

// What the camera or the strip's tester sees of the last shape.
void MeasureEnd(const Input& input, const RunControl& control, SimulateResult* result) {
  const ClothModel& model = *input.scene.model;
  const MaterialField& material = input.scene.fabric.material.field;
  const Eigen::VectorXd& x = result->simulation.end.x;
  result->force_residual = ForceResidual(model, material, x);
  if (!x.allFinite()) return;
  result->self_intersections = CountSelfIntersections(model.mesh, x);
  if (!control.cancelled()) {
    StepSolver solver(input.scene.model);
    result->lowest_eigenvalues =
        LowestEigenvalues(solver, material, x, kReportedModes, control.cancel);
  }
  if (SupportRadius(model.scene)) {
    result->view =
        ViewDrape(model, x, input.camera, input.scene.discs, input.image ? &*input.image : nullptr);
  } else {
    result->unsupported = ViewWithoutSupport(model, x);
  }
}

void WriteFiles(const Input& input, const SimulateResult& result, const OutputFolder& out) {
  const SimulationResult& simulation = result.simulation;
  // Of another cloth or support than the test's, the files do not say that it is one.
  std::optional<DrapeDiscs> discs;
  if (HasDiscs(*input.scene.model, input.scene.discs)) discs = input.scene.discs;
  if (simulation.end.x.allFinite() && simulation.end.v.allFinite()) {
    if (simulation.newton_iterations) WriteState(out.Staged("state_rest.json"), simulation.end);
    WriteObj(out.Staged("drape.obj"), input.scene.model->mesh, simulation.end.x, discs);
  }
  if (simulation.gradient) WriteLossGradient(out.Staged("gradient.json"), *simulation.gradient);
  if (result.view) WritePng(result.view->silhouette, out.Staged("silhouette.png"), discs);
}

SimulateResult RunChecked(const SimulateOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  const Input input(options);
  const auto backend = MakeLoggedBackend(options.backend, input.scene.model, 1, control);
  const OutputFolder out(options.out, {"summary.json", "drape.obj", "silhouette.png"});
  const double set_up = SecondsSince(begin);
  SimulateResult result;
  result.backend = backend->name();
  result.simulation = Simulate(*backend, MakeTask(options, input, out), control);
  auto& seconds = result.simulation.seconds;
  seconds.insert(seconds.begin(), {"setup", set_up});
  const auto end = std::chrono::steady_clock::now();
  MeasureEnd(input, control, &result);
  if (control.cancelled() && result.lowest_eigenvalues.size() == 0 &&
      result.simulation.outcome == SimulationOutcome::kDone) {
    result.simulation.outcome = SimulationOutcome::kCancelled;
    result.simulation.status = "cancelled before the stability of its end was known";
  }
  WriteFiles(input, result, out);
  WriteGeometry(options, input, result.simulation, out);
  seconds.emplace_back("output", SecondsSince(end));
  WriteSummary(out.Staged("summary.json"), options, input.scene, input.camera, result);
  out.Publish();
  result.line = SummaryLine(result);
  return result;
}

}  // namespace

SimulateResult RunSimulate(const SimulateOptions& given, const RunControl& control) {
  SimulateOptions options = given;
  const std::vector<std::string> seen = {given.image, given.camera.FileFor(given.image)};
  options.scene.discs = GivenDiscs(FindDiscs(given.scene.discs, seen));
  const std::string picked = ApplyAccuracy(&options);
  CheckOptions(options);
  SimulateResult result = RunChecked(options, control);
  if (!picked.empty()) result.line = picked + "\n" + result.line;
  return result;
}

namespace {

ToolOutcome Run(const SimulateOptions& options, const RunControl& control) {
  const SimulateResult result = RunSimulate(options, control);
  const SimulationResult& simulation = result.simulation;
  return {.text = result.line + "\n",
          .cancelled = simulation.outcome == SimulationOutcome::kCancelled,
          .failure = simulation.outcome == SimulationOutcome::kFailed ? simulation.status : ""};
}

}  // namespace

int SimulateMain(int argc, char** argv) { return ToolMain(argc, argv, SimulateTable, Run); }

}  // namespace drape
