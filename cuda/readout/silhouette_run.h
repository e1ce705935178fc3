// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/readout/border_stages.h"
#include "cuda/readout/pixel_stages.h"

namespace drape {

// Which list of a slot: its `…_start`.
struct SlotStarts {
  int* SilhouetteSlot::*member;
};

// The stages of a batch of soft silhouettes in order. A runner has
//   Each(stage, items): calls stage(plan, slot, i) for i in [0, items) of each slot that is kRead;
//   Scan(start, items, room): sums before each of the counts [items] of that list, the whole sum
//   behind them; kNoRoom for a slot whose sum is more than `room`.

// Coverage; status where the shape cannot be read.
template <class Runner>
void RunCoverage(const SilhouettePlan& plan, Runner& run) {
  using namespace silhouette;
  run.Each(ProjectVertex(), plan.mesh.num_vertices);
  run.Each(CountEdge(), plan.edges());
  run.Scan({&SilhouetteSlot::edge_start}, plan.edges(), plan.edges());
  run.Each(PlaceEdge(), plan.edges());
  run.Each(CountCuts(), plan.edges());
  run.Scan({&SilhouetteSlot::cut_start}, plan.edges(), plan.max_cuts);
  run.Each(PlaceCuts(), plan.edges());
  run.Each(CountPiece(), plan.max_parts());
  run.Scan({&SilhouetteSlot::piece_start}, plan.max_parts(), plan.max_pieces);
  run.Each(PlacePiece(), plan.max_parts());
  run.Each(CountNearPieces(), plan.tiles());
  run.Scan({&SilhouetteSlot::tile_start}, plan.tiles(), plan.max_tile_items);
  run.Each(PlaceNearPieces(), plan.tiles());
  run.Each(ClearPixel(), plan.pixels());
  run.Each(CoverPixels(), plan.mesh.num_faces);
  run.Each(CoverSoftly(), CoverSoftly::Items(plan));
}

// After RunCoverage: the loss against the target, and its derivative.
template <class Runner>
void RunLoss(const SilhouettePlan& plan, Runner& run) {
  using namespace silhouette;
  run.Each(SumRow(), plan.height);
  run.Each(SumLoss(), 1);
  run.Each(AdjPiece(), plan.max_pieces);
  run.Each(AdjVertex(), plan.mesh.num_vertices);
}

}  // namespace drape
