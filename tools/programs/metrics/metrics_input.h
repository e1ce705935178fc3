// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/metrics/observed_drape.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// What drape_metrics is given to compare.

enum class OperandKind {
  kFile,    // an image or an .obj mesh
  kRun,     // the folder of a drape_simulate or drape_fit run: it has a summary.json
  kFolder,  // any other folder: its images and meshes are draws of a distribution
};
// Throws InputError when there is nothing at `path`.
OperandKind KindOfOperand(const std::string& path);

struct ViewedFile {
  std::string path;
  ObservedDrape seen;
  std::optional<ObjSurface> surface;  // of a mesh [m]
};
// Throws InputError for whatever cannot be read or seen.
ViewedFile ViewFile(const std::string& path, const Camera& camera, bool hard_edged);

// The drapes of two runs that belong together: drape.obj or drape_<name>.obj of the same name, or
// the only ones. `alone` gets the others. Throws InputError when nothing belongs together.
std::vector<std::pair<std::string, std::string>> PairDrapes(const std::string& run_a,
                                                            const std::string& run_b,
                                                            std::vector<std::string>* alone);

// Images and meshes in a folder, sorted. Throws InputError for fewer than `least`.
std::vector<std::string> DrapesIn(const std::string& folder, size_t least);

}  // namespace drape
