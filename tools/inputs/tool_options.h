// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/cli/option_table.h"
#include "tools/inputs/drape_view.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// Options that several programs share.

// What names the cloth: mesh, material, law.
std::vector<Option> ClothOptions(SceneInput& scene);
// The same and the first shape.
std::vector<Option> SceneOptions(SceneInput& scene);
// What sets the camera.
std::vector<Option> CameraOptions(CameraInput& camera);

template <class... Lists>
std::vector<Option> Concatenate(Lists... lists) {
  std::vector<Option> all;
  (all.insert(all.end(), lists.begin(), lists.end()), ...);
  return all;
}

}  // namespace drape
