// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "losses/metrics/distribution_metrics.h"
#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "solver/forward/branch.h"

namespace drape {

// The stable drapes of one fabric: random starts, each taken to rest, grouped by branch.

struct SamplingOptions {
  int samples = 32;
  int first_seed = 1;     // of RandomStartShape; the others follow
  double hem_rms = 3e-3;  // of the start shapes [m]
  double h = 0.1;         // time step [s]
  int steps = 100;        // before Newton
  int threads = 1;        // ≥ 1
  DrapeDiscs discs = {};  // of the cloth
};

// One random start and where it came to rest.
struct DrapeSample {
  int seed = 0;
  std::string status;    // of the steps when they failed, else of Newton
  bool at_rest = false;  // converged, with an outline; else only seed, status and residual count
  bool stable = false;
  double residual = 0.0;  // ‖f‖ / weight
  int newton_iterations = 0;
  double energy = 0.0;      // physics/cloth/assembly/assembly.h [J]
  Eigen::VectorXd x;        // [m], shape [3V]
  Eigen::VectorXd outline;  // [m], shape [kBranchAngles]
  BranchSignature signature;
  GrayImage silhouette;  // through CameraAbove
};

// In the order of their seeds; fewer when *cancel turns true.
std::vector<DrapeSample> SampleEquilibria(Backend& backend, const MaterialField& material,
                                          const SamplingOptions& options,
                                          const RunControl& control);

enum class BranchMetric {
  kVertices,  // VertexDistance
  kOutline,   // MatchOutlines: as they lie,
  kRotated,   // turned,
  kMirrored   // turned and mirrored
};
// "vertices", "outline", "rotated" or "mirrored". Throws InputError for any other.
BranchMetric ParseBranchMetric(const std::string& text);
double BranchDistance(const DrapeSample& a, const DrapeSample& b, BranchMetric metric);  // [m]

// Samples on one branch, those of least energy first.
struct BranchCluster {
  std::vector<int> members;  // indices into the samples
  double frequency = 0.0;    // share of the samples at rest
  bool stable = true;        // all members
  double residual = 0.0;     // the largest
};
// Of the samples at rest; the most frequent first, then by energy. tolerance: [m].
std::vector<BranchCluster> ClusterSamples(const std::vector<DrapeSample>& samples,
                                          BranchMetric metric, double tolerance);

// How chaotic the drape is: over the samples at rest, or over all pairs of them.
struct BranchSpread {
  int drapes = 0;
  Spread drape_coefficient, folds;
  Spread outline_rms;     // of pairs [m]
  Spread silhouette_mse;  // of pairs
};
BranchSpread ComputeSpread(const std::vector<DrapeSample>& samples);

}  // namespace drape
