// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/scene_input.h"

#include <glog/logging.h>

#include <optional>
#include <vector>

#include "physics/cloth/scene_io.h"
#include "physics/cloth/start_shape.h"
#include "physics/cloth/state_io.h"
#include "physics/material/material_field_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

void RequireRegions(const SceneInput& input, const Scene& scene, const Mesh& mesh) {
  const auto in = [&](const Region& region, int i) {
    return Contains(region, mesh.rest_x.segment<3>(3 * i));
  };
  int held = 0;
  bool loaded = false;
  for (int i = 0; scene.handles && i < mesh.num_vertices(); ++i)
    held += in(scene.handles->region, i);
  if (scene.handles && held == 0)
    throw InputError(input.scene, "key 'handles.region': found no vertex of " + input.mesh +
                                      " in it, expected some");
  if (scene.handles && held == mesh.num_vertices())
    throw InputError(input.mesh, "found all vertices held, expected a cloth that can move");
  if (!scene.load) return;
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (std::size_t k = 0; k < loop.size(); ++k)
      loaded |=
          in(scene.load->region, loop[k]) && in(scene.load->region, loop[(k + 1) % loop.size()]);
  if (!loaded)
    throw InputError(input.scene, "key 'load.region': found no edge of the hem of " + input.mesh +
                                      " in it, expected some");
}

}  // namespace

LoadedScene LoadScene(const SceneInput& input) {
  const Law law = MakeLaw(input.law);
  const bool is_reference = !law.rejects_negative_entries();
  LoadedScene loaded;
  Mesh mesh = ParseMeshSpec(input.mesh, {.round_to_float = is_reference});
  if (!input.material.empty())
    loaded.material = ReadMaterialFor(
        mesh, input.material, {is_reference ? NegativeEntries::kWarn : NegativeEntries::kReject});
  for (const std::string& warning : loaded.material.warnings)
    LOG(WARNING) << MakePrintableLine(warning);
  const Scene scene = input.scene == "cusick" ? CusickScene() : ReadScene(input.scene);
  RequireRegions(input, scene, mesh);
  loaded.model = std::make_shared<ClothModel>(std::move(mesh), scene, law);
  const std::optional<double> support = SupportRadius(scene);
  if (input.start == "flat") {
    loaded.start = loaded.model->RestState();
  } else if (support) {
    loaded.start = ReadStart(input.start, loaded.model->mesh, *support);
  } else {
    // A start shape is made for a support.
    loaded.start = ReadState(input.start, loaded.model->mesh.num_vertices());
  }
  return loaded;
}

}  // namespace drape
