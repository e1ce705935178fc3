// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/readout/silhouette_slot.h"

namespace drape {

// From the pieces of the border to the coverage, the loss and its adjoint
// (losses/silhouette/soft_silhouette.h), item by item as in border_stages.h.
namespace silhouette {

// i: pixel.
struct ClearPixel {
  DRAPE_HD void operator()(const SilhouettePlan&, const SilhouetteSlot& s, int i) const {
    s.covered[i] = 0;
  }
};
// i: face. Several may write the same pixel: all write 1.
struct CoverPixels {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    const Face& face = plan.mesh.faces[i];
    const Vec2 a = PointAt(s.points, face.vertex[0]), b = PointAt(s.points, face.vertex[1]),
               c = PointAt(s.points, face.vertex[2]);
    const PixelRange columns = PixelsIn(std::fmin(std::fmin(a.x, b.x), c.x),
                                        std::fmax(std::fmax(a.x, b.x), c.x), plan.width);
    const PixelRange rows = PixelsIn(std::fmin(std::fmin(a.y, b.y), c.y),
                                     std::fmax(std::fmax(a.y, b.y), c.y), plan.height);
    for (int row = rows.first; row <= rows.last; ++row)
      for (int col = columns.first; col <= columns.last; ++col)
        if (Covers(s.points, face, {static_cast<double>(col), static_cast<double>(row)}))
          s.covered[row * plan.width + col] = 1;
  }
};

DRAPE_HD inline int PieceCount(const SilhouettePlan& plan, const SilhouetteSlot& s) {
  return s.piece_start[plan.max_parts()];
}
DRAPE_HD inline bool IsNear(const SilhouettePlan& plan, const SilhouetteSlot& s, int tile,
                            int piece) {
  constexpr int kSide = SilhouettePlan::kTileSide;
  const int column = tile % plan.tile_columns() * kSide, row = tile / plan.tile_columns() * kSide;
  const PieceBox box = BoundingBox(s.points, s.pieces[piece], s.half_width);
  return box.min.x <= column + kSide - 1 && box.max.x >= column && box.min.y <= row + kSide - 1 &&
         box.max.y >= row;
}
// i: tile.
struct CountNearPieces {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    int near = 0;
    for (int p = 0; p < PieceCount(plan, s); ++p) near += IsNear(plan, s, i, p) ? 1 : 0;
    s.tile_start[i] = near;
  }
};
struct PlaceNearPieces {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    int at = s.tile_start[i];
    for (int p = 0; p < PieceCount(plan, s); ++p)
      if (IsNear(plan, s, i, p)) s.tile_items[at++] = p;
  }
};

// i: a pixel's place, tile after tile, so that neighbours read the same pieces.
struct CoverSoftly {
  static DRAPE_HD int Items(const SilhouettePlan& plan) {
    return plan.tiles() * SilhouettePlan::kTileSide * SilhouettePlan::kTileSide;
  }
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    constexpr int kSide = SilhouettePlan::kTileSide;
    const int tile = i / (kSide * kSide), within = i % (kSide * kSide);
    const int col = tile % plan.tile_columns() * kSide + within % kSide;
    const int row = tile / plan.tile_columns() * kSide + within / kSide;
    if (col >= plan.width || row >= plan.height) return;
    const Vec2 at{static_cast<double>(col), static_cast<double>(row)};
    int nearest = -1;
    double distance = s.half_width;
    for (int k = s.tile_start[tile]; k < s.tile_start[tile + 1]; ++k) {
      const double d = NearestOnPiece(s.points, s.pieces[s.tile_items[k]], at).distance;
      if (d < distance) {
        distance = d;
        nearest = s.tile_items[k];
      }
    }
    const int pixel = row * plan.width + col;
    const bool inside = s.covered[pixel] != 0;
    s.contact[pixel] = nearest;
    s.coverage[pixel] =
        nearest >= 0 ? RampAt(distance, inside, s.half_width).coverage : (inside ? 1.0 : 0.0);
  }
};

// i: row of the image; sums of rows, which the last stage adds up.
struct SumRow {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    double sum = 0.0;
    for (int k = i * plan.width; k < (i + 1) * plan.width; ++k) {
      const double residual = (s.coverage[k] - s.target[k]) / s.sigma;
      sum += residual * residual;
    }
    s.row_sum[i] = sum;
  }
};
// i: 0.
struct SumLoss {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int) const {
    double sum = 0.0;
    for (int row = 0; row < plan.height; ++row) sum += s.row_sum[row];
    *s.loss = 0.5 * sum;
  }
};

// ∂L/∂(the points that hold a piece): the ends of its edge, the crossings at its own ends.
struct HolderSums {
  Vec2 vertex[2], end[2];
};
DRAPE_HD inline void AddPixel(const SilhouettePlan& plan, const SilhouetteSlot& s, int p, int pixel,
                              HolderSums* sums) {
  const SilhouettePiece& piece = s.pieces[p];
  const bool inside = s.covered[pixel] != 0;
  const Vec2 at{static_cast<double>(pixel % plan.width), static_cast<double>(pixel / plan.width)};
  const PieceContact contact = NearestOnPiece(s.points, piece, at);
  const double slope = RampAt(contact.distance, inside, s.half_width).slope;
  const double adjoint = (s.coverage[pixel] - s.target[pixel]) / (s.sigma * s.sigma);
  const Vec2 by_point = adjoint * CoverageByPoint(s.points, piece, contact, at, inside, slope);
  if (contact.end >= 0 && piece.crossing[contact.end] >= 0) {
    sums->end[contact.end] = sums->end[contact.end] + by_point;
  } else {
    sums->vertex[0] = sums->vertex[0] + (1 - contact.t) * by_point;
    sums->vertex[1] = sums->vertex[1] + contact.t * by_point;
  }
}
DRAPE_HD inline void Append(const int* vertex, const Vec2* adj_image, int count, PieceAdjoint* to) {
  for (int k = 0; k < count; ++k) {
    to->vertex[to->count] = vertex[k];
    to->adj_image[to->count++] = adj_image[k];
  }
}
// i: piece, of as many as there is room for.
struct AdjPiece {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    if (i >= PieceCount(plan, s)) return;
    const SilhouettePiece& piece = s.pieces[i];
    const PieceBox box = BoundingBox(s.points, piece, s.half_width);
    const PixelRange columns = PixelsIn(box.min.x, box.max.x, plan.width);
    const PixelRange rows = PixelsIn(box.min.y, box.max.y, plan.height);
    HolderSums sums{};
    for (int row = rows.first; row <= rows.last; ++row)
      for (int col = columns.first; col <= columns.last; ++col)
        if (const int pixel = row * plan.width + col; s.contact[pixel] == i)
          AddPixel(plan, s, i, pixel, &sums);
    PieceAdjoint& adjoint = s.adjoints[i];
    adjoint.count = 0;
    Append(piece.vertex, sums.vertex, 2, &adjoint);
    for (int end = 0; end < 2; ++end) {
      if (piece.crossing[end] < 0) continue;
      const EdgeCrossing& crossing = s.cuts[piece.crossing[end]].crossing;
      Vec2 adj_vertex[4];
      AdjCrossing(s.points, crossing, sums.end[end], adj_vertex);
      Append(crossing.vertex, adj_vertex, 4, &adjoint);
    }
  }
};
// i: vertex.
struct AdjVertex {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    Vec2 adj_image{0.0, 0.0};
    for (int p = 0; p < PieceCount(plan, s); ++p) {
      const PieceAdjoint& piece = s.adjoints[p];
      for (int k = 0; k < piece.count; ++k)
        if (piece.vertex[k] == i) adj_image = adj_image + piece.adj_image[k];
    }
    s.camera.AdjProject(s.x + 3 * i, adj_image, s.dL_dx + 3 * i);
  }
};

}  // namespace silhouette
}  // namespace drape
