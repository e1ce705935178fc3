// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/prediction/garment/body/limbs.h"
#include "solver/prediction/garment/garment_mesh.h"

namespace drape {

// The tubes of a garment for single limbs, such as sleeves and legs of trousers, where its drawn
// seams put them: each begins at a boundary on one side of the plane x = 0, the cuff, and has a
// ring of cloth for each 4 cm further off in the cloth, up to that which meets the plane. x: [m],
// shape [3V].
std::vector<ClothTube> FindTubes(const SewnGarment& garment, const Eigen::VectorXd& x);

}  // namespace drape
