// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "losses/readout/outline_readouts.h"
#include "losses/readout/place_readouts.h"
#include "losses/readout/readout.h"
#include "losses/readout/view_readouts.h"

namespace drape {

// The readout of every drape of a batch.
struct ReadoutChoice {
  std::string of = "positions";  // or "outline", "features", "silhouette": the readouts above
  Camera camera;                 // of outline and silhouette
  int num_angles = 360;          // of outline
  double half_width = 1.0;       // of silhouette [px]
};
// Throws InputError for an unknown name, an invalid camera and numbers that are not positive.
// `mesh` must outlive the result.
std::unique_ptr<Readout> MakeReadout(const ReadoutChoice& choice, const Mesh& mesh,
                                     const DrapeDiscs& discs);

}  // namespace drape
