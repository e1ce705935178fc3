// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/scene_input.h"

#include <algorithm>
#include <optional>
#include <variant>
#include <vector>

#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/scene_io.h"
#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// The vertices in each region and of each number.
void RequireHeld(const SceneInput& input, const Handles& handles, const Mesh& mesh) {
  const int count = mesh.num_vertices();
  const std::size_t regions = handles.regions.size();
  std::vector<char> held(count, 0);
  for (std::size_t r = 0; r < regions; ++r) {
    int found = 0;
    for (int i = 0; i < count; ++i) {
      if (!Contains(handles.regions[r], mesh.rest_x.segment<3>(3 * i))) continue;
      held[i] = 1;
      ++found;
    }
    const std::string which = regions == 1 ? "region" : Format("regions[%zu]", r);
    if (found == 0)
      throw InputError(input.scene, "key 'handles." + which + "': found no vertex of " +
                                        input.mesh + " in it, expected some");
  }
  for (std::size_t k = 0; k < handles.vertices.size(); ++k) {
    const int vertex = handles.vertices[k];
    if (vertex >= count)
      throw InputError(input.scene,
                       Format("key 'handles.vertices[%zu]': found %d, expected 0 to %d, the "
                              "vertices of ",
                              k, vertex, count - 1) +
                           input.mesh);
    held[vertex] = 1;
  }
  if (std::all_of(held.begin(), held.end(), [](char is_held) { return is_held != 0; }))
    throw InputError(input.mesh, "found all vertices held, expected a cloth that can move");
}

void RequireRegions(const SceneInput& input, const Scene& scene, const Mesh& mesh) {
  const auto in = [&](const Region& region, int i) {
    return Contains(region, mesh.rest_x.segment<3>(3 * i));
  };
  if (scene.handles) RequireHeld(input, *scene.handles, mesh);
  bool loaded = false;
  if (!scene.load) return;
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (std::size_t k = 0; k < loop.size(); ++k)
      loaded |=
          in(scene.load->region, loop[k]) && in(scene.load->region, loop[(k + 1) % loop.size()]);
  if (!loaded)
    throw InputError(input.scene, "key 'load.region': found no edge of the hem of " + input.mesh +
                                      " in it, expected some");
}

// Returns whether x is so deep in a mesh that its gap is not known.
bool IsDeepInMesh(const Contact& contact, const Eigen::Vector3d& x) {
  return std::any_of(
      contact.obstacles.begin(), contact.obstacles.end(), [&](const Obstacle& obstacle) {
        const auto* mesh = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle);
        return mesh != nullptr && (*mesh)->DistanceTo(x).normal.isZero() && (*mesh)->Encloses(x);
      });
}

void RequireOutside(const SceneInput& input, const Contact& contact, const State& start) {
  for (Eigen::Index i = 0; i < start.x.size() / 3; ++i) {
    const double gap = SmallestGap(contact, start.x.segment<3>(3 * i));
    if (gap <= 0.0)
      throw InputError(input.start == "flat" ? input.scene : input.start,
                       Format("found vertex %d %.3g mm in an obstacle, expected a start outside",
                              static_cast<int>(i), -1e3 * gap));
    if (IsDeepInMesh(contact, start.x.segment<3>(3 * i)))
      throw InputError(input.start == "flat" ? input.scene : input.start,
                       Format("found vertex %d deep in an obstacle that is a mesh, expected a "
                              "start outside",
                              static_cast<int>(i)));
  }
}

// Contact keeps cloth out of itself but does not take it out.
void RequireApart(const SceneInput& input, const ClothModel& model, const State& start) {
  const std::optional<SelfOverlap> overlap = FindSelfOverlap(model, start.x);
  if (!overlap) return;
  const auto& [first, second] = overlap->vertex;
  const Eigen::Vector3d place = 100.0 * start.x.segment<3>(3 * first);
  const std::string what = overlap->distance > 0.0
                               ? Format("%.3g mm from itself", 1e3 * overlap->distance)
                               : "that passes through itself";
  throw InputError(input.start == "flat" ? input.mesh : input.start,
                   "found cloth " + what +
                       Format(" near vertices %d and %d, (%.1f, %.1f, %.1f) cm, expected a start "
                              "further apart than the thickness, %g mm",
                              first, second, place.x(), place.y(), place.z(),
                              1e3 * model.scene.contact->thickness));
}

}  // namespace

void RequireOneTable(const Material& material, const std::string& option) {
  if (material.field.stretch.size() == 1 && material.field.bend.size() == 1) return;
  throw InputError("option '" + option + "'", "found a material with a table for each element (" +
                                                  material.name +
                                                  "), expected one table for the whole cloth");
}

std::shared_ptr<const ClothModel> MakeSceneModel(const SceneInput& input, Mesh mesh,
                                                 const DrapeDiscs& discs) {
  if (input.scene != "cusick" && input.contact.model != ContactModel::kNone)
    throw InputError("option 'contact'", std::string("found ") + ToString(input.contact.model) +
                                             " with the scene " + input.scene +
                                             ", expected none: a scene file lists its contact");
  const Scene scene =
      input.scene == "cusick" ? CusickScene(input.contact, discs.support) : ReadScene(input.scene);
  RequireRegions(input, scene, mesh);
  auto model = std::make_shared<const ClothModel>(std::move(mesh), scene, MakeLaw(input.law));
  RequireThinCloth(*model);
  return model;
}

void RequireFreeStart(const SceneInput& input, const ClothModel& model, const State& start) {
  if (model.scene.contact) RequireOutside(input, *model.scene.contact, start);
  RequireApart(input, model, start);
}

LoadedScene LoadScene(const SceneInput& input) {
  const Law law = MakeLaw(input.law);
  LoadedScene loaded;
  loaded.discs = FindDiscs(input.discs);
  Mesh mesh =
      ParseMeshSpec(input.mesh, {.round_to_float = !law.rejects_negative_entries()}, loaded.discs);
  if (!input.fabric.path.empty())
    loaded.fabric = ReadFabric(input.fabric.path,
                               ReadingPolicy(law, input.fabric.min_relative_stiffness), &mesh);
  for (const std::string& warning : loaded.fabric.material.warnings)
    NoteInput(input.fabric.path, warning);
  loaded.model = MakeSceneModel(input, std::move(mesh), loaded.discs);
  const std::optional<double> support = SupportRadius(loaded.model->scene);
  if (input.start == "flat") {
    loaded.start = loaded.model->RestState();
  } else if (support) {
    loaded.start = ReadStart(input.start, loaded.model->mesh, *support);
  } else {
    // A start shape is made for a support.
    loaded.start = ReadState(input.start, loaded.model->mesh.num_vertices());
  }
  RequireFreeStart(input, *loaded.model, loaded.start);
  return loaded;
}

}  // namespace drape
