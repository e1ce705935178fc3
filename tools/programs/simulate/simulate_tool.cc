// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/simulate_tool.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/forward/simulation.h"
#include "solver/prediction/exchange/geometry/drape_files.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

// A drape as the camera sees it.
struct DrapeView {
  GrayImage silhouette;                     // coverage by 4×4 samples a pixel
  std::optional<double> drape_coefficient;  // by the area of the coverage; none for a cloth or a
                                            // support of other radii than the discs', and with a
                                            // fault
  std::string fault;                        // why this is no picture of a drape: "tangled" (its
                                            // area is less than the support's or more than the
                                            // cloth's), "not all in the picture", "too small in the
                                            // picture"; or empty
  std::optional<int> folds;                 // none where the outline has gaps
  std::optional<SilhouetteMetrics> metrics;  // against an image, where one is given
};

// Measurements of a cloth that lies on no support: a strip or a plate.
struct StripView {
  double length;       // at rest, from the last held vertex to the far end along x [m]
  double drop, reach;  // of the tip below and beyond the last held vertex [m]
  double chord;        // angle of the tip below the horizontal, seen from there [°]
  double stretch;      // distance of the tip from there by `length`
};
struct UnsupportedView {
  double largest_move;             // of a vertex from rest [m]
  double sag;                      // of the lowest vertex below rest [m]
  std::optional<StripView> strip;  // where the scene holds a half-plane along x
};

// The results of drape_simulate, for its summary.
struct SimulateResult {
  SimulationResult simulation;
  std::string backend;                         // Backend::name
  double force_residual = 0.0;                 // ‖f‖ / weight of the last shape
  int self_intersections = 0;                  // of the last shape (CountSelfIntersections)
  Eigen::VectorXd lowest_eigenvalues;          // of K by mass there [s⁻²]; empty: not found
  std::optional<DrapeView> view;               // of the last shape on a support
  std::optional<UnsupportedView> unsupported;  // of the last shape without one
  std::string line;                            // the drape in one line, for a person
};

constexpr int kAngles = 360, kSupersample = 4;
constexpr double kFarthest = 1e6;  // [px] from the corner: what has flown off is no drape

// A coarse mesh may hang a little inside the support's circle.
constexpr double kSlack = 0.03;  // of the drape coefficient

constexpr double kLeastExtent = 8.0;  // [px]

Eigen::Vector2d Extent(const Eigen::Matrix2Xd& image_points) {
  return image_points.rowwise().maxCoeff() - image_points.rowwise().minCoeff();
}

bool IsInPicture(const Eigen::Matrix2Xd& image_points, const Camera& camera) {
  const Eigen::Array2d least = image_points.rowwise().minCoeff();
  const Eigen::Array2d most = image_points.rowwise().maxCoeff();
  return least.minCoeff() >= -0.5 && most.x() <= camera.width - 0.5 &&
         most.y() <= camera.height - 0.5;
}

// The area of the drape's vertical projection [m²], which a pinhole's silhouette is not.
double VerticalArea(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    const DrapeDiscs& discs, const GrayImage& silhouette) {
  if (camera.kind == CameraKind::kOrthographic) return CoverageArea(silhouette, camera);
  const Camera above = CameraAbove(discs);
  return CoverageArea(Rasterize(mesh, x, above, kSupersample), above);
}

constexpr double kRounding = 1e-9;  // [m]

std::optional<StripView> ViewStrip(const ClothModel& model, const Eigen::VectorXd& x) {
  const auto* held = std::get_if<HalfPlaneRegion>(OnlyHeldRegion(model.scene));
  if (held == nullptr || held->normal.x() < 1.0 - kRounding) return {};
  const Eigen::VectorXd& rest = model.mesh.rest_x;
  double clamp = -std::numeric_limits<double>::infinity(), end = clamp;
  for (const int i : model.held) clamp = std::max(clamp, rest[3 * i]);
  for (int i = 0; i < model.mesh.num_vertices(); ++i) end = std::max(end, rest[3 * i]);
  if (!(end > clamp + kRounding)) return {};
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  int count = 0;
  for (int i = 0; i < model.mesh.num_vertices(); ++i) {
    if (rest[3 * i] < end - kRounding) continue;
    tip += x.segment<3>(3 * i);
    ++count;
  }
  tip /= count;
  StripView view;
  view.length = end - clamp;
  view.drop = -tip.z();
  view.reach = tip.x() - clamp;
  view.chord = std::atan2(view.drop, view.reach) * 180.0 / M_PI;
  view.stretch = std::hypot(view.drop, view.reach) / view.length;
  return view;
}

// x: positions [m], shape [3V]; image: of the camera's size, or nullptr. None when the cloth is not
// in front of the camera or a million pixels away.
std::optional<DrapeView> ViewDrape(const ClothModel& model, const Eigen::VectorXd& x,
                                   const Camera& camera, const DrapeDiscs& discs,
                                   const GrayImage* image) {
  const Mesh& mesh = model.mesh;
  Eigen::Matrix2Xd image_points;
  if (!ProjectVertices(x, camera, &image_points)) return {};
  if (image_points.cwiseAbs().maxCoeff() > kFarthest) return {};
  DrapeView view;
  view.silhouette = Rasterize(mesh, x, camera, kSupersample);
  if (!IsInPicture(image_points, camera)) {
    view.fault = "not all in the picture";
  } else if (Extent(image_points).minCoeff() < kLeastExtent) {
    view.fault = "too small in the picture";
  } else if (HasDiscs(model, discs)) {
    const double coefficient =
        DrapeCoefficient(VerticalArea(mesh, x, camera, discs, view.silhouette), discs);
    if (coefficient > -kSlack && coefficient < 1.0 + kSlack) {
      view.drape_coefficient = coefficient;
    } else {
      view.fault = "tangled";
    }
  }
  if (!view.fault.empty()) return view;
  Outline fitted, measured;
  if (!OutlineFromMesh(mesh, x, camera, kAngles, &fitted)) return view;
  view.folds = CountFolds(VerticalProfile(fitted.radius, camera, discs));
  if (image != nullptr && OutlineFromImage(*image, camera, kAngles, &measured)) {
    view.metrics =
        CompareSilhouettes(*image, measured.radius, view.silhouette, fitted.radius, camera, discs);
  }
  return view;
}

// x: positions [m], shape [3V].
UnsupportedView ViewWithoutSupport(const ClothModel& model, const Eigen::VectorXd& x) {
  UnsupportedView view{0.0, 0.0, ViewStrip(model, x)};
  for (int i = 0; i < model.mesh.num_vertices(); ++i) {
    const Eigen::Vector3d move = x.segment<3>(3 * i) - model.mesh.rest_x.segment<3>(3 * i);
    view.largest_move = std::max(view.largest_move, move.norm());
    view.sag = std::max(view.sag, -move.z());
  }
  return view;
}

using Json = nlohmann::ordered_json;

const char* OutcomeName(SimulationOutcome outcome) {
  switch (outcome) {
    case SimulationOutcome::kDone:
      return "done";
    case SimulationOutcome::kFailed:
      return "failed";
    case SimulationOutcome::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json MeshJson(const std::string& name, const Mesh& mesh) {
  return {{"name", name},
          {"vertices", mesh.num_vertices()},
          {"faces", mesh.num_faces()},
          {"hinges", mesh.num_hinges()}};
}

Json UnsupportedJson(const UnsupportedView& unsupported) {
  Json json = {{"largest_move_m", unsupported.largest_move}, {"sag_m", unsupported.sag}};
  if (unsupported.strip)
    json["strip"] = {{"length_m", unsupported.strip->length},
                     {"drop_m", unsupported.strip->drop},
                     {"reach_m", unsupported.strip->reach},
                     {"chord_deg", unsupported.strip->chord},
                     {"end_stretch", unsupported.strip->stretch}};
  return json;
}

std::string UnsupportedLine(const UnsupportedView& unsupported) {
  if (!unsupported.strip) return Format("sag %.3g mm, ", 1e3 * unsupported.sag);
  return Format("tip drop %.2f mm, reach %.2f mm, chord %.2f deg, end stretch %.5f, ",
                1e3 * unsupported.strip->drop, 1e3 * unsupported.strip->reach,
                unsupported.strip->chord, unsupported.strip->stretch);
}

std::string ViewLine(const DrapeView& view) {
  if (!view.fault.empty()) return "no drape (" + view.fault + "), ";
  std::string line;
  if (view.drape_coefficient) line += Format("DC %.3f, ", *view.drape_coefficient);
  if (view.folds) line += std::to_string(*view.folds) + " folds, ";
  return line;
}

Json SecondsJson(const SimulateResult& result) {
  Json seconds;
  double total = 0.0;
  for (const auto& [phase, value] : result.simulation.seconds) {
    seconds[phase] = value;
    total += value;
  }
  seconds["total"] = total;
  return seconds;
}

std::string StabilityNote(const Eigen::VectorXd& lowest_eigenvalues) {
  if (lowest_eigenvalues.size() == 0) return "";
  if (!IsStable(lowest_eigenvalues)) return ", not stable";
  return Format(", lowest frequency %.3g Hz", std::sqrt(lowest_eigenvalues[0]) / (2.0 * M_PI));
}

void WriteSummary(const std::string& path, const SimulateOptions& options, const LoadedScene& scene,
                  const Camera& camera, const SimulateResult& result) {
  const auto& view = result.view;
  Json json = {{"outcome", OutcomeName(result.simulation.outcome)},
               {"status", result.simulation.status},
               {"dc", view ? OrNull(view->drape_coefficient) : Json(nullptr)},
               {"folds", view ? OrNull(view->folds) : Json(nullptr)},
               {"fault", view && !view->fault.empty() ? Json(view->fault) : Json(nullptr)},
               {"force_residual",
                std::isfinite(result.force_residual) ? Json(result.force_residual) : Json(nullptr)},
               {"stability", StabilityJson(result.lowest_eigenvalues)},
               {"self_intersections", result.self_intersections},
               {"steps", result.simulation.steps},
               {"steps_wanted", options.steps},
               {"time_step", options.h},
               {"solve", options.solve},
               {"backend", result.backend},
               {"newton_iterations", OrNull(result.simulation.newton_iterations)},
               {"law", options.scene.law},
               {"start", options.scene.start},
               {"material", scene.fabric.material.name},
               {"density", scene.fabric.material.field.density},
               {"mesh", MeshJson(options.scene.mesh, scene.model->mesh)},
               {"camera", CameraJson(camera)}};
  if (HasDiscs(*scene.model, scene.discs)) json.update(DiscsJson(scene.discs));
  if (options.scene.scene != "cusick") json["scene"] = options.scene.scene;
  if (const std::optional<Contact>& contact = scene.model->scene.contact) {
    json["contact"] = {{"thickness_m", contact->thickness},
                       {"smallest_gap_m", SmallestGap(*contact, result.simulation.end.x)}};
    if (contact->self)
      json["contact"]["smallest_self_gap_m"] =
          SmallestSelfGap(*scene.model, result.simulation.end.x);
  }
  if (!options.accuracy.accuracy.empty()) json["accuracy"] = options.accuracy.accuracy;
  if (result.unsupported) {
    for (const char* key : {"dc", "folds", "fault", "camera"}) json.erase(key);
    json.update(UnsupportedJson(*result.unsupported));
  }
  if (view && view->metrics) {
    json["image"] = MetricsJson(*view->metrics);
    json["image"]["file"] = options.image;
  }
  json["seconds"] = SecondsJson(result);
  WriteWithProvenance(path, std::move(json));
}

// "ok after 100 steps: DC 0.413, 8 folds, force residual 1.2e-05 of the weight, lowest frequency
// 0.91 Hz", or "not stable" instead of the last.
std::string SummaryLine(const SimulateResult& result) {
  std::string line =
      result.simulation.status + " after " + std::to_string(result.simulation.steps) + " steps: ";
  if (!std::isfinite(result.force_residual)) return line + "no drape (its forces overflow)";
  if (result.view) line += ViewLine(*result.view);
  if (result.unsupported) line += UnsupportedLine(*result.unsupported);
  return line + Format("force residual %.2g of the weight", result.force_residual) +
         StabilityNote(result.lowest_eigenvalues) +
         (result.self_intersections > 0 ? ", passes through itself" : "");
}

// Sets the options that the user has not given from --accuracy and says in one line what was picked
// and which error to expect; empty without --accuracy. Throws InputError for an accuracy that the
// table does not have, or for another scene than the drape test.
std::string ApplyAccuracy(SimulateOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  if (options->scene.scene != "cusick")
    throw InputError("option 'accuracy'", "found the scene " + options->scene.scene +
                                              ", expected cusick: the table is of the drape test");
  const bool has_solve = choice.given.contains("solve");
  if (has_solve && options->solve == "static")
    throw InputError("option 'accuracy'", "found solve = static, expected hybrid");
  const AccuracyRow row = PickAccuracy(choice, has_solve ? options->solve : "");
  AccuracyFilling filling(choice);
  filling.Set("mesh", row.mesh, &options->scene.mesh);
  filling.Set("solve", row.integrator, &options->solve);
  filling.Set("time_step", row.h, &options->h);
  filling.Set("steps", row.steps, &options->steps);
  return filling.Line(row);
}

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
  return task;
}

// Measures the last shape as the camera or a tester of strips sees it.
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
  // The files name the discs only where cloth and support are discs of the test.
  std::optional<DrapeDiscs> discs;
  if (HasDiscs(*input.scene.model, input.scene.discs)) discs = input.scene.discs;
  if (simulation.end.x.allFinite() && simulation.end.v.allFinite()) {
    if (simulation.newton_iterations) WriteState(out.Staged("state_rest.json"), simulation.end);
    WriteObj(out.Staged("drape.obj"), input.scene.model->mesh, simulation.end.x, discs);
  }
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

std::vector<Option> FileOptions(SimulateOptions& options) {
  return {
      PathOption("image", &options.image, "silhouette (JPEG or PNG) to compare the drape with"),
      NumberOption("dump_steps", &options.dump_steps, 0, kUnlimited,
                   "steps whose states are written to state_<step>.json; 0: the start"),
      ChoiceOption(
          "geometry", &options.geometry, {"vtu"},
          "vtu: further files of the drape with strain, tension and stiffness of each face, for "
          "ParaView; with dump_steps a series drape.pvd"),
      OutOption(options.out),
  };
}

}  // namespace

OptionTable SimulateTable(SimulateOptions& options) {
  const std::vector<Option> steps = {
      ChoiceOption(
          "solve", &options.solve, {"dynamic", "hybrid", "static"},
          "method: time steps (dynamic), time steps followed by Newton's method (hybrid), or "
          "Newton's method from --start (static)"),
      TimeStepOption(&options.h),
      NumberOption("steps", &options.steps, 0, 1000000, "number of time steps"),
      BackendOption(options.backend),
  };
  return {.tool = "drape_simulate",
          .summary =
              "simulates one drape of a fabric, over the support of the Cusick test or in another "
              "scene",
          .example =
              "drape_simulate --mesh=disc:1200 --fabric=configs/fabrics/cotton_blue.json "
              "--steps=100 --dump_steps=10,100 --out=out/drape",
          .notes =
              "files: summary.json (outcome, drape coefficient, folds, force residual, metrics), "
              "drape.obj, silhouette.png, state_<step>.json, state_rest.json (hybrid and static), "
              "with --geometry drape.vtu. They replace the files of an "
              "earlier run together, at the end.\n"
              "exit code 3: the computation failed (outcome and status in summary.json); the files "
              "show the last good shape\n",
          .options = Concatenate(
              Grouped("cloth and scene", FieldOptionList(options.scene)),
              Grouped("simulation", Concatenate(steps, AccuracyOptions(options.accuracy))),
              Grouped("camera", FieldOptionList(options.camera)),
              Grouped("files", FileOptions(options))),
          .common = {"mesh", "fabric", "specimen", "support", "start", "scene", "solve",
                     "time_step", "steps", "accuracy", "image", "out"},
          .given = &options.accuracy.given};
}

namespace {

ToolOutcome Run(const SimulateOptions& given, const RunControl& control) {
  SimulateOptions options = given;
  const std::vector<std::string> seen = {given.image, given.camera.FileFor(given.image)};
  options.scene.discs = GivenDiscs(FindDiscs(given.scene.discs, seen));
  const std::string picked = ApplyAccuracy(&options);
  CheckOptions(options);
  const SimulateResult result = RunChecked(options, control);
  const SimulationResult& simulation = result.simulation;
  return {.text = (picked.empty() ? "" : picked + "\n") + result.line + "\n",
          .cancelled = simulation.outcome == SimulationOutcome::kCancelled,
          .failure = simulation.outcome == SimulationOutcome::kFailed ? simulation.status : ""};
}

}  // namespace

int SimulateMain(int argc, char** argv) { return ToolMain(argc, argv, SimulateTable, Run); }

}  // namespace drape
