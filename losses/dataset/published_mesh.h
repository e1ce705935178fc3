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

// The areal density [kg/m²] of a fabric of the public data set, as published with it [Gong 2024],
// for fabrics 1–25; std::nullopt for any other number.
std::optional<double> PublishedDensity(int fabric);

// A reconstructed drape of the public data set. Its surface joins the support to the outline by
// straight flaps, so that z carries no information about the cloth [MODEL, M52].
struct PublishedMesh {
  ObjSurface surface;         // as in the file [m]
  std::optional<Mesh> cloth;  // the flat cloth of the same vertices, where the file has vt
};

// Reads a published mesh. Files with vt begin them with a dummy line, which is recognised by their
// number (one more than v) and by its zeros. Files of another topology have no vt. Throws
// InputError for a malformed file.
PublishedMesh ReadPublishedMesh(const std::string& path);

// The rotation by quarters·90° counter-clockwise that brings a mesh onto an image.
struct QuarterTurn {
  int quarters = 0;       // 0 … 3
  double rms = 0;         // of the outlines after it, each about its own centre [px]
  double second_rms = 0;  // after the next best turn [px]
};

// Some published meshes are turned by 90° against their images: four of the 40 meshes of fabrics
// 1–5, which fit to 1.2–1.9 px after the turn, as the others do without one (the next best turn
// leaves 2.2 px or more). One mesh fits at no turn: it belongs to another capture. std::nullopt
// when an outline has gaps.
std::optional<QuarterTurn> FindQuarterTurn(const ObjSurface& surface, const GrayImage& image,
                                           const Camera& camera);

}  // namespace drape
