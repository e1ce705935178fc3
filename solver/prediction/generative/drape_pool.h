// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/metrics/metrics.h"
#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "solver/forward/settle.h"
#include "solver/prediction/generative/specimen_distribution.h"

namespace drape {

// Simulated drapes of specimens from all over NumberRanges. One pool serves all fabrics, since a
// fabric is a way of weighting its drapes [METHODS, P72]; a second round of drapes near what was
// inferred makes it finer for one.

inline constexpr int kPoolAngles = 72;

// What a camera above sees of a drape, as far as distributions are compared by it.
struct DrapeShape {
  FeatureVector features;  // ComputeFeatures
  Eigen::VectorXd radius;  // [m], shape [kPoolAngles], θ_i = 2π i/kPoolAngles
};
DrapeShape ComputeDrapeShape(const ObservedDrape& drape);

struct PooledDrape {
  SpecimenNumbers numbers;
  DrapeShape shape;
};

// What drapes were drawn from: uniform in NumberRanges, or an equal mixture of these distributions
// on these faces.
struct PoolRound {
  std::vector<SpecimenDistribution> around = {};
  std::vector<ClothFace> faces = {ClothFace::kUp, ClothFace::kDown};
  int drapes = 0;
};

struct DrapePool {
  std::string mesh;     // PoolOptions
  std::string setting;  // how it was simulated: "smooth law, contact none, 100 steps of 0.1 s"
  uint64_t seed = 0;
  int simulated = 0;  // with those that have no stable drape, or pass through themselves
  std::vector<PooledDrape> drapes;
  std::vector<PoolRound> rounds;

  // ln of the density from which all rounds together have drawn each drape, shape [drapes]
  // (balance heuristic [Veach 1995]).
  Eigen::VectorXd LogProposal() const;
};

struct PoolOptions {
  std::string mesh;  // its name in the pool; the backend has the mesh
  int drapes = 4096;
  uint64_t seed = 1;
  PoolRound from = {};  // its count is not used
  SettleOptions settle = {.steps = {.h = 0.1, .steps = 100}};
};

// Drape by drape, each a function of the seed and its index, after those that `begun`, a pool of
// the same options, has; independent of the threads. Fewer when control.cancel turns true.
DrapePool SimulatePool(Backend& backend, const PoolOptions& options, const RunControl& control,
                       DrapePool begun = {});

// All drapes of both, which are of one mesh and setting (CHECK).
DrapePool Join(DrapePool pool, const DrapePool& further);

// A file of some 400 bytes for each drape; lengths are rounded to 1 µm and numbers to seven digits,
// also in the result of SimulatePool, so that reading gives what was written. For pools of one
// round from all of NumberRanges (CHECK). Both throw InputError.
void WritePool(const std::string& path, const DrapePool& pool);
DrapePool ReadPool(const std::string& path);

// The pool of a file with at least options.drapes: all that it has, or those that it lacks too,
// which are added to the file, also as far as they are when they are cancelled. Throws InputError
// where the file holds a pool of another mesh, setting or seed.
DrapePool ReadOrSimulatePool(const std::string& path, Backend& backend, const PoolOptions& options,
                             const RunControl& control);

}  // namespace drape
