// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public interface of drapefit: these five headers, to be read by their numbers. They are
// supported. The headers that they include lie in the folder `internal` of an installation and may
// change in any version.

#include "physics/cloth/cloth_model.h"        // 2. what a scene is: mesh, supports and loads, law
#include "physics/material/material_io.h"     // 1. what a fabric is: tables, density, files
#include "solver/fit/observed/observation.h"  // 4. what is observed: silhouettes, experiments
#include "solver/fit_drapes.h"                // 5. fits and posteriors in memory
#include "solver/prediction/drape_batch.h"    // 3. drapes and their derivatives in batches
