// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "physics/util/run_control.h"

namespace drape {

// Which of a cloth's many stable drapes one is [METHODS, P13]: what tells two apart, and how far
// apart they are.

inline constexpr int kBranchAngles = 360;

struct BranchSignature {
  int folds = 0;
  double drape_coefficient = 0.0;
  // Strongest waves of the hem's outline, amplitude·cos(k·θ − phase) [m], the largest first.
  std::vector<StartShape::Mode> modes;
};

// Outline r(θ_i) of the hem seen from above [m], θ_i = 2π i/kBranchAngles, shape [kBranchAngles].
// False when a ray meets no cloth or x is not finite. x: [m], shape [3V].
bool DrapeOutline(const Mesh& mesh, const Eigen::VectorXd& x, Eigen::VectorXd* outline);

// The signature of an outline [m], shape [n] at θ_i = 2π i/n, by the three strongest of its waves 2
// to
// 15. CHECKs n ≥ 180.
BranchSignature ComputeSignature(const Eigen::VectorXd& outline, const DrapeDiscs& discs);

// Root mean square over the vertices of the length of a vector of each; v: [3V].
double VertexRms(const Eigen::VectorXd& v);
// Root mean square distance of equal vertices [m]; a, b: [3V]. It is 0 on one branch only: turned
// and mirrored drapes are others.
double VertexDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

// Groups of items that a chain of distances ≤ tolerance links (single linkage), each ascending, in
// the order of their first members. distance: symmetric, shape [n, n].
std::vector<std::vector<int>> ClusterByDistance(const Eigen::MatrixXd& distance, double tolerance);

// The stable drapes of one fabric: random starts, each taken to rest, grouped by branch.

// A state at rest of the start shape of that seed (RandomStartShape).
State RandomStart(const ClothModel& model, int seed, double hem_rms, const DrapeDiscs& discs = {});

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
  std::string status = {};  // of the steps when they failed, else of Newton
  bool at_rest = false;     // converged, with an outline; else only seed, status and residual count
  bool stable = false;
  double residual = 0.0;  // ‖f‖ / weight
  int newton_iterations = 0;
  double energy = 0.0;           // physics/cloth/assembly/assembly.h [J]
  Eigen::VectorXd x = {};        // [m], shape [3V]
  Eigen::VectorXd outline = {};  // [m], shape [kBranchAngles]
  BranchSignature signature = {};
  GrayImage silhouette = {};  // through CameraAbove
};

// Returns drapes in the order of their seeds; fewer when *cancel turns true.
std::vector<DrapeSample> SampleEquilibria(Backend& backend, const MaterialField& material,
                                          const SamplingOptions& options,
                                          const RunControl& control);

enum class BranchMetric {
  kVertices,  // VertexDistance
  kOutline,   // MatchOutlines: as they lie,
  kRotated,   // turned,
  kMirrored   // turned and mirrored
};
constexpr auto EnumNames(BranchMetric) {
  return MakeNames<BranchMetric>({{BranchMetric::kVertices, "vertices"},
                                  {BranchMetric::kOutline, "outline"},
                                  {BranchMetric::kRotated, "rotated"},
                                  {BranchMetric::kMirrored, "mirrored"}});
}

// Samples on one branch, those of least energy first.
struct BranchCluster {
  std::vector<int> members;  // indices into the samples
  double frequency = 0.0;    // share of the samples at rest
  bool stable = true;        // all members
  double residual = 0.0;     // the largest
};
// The branches of the samples at rest: the most frequent first, then by energy. tolerance: [m].
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
