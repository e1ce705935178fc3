// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/readout/silhouette_slot.h"

namespace drape {

// From the positions to the pieces of the silhouette's border
// (losses/silhouette/silhouette_edges.h), item by item: a stage is called for each i of its range,
// in any order or at once, and no two items write the same number. Plain host+device code: kernels
// and a test on the host run the same stages.
namespace silhouette {

// i: vertex.
struct ProjectVertex {
  DRAPE_HD void operator()(const SilhouettePlan&, const SilhouetteSlot& s, int i) const {
    const double* x = s.x + 3 * i;
    double* image = s.points + 2 * i;
    s.camera.Project(x, image);
    const bool finite = std::isfinite(x[2]) && std::isfinite(image[0]) && std::isfinite(image[1]);
    if (!finite || !s.camera.IsInFront(x)) *s.status = kUnreadable;
  }
};

// Index of candidate i among the boundary edges and hinges.
DRAPE_HD inline bool IsCandidate(const SilhouettePlan& plan, const double* points, int i,
                                 SilhouetteEdge* edge) {
  const int hinge = i - plan.mesh.num_border;
  const int* vertex = hinge < 0 ? plan.mesh.border + 2 * i : plan.mesh.hinges[hinge].vertex;
  *edge = {{vertex[0], vertex[1]}};
  if (PointAt(points, vertex[0]) == PointAt(points, vertex[1])) return false;
  return hinge < 0 || FoldsOver(points, plan.mesh.hinges[hinge]);
}
// i: edge.
struct CountEdge {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    SilhouetteEdge edge;
    s.edge_start[i] = IsCandidate(plan, s.points, i, &edge) ? 1 : 0;
  }
};
struct PlaceEdge {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    SilhouetteEdge edge;
    if (IsCandidate(plan, s.points, i, &edge)) s.edges[s.edge_start[i]] = edge;
  }
};

// Calls visit(own position, crossing) for each edge that candidate i crosses. Of two edges the
// first is always the first of the crossing, so both find the same numbers.
template <class Visit>
DRAPE_HD void ForEachCut(const SilhouettePlan& plan, const SilhouetteSlot& s, int i, Visit& visit) {
  const int count = s.edge_start[plan.edges()];
  const int* own = s.edges[i].vertex;
  const Vec2 a = PointAt(s.points, own[0]), b = PointAt(s.points, own[1]);
  const double lo = std::fmin(a.x, b.x), hi = std::fmax(a.x, b.x);
  for (int j = 0; j < count; ++j) {
    const int* other = s.edges[j].vertex;
    const double p = s.points[2 * other[0]], q = s.points[2 * other[1]];
    if (std::fmin(p, q) > hi || std::fmax(p, q) < lo || ShareVertex(own, other)) continue;
    const int *l = i < j ? own : other, *r = i < j ? other : own;
    EdgeCrossing crossing{{l[0], l[1], r[0], r[1]}, {}};
    if (Intersect(s.points, l, r, crossing.t)) visit(crossing.t[i < j ? 0 : 1], crossing);
  }
}
struct CutCounter {
  int count;
  DRAPE_HD void operator()(double, const EdgeCrossing&) { ++count; }
};
// Inserts by position; equal positions stay in the order in which they came.
struct CutInserter {
  SilhouetteCut* cuts;
  int count;
  DRAPE_HD void operator()(double t, const EdgeCrossing& crossing) {
    int at = count++;
    for (; at > 0 && t < cuts[at - 1].t; --at) cuts[at] = cuts[at - 1];
    cuts[at] = {t, crossing};
  }
};
// i: edge; those beyond the candidates have none.
struct CountCuts {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    CutCounter counter{0};
    if (i < s.edge_start[plan.edges()]) ForEachCut(plan, s, i, counter);
    s.cut_start[i] = counter.count;
  }
};
// Sorts the cuts of candidate i, and lists its parts between them.
struct PlaceCuts {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    if (i >= s.edge_start[plan.edges()]) return;
    const int first = s.cut_start[i];
    CutInserter inserter{s.cuts + first, 0};
    ForEachCut(plan, s, i, inserter);
    const int* vertex = s.edges[i].vertex;
    for (int k = 0; k <= inserter.count; ++k) {
      const bool begins = k == 0, ends = k == inserter.count;
      s.parts[i + first + k] = {
          {vertex[0], vertex[1]},
          {begins ? 0.0 : s.cuts[first + k - 1].t, ends ? 1.0 : s.cuts[first + k].t},
          {begins ? -1 : first + k - 1, ends ? -1 : first + k},
          {0.0, 0.0}};
    }
  }
};

struct AnyFaceCovers {
  const SilhouettePlan& plan;
  const double* points;
  DRAPE_HD bool operator()(const Vec2& p) const {
    for (int f = 0; f < plan.mesh.num_faces; ++f)
      if (Covers(points, plan.mesh.faces[f], p)) return true;
    return false;
  }
};
// i: part.
struct CountPiece {
  DRAPE_HD void operator()(const SilhouettePlan& plan, const SilhouetteSlot& s, int i) const {
    const int parts = s.edge_start[plan.edges()] + s.cut_start[plan.edges()];
    s.piece_start[i] =
        i < parts && FindInward(s.points, AnyFaceCovers{plan, s.points}, &s.parts[i]) ? 1 : 0;
  }
};
struct PlacePiece {
  DRAPE_HD void operator()(const SilhouettePlan&, const SilhouetteSlot& s, int i) const {
    const int at = s.piece_start[i];
    if (s.piece_start[i + 1] > at) s.pieces[at] = s.parts[i];
  }
};

}  // namespace silhouette
}  // namespace drape
