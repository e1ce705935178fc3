// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "solver/studies/runner/study.h"
#include "solver/studies/stability/cases/stability_map.h"
#include "solver/studies/stability/stability_runner.h"

namespace drape {

// The stability atlas as a study. Its cells are the runs of all maps, each once, the limits of the
// explicit maps over the time step, and the damping of the implicit methods at these time steps
// where a map is of the plain drape. `runner` outlives the study. Throws InputError where a scene
// cannot be made.
Study MakeStabilityStudy(StabilityRunner& runner, const std::vector<StabilityMap>& maps,
                         const std::vector<double>& damping_h);

// The maps as scripts/stability.py reads them: axes, and the names of their cells row by row.
nlohmann::ordered_json MapsJson(const std::vector<StabilityMap>& maps);

}  // namespace drape
