// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// What drape_metrics is given to measure or to compare.

enum class OperandKind {
  kFile,    // an image or an .obj mesh
  kRun,     // the folder of a drape_simulate or drape_fit run: it has a summary.json
  kFolder,  // any other folder: its images and meshes are draws of a distribution
};
// Throws InputError when there is nothing at `path`.
OperandKind KindOfOperand(const std::string& path);

// How drapes are looked at.
struct View {
  CameraInput camera;
  CentreMode centre = CentreMode::kNominal;
  bool hard_edged = false;  // HardEdged
  DrapeDiscs discs = {};
};

struct ViewedFile {
  std::string path;
  ObservedDrape seen;
  Camera camera;                        // with the centre of this drape
  std::optional<ImageQuality> quality;  // of an image
  std::optional<ObjSurface> surface;    // of a mesh [m]
};
// A drape by itself. Throws InputError for whatever cannot be read or seen.
ViewedFile ViewFile(const std::string& path, const View& view);

// A drape to be compared with others that `camera` sees; with CentreMode::kOutline it is moved so
// that its centre is that of the camera. Throws InputError also for an image of another size.
ViewedFile ViewFileBeside(const std::string& path, const View& view, const Camera& camera);

// The camera of a comparison: of the size of the first image among the files, or that of a
// rendering where all are meshes.
Camera FindCamera(const CameraInput& input, const DrapeDiscs& discs,
                  const std::vector<std::string>& files);

// The drapes of two runs that belong together: drape.obj or drape_<name>.obj of the same name, or
// the only ones. `alone` gets the others. Throws InputError when nothing belongs together.
std::vector<std::pair<std::string, std::string>> PairDrapes(const std::string& run_a,
                                                            const std::string& run_b,
                                                            std::vector<std::string>* alone);

// Images and meshes in a folder, sorted. Throws InputError for fewer than `least`.
std::vector<std::string> DrapesIn(const std::string& folder, size_t least);

}  // namespace drape
