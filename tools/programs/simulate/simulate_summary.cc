// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/simulate/simulate_summary.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "losses/metrics/report_json.h"
#include "physics/simulation/statics/modes.h"
#include "physics/util/atomic_file.h"
#include "tools/cli/versions.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

const char* OutcomeName(SimulateOutcome outcome) {
  switch (outcome) {
    case SimulateOutcome::kDone:
      return "done";
    case SimulateOutcome::kFailed:
      return "failed";
    case SimulateOutcome::kCancelled:
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

Json BenchJson(const StripTesterView& bench) {
  Json json = {{"largest_move_m", bench.largest_move}, {"sag_m", bench.sag}};
  if (bench.strip)
    json["strip"] = {{"length_m", bench.strip->length},
                     {"drop_m", bench.strip->drop},
                     {"reach_m", bench.strip->reach},
                     {"chord_deg", bench.strip->chord},
                     {"end_stretch", bench.strip->stretch}};
  return json;
}

std::string BenchLine(const StripTesterView& bench) {
  char text[160];
  if (bench.strip) {
    std::snprintf(text, sizeof text,
                  "tip drop %.2f mm, reach %.2f mm, chord %.2f deg, end stretch %.5f, ",
                  1e3 * bench.strip->drop, 1e3 * bench.strip->reach, bench.strip->chord,
                  bench.strip->stretch);
  } else {
    std::snprintf(text, sizeof text, "sag %.3g mm, ", 1e3 * bench.sag);
  }
  return text;
}

Json SecondsJson(const SimulateSummary& summary) {
  Json seconds;
  double total = 0.0;
  for (const auto& [phase, value] : summary.seconds) {
    seconds[phase] = value;
    total += value;
  }
  seconds["total"] = total;
  return seconds;
}

Json VersionsJson() {
  Json json;
  for (const auto& [name, version] : Versions()) json[name] = version;
  return json;
}

std::string StabilityNote(const Eigen::VectorXd& lowest_eigenvalues) {
  if (lowest_eigenvalues.size() == 0) return "";
  if (!IsStable(lowest_eigenvalues)) return ", not stable";
  char note[64];
  std::snprintf(note, sizeof note, ", lowest frequency %.3g Hz",
                std::sqrt(lowest_eigenvalues[0]) / (2.0 * M_PI));
  return note;
}

}  // namespace

void WriteSummary(const std::string& path, const SimulateOptions& options, const LoadedScene& scene,
                  const Camera& camera, const SimulateSummary& summary) {
  const auto& view = summary.view;
  Json json = {{"outcome", OutcomeName(summary.outcome)},
               {"status", summary.status},
               {"dc", view ? OrNull(view->drape_coefficient) : Json(nullptr)},
               {"folds", view ? OrNull(view->folds) : Json(nullptr)},
               {"force_residual", summary.force_residual},
               {"stability", StabilityJson(summary.lowest_eigenvalues)},
               {"steps", summary.steps},
               {"steps_wanted", options.steps},
               {"time_step", options.h},
               {"solve", options.integrator},
               {"backend", summary.backend},
               {"newton_iterations", OrNull(summary.newton_iterations)},
               {"law", options.scene.law},
               {"start", options.scene.start},
               {"material", scene.material.name},
               {"density", scene.material.field.density},
               {"mesh", MeshJson(options.scene.mesh, scene.model->mesh)},
               {"camera", CameraJson(camera)}};
  if (options.scene.scene != "cusick") json["scene"] = options.scene.scene;
  if (!options.accuracy.accuracy.empty()) json["accuracy"] = options.accuracy.accuracy;
  if (summary.bench) {
    for (const char* key : {"dc", "folds", "camera"}) json.erase(key);
    json.update(BenchJson(*summary.bench));
  }
  if (view && view->metrics) {
    json["image"] = MetricsJson(*view->metrics);
    json["image"]["file"] = options.image;
  }
  if (summary.gradient_disagreement) json["gradient_disagreement"] = *summary.gradient_disagreement;
  json["seconds"] = SecondsJson(summary);
  json["versions"] = VersionsJson();
  WriteFileAtomically(path, json.dump(2) + "\n");
}

std::string SummaryLine(const SimulateSummary& summary) {
  char residual[32], dc[32] = "";
  std::snprintf(residual, sizeof residual, "%.2g", summary.force_residual);
  std::string line = summary.status + " after " + std::to_string(summary.steps) + " steps: ";
  if (summary.view) {
    if (summary.view->drape_coefficient)
      std::snprintf(dc, sizeof dc, "DC %.3f, ", *summary.view->drape_coefficient);
    line += dc;
    if (summary.view->folds) line += std::to_string(*summary.view->folds) + " folds, ";
  }
  if (summary.bench) line += BenchLine(*summary.bench);
  return line + "force residual " + residual + " of the weight" +
         StabilityNote(summary.lowest_eigenvalues);
}

}  // namespace drape
