// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// Returns 1 for each pixel whose centre is covered by a triangle, row-major, shape [height, width].
// image_points: finite, [px], shape [2, V].
std::vector<uint8_t> CoveredPixels(const Mesh& mesh, const Eigen::Matrix2Xd& image_points,
                                   int width, int height);

// The hard silhouette of all triangles at positions x [m], shape [3V]: the fraction of the
// supersample² samples of each pixel that are covered. CHECKs that x is finite and in front of the
// camera.
GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample = 1);
GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample = 1);

}  // namespace drape
