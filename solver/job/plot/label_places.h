// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/job/plot/chart.h"

namespace drape {

// Moves the names of points to the first of some places around their point, and aligns them, so
// that none lies on another one or on a point, as far as there is such a place. In the order of the
// labels, whose `at` are the points. pixels: of a unit of x and of y in the picture, about.
void PlaceAround(const Eigen::Vector2d& pixels, std::vector<ChartLabel>* labels);

}  // namespace drape
