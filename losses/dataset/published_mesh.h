// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// A reconstructed drape of the public data set. Its surface joins the support to the outline by
// straight flaps, so that its z says nothing of the cloth [MODEL, M52].
struct PublishedMesh {
  ObjSurface surface;         // as the file has it [m]
  std::optional<Mesh> cloth;  // the flat cloth of the same vertices, where the file has vt
};

// Reads it. The files with vt begin them with a filler, found by their number (one more than v) and
// its zeros; those of another topology have no vt. Throws InputError for a malformed file.
PublishedMesh ReadPublishedMesh(const std::string& path);

// The turn by quarters·90° counter-clockwise that brings a mesh onto an image.
struct QuarterTurn {
  int quarters = 0;       // 0 … 3
  double rms = 0;         // of the outlines after it, each about its own centre [px]
  double second_rms = 0;  // after the next best turn [px]
};

// Some published meshes are turned by 90° against their images: of the 40 of fabrics 1–5 four,
// which then fit to 1.2–1.9 px as the others do (next turn: 2.2 px or more), and one fits at no
// turn: it is that of another capture. None when an outline has gaps.
std::optional<QuarterTurn> FindQuarterTurn(const ObjSurface& surface, const GrayImage& image,
                                           const Camera& camera);

}  // namespace drape
