// SPDX-License-Identifier: Apache-2.0
#include "tools/scene_input.h"

#include <glog/logging.h>

#include "physics/mesh_spec.h"
#include "physics/start_shape.h"

namespace drape {

LoadedScene LoadScene(const SceneInput& input) {
  const Law law = MakeLaw(input.law);
  const bool is_reference = !law.rejects_negative_entries();
  LoadedScene loaded;
  loaded.material = ReadMaterial(
      input.material, {is_reference ? NegativeEntries::kWarn : NegativeEntries::kReject});
  for (const std::string& warning : loaded.material.warnings) LOG(WARNING) << warning;
  Mesh mesh = ParseMeshSpec(input.mesh, {.round_to_float = is_reference});
  loaded.model = std::make_shared<ClothModel>(std::move(mesh), CusickScene(), law);
  loaded.start = input.start == "flat" ? loaded.model->RestState()
                                       : ReadStart(input.start, loaded.model->mesh,
                                                   *SupportRadius(loaded.model->scene));
  return loaded;
}

}  // namespace drape
