// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/camera/view.h"
#include "losses/image/image.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// The hard silhouette of all triangles at positions x [m], shape [3V]: the fraction of the
// supersample² samples of each pixel that are covered. CHECKs that x is finite and in front of the
// camera.
GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample = 1);
GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample = 1);

// The point where the projections of the mesh edges a→b and c→d cross.
struct EdgeCrossing {
  int vertex[4];  // a, b, c, d
  double t[2];    // position on a→b and on c→d, in (0, 1)
};

// A part of a projected mesh edge that borders the union of all projected triangles.
struct SilhouettePiece {
  int vertex[2];           // the edge a→b
  double t[2];             // the piece runs from a + t[0](b−a) to a + t[1](b−a)
  int crossing[2];         // index of the crossing at each end, or −1 for an end at a vertex
  Eigen::Vector2d inward;  // unit normal towards the cloth
};

struct SilhouetteEdges {
  std::vector<SilhouettePiece> pieces;
  std::vector<EdgeCrossing> crossings;
};

// Finds the border of the silhouette, holes included. The candidates are the boundary edges of the
// mesh and the hinges whose faces overlap in the image. They are cut where they cross, and a part
// is kept when exactly one of its sides is covered. image_points: finite, [px], shape [2, V].
SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Eigen::Matrix2Xd& image_points);

struct SoftSilhouetteOptions {
  double half_width = 1.0;  // of the ramp around the border [px], > 0
};

// A pixel on the ramp and the derivatives of its coverage by the image points of at most four
// vertices.
struct RampPixel {
  int pixel;         // row · width + column
  int num_vertices;  // 1, 2, or 4 (the nearest point is a crossing of two edges)
  int vertex[4];
  Eigen::Vector2d d_image[4];  // ∂coverage/∂(column, row) of the vertex [1/px]
};

struct SoftSilhouette {
  int width = 0;
  int height = 0;
  Eigen::VectorXd coverage;     // row-major, shape [height · width], in [0, 1]
  std::vector<RampPixel> ramp;  // ascending by pixel
};

// The differentiable silhouette [MODEL, M48]. With φ the distance of a pixel centre to the border
// of the union of ALL projected triangles (positive inside), coverage = u²(3 − 2u) with u = ½(1 +
// φ/half_width) clamped to [0, 1]. It is C1 in φ, ½ on the border, and unbiased in area along a
// straight edge. The derivative is exact wherever the nearest border point is unique; the coverage
// jumps where a slit between two folds closes. x [m], shape [3V]. Returns false when x is not
// finite or not in front of the camera.
bool RenderSoft(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                const SoftSilhouetteOptions& options, SoftSilhouette* silhouette);

// The place of the cloth that is seen at a pixel centre.
struct SurfaceHit {
  int face = -1;                                           // −1: no cloth
  double depth = std::numeric_limits<double>::infinity();  // along the axis (DepthOrigin) [m]
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();        // of the corners of the face
};

// The first face on the ray of each pixel, by a z-buffer without tolerance: row-major, shape
// [height · width]. x [m], shape [3V]. Returns false when x is not finite or not in front of the
// camera.
bool FindVisible(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                 std::vector<SurfaceHit>* hits);

}  // namespace drape
