// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "losses/metrics/metrics.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"
#include "tools/programs/simulate/simulate_result.h"

namespace drape {
namespace {

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

}  // namespace

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
  if (result.simulation.gradient)
    json["gradient_disagreement"] = result.simulation.gradient->Disagreement();
  json["seconds"] = SecondsJson(result);
  WriteWithProvenance(path, std::move(json));
}

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

}  // namespace drape
