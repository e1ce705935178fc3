// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <type_traits>

#include "cuda/kernels/cloth/mesh_view.h"
#include "cuda/readout/read_status.h"
#include "losses/readout/device_readout.h"
#include "losses/silhouette/silhouette_border.h"

namespace drape {

// What the silhouettes of a batch share: the mesh, and how much one may hold.
struct SilhouettePlan {
  static constexpr int kTileSide = 16;  // [px]

  MeshView mesh;
  int width, height;  // of the image [px]
  int max_cuts, max_pieces, max_tile_items;

  // With room for what a cloth needs that does not lie in crumples.
  static SilhouettePlan Of(const MeshView& mesh, int width, int height) {
    const int edges = mesh.num_border + mesh.num_hinges;
    return {mesh, width, height, 256 + edges, 512 + edges / 2, 4096 + 2 * edges};
  }
  DRAPE_HD int edges() const {
    return mesh.num_border + mesh.num_hinges;
  }  // that may border the silhouette
  DRAPE_HD int max_parts() const { return edges() + max_cuts; }
  DRAPE_HD int pixels() const { return width * height; }
  DRAPE_HD int tile_columns() const { return (width + kTileSide - 1) / kTileSide; }
  DRAPE_HD int tiles() const { return tile_columns() * ((height + kTileSide - 1) / kTileSide); }
};

// A mesh edge that may border the silhouette.
struct SilhouetteEdge {
  int vertex[2];
};
// A crossing as one of its two edges sees it.
struct SilhouetteCut {
  double t;  // on that edge
  EdgeCrossing crossing;
};
// ∂L/∂(image of the vertices that hold a piece): of its edge, then of the crossings at its ends.
struct PieceAdjoint {
  int count;
  int vertex[10];
  Vec2 adj_image[10];
};

// One silhouette: what is read, the workspace, what is found. Lists are filled in two passes, how
// many then where: `…_start` holds counts first, then their sums before each, so no order depends
// on the timing of threads.
struct SilhouetteSlot {
  const double* x;       // [3V]
  const double* target;  // [pixels]; null where the coverage alone is wanted
  double sigma;
  Projection camera;
  double half_width;  // [px]

  double* points;          // [2V]
  unsigned char* covered;  // [pixels] hard silhouette
  int* edge_start;         // [edges + 1]
  SilhouetteEdge* edges;   // candidates: boundary edges, then hinges that fold over
  int* cut_start;          // [edges + 1] of each candidate
  SilhouetteCut* cuts;     // by position on their edge
  int* piece_start;        // [max_parts + 1] of each part of a candidate between its cuts
  SilhouettePiece* parts;
  SilhouettePiece* pieces;  // the parts that border the cloth; crossing: index of a cut
  PieceAdjoint* adjoints;   // [pieces]
  int* tile_start;          // [tiles + 1]
  int* tile_items;          // pieces near each tile of the image, in order
  int* contact;             // [pixels] piece with the nearest point, or −1
  double* row_sum;          // [height]

  double* coverage;  // [pixels]
  double* loss;      // [1]
  double* dL_dx;     // ∂loss/∂x [3V]
  int* status;       // [1] ReadStatus
};

// Takes the workspace and the coverage of one slot; the rest is the caller's.
template <class Arena>
void TakeSilhouette(Arena& arena, const SilhouettePlan& plan, SilhouetteSlot* slot) {
  const auto take = [&](auto** part, std::size_t count) {
    *part =
        arena.template Take<std::remove_pointer_t<std::remove_reference_t<decltype(*part)>>>(count);
  };
  take(&slot->points, 2 * plan.mesh.num_vertices);
  take(&slot->covered, plan.pixels());
  take(&slot->edge_start, plan.edges() + 1);
  take(&slot->edges, plan.edges());
  take(&slot->cut_start, plan.edges() + 1);
  take(&slot->cuts, plan.max_cuts);
  take(&slot->piece_start, plan.max_parts() + 1);
  take(&slot->parts, plan.max_parts());
  take(&slot->pieces, plan.max_pieces);
  take(&slot->adjoints, plan.max_pieces);
  take(&slot->tile_start, plan.tiles() + 1);
  take(&slot->tile_items, plan.max_tile_items);
  take(&slot->contact, plan.pixels());
  take(&slot->row_sum, plan.height);
  take(&slot->coverage, plan.pixels());
}

}  // namespace drape
