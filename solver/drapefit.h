// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public interface of drapefit. What these headers declare is supported; every other installed
// header may change in any version. Read them in this order.

#include "cuda/make_backend.h"             // drapes and their derivatives in batches
#include "physics/cloth/cloth_model.h"     // what a scene is: mesh, supports and loads, law
#include "physics/material/material_io.h"  // what a fabric is: tables, density, files
#include "solver/fit/observation.h"        // what is observed: silhouettes with their cameras
#include "solver/job/fit_drapes.h"         // fits and posteriors in memory
