// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/readouts.h"

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

std::unique_ptr<Readout> MakeReadout(const ReadoutChoice& choice, const Mesh& mesh,
                                     const DrapeDiscs& discs) {
  choice.camera.Check("camera");
  if (choice.num_angles < 1)
    throw InputError("num_angles", Format("found %d, expected at least 1", choice.num_angles));
  if (!(choice.half_width > 0.0))
    throw InputError("half_width", Format("found %g px, expected more than 0", choice.half_width));
  if (choice.of == "positions") return std::make_unique<PositionReadout>(mesh);
  if (choice.of == "outline")
    return std::make_unique<OutlineReadout>(mesh, choice.camera, choice.num_angles);
  if (choice.of == "features") return std::make_unique<FeatureReadout>(mesh, discs);
  if (choice.of == "silhouette")
    return std::make_unique<SilhouetteReadout>(mesh, choice.camera,
                                               SoftSilhouetteOptions{choice.half_width});
  throw InputError(
      "readout", "found '" + choice.of + "', expected positions, outline, features or silhouette");
}

}  // namespace drape
