// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

// Positions [m] and velocities [m/s] of a cloth, node-major, shape [3V] each.
struct State {
  Eigen::VectorXd x;
  Eigen::VectorXd v;
};

// Reads a state file {"x": [[x, y, z], …], "v": [[x, y, z], …]} with one triple for each vertex, in
// m and m/s. Throws InputError, naming the file, the key and the index, for a syntax error, a
// missing or unknown key, a count other than num_vertices, a triple of another length, and a number
// that is not finite.
State ReadState(const std::string& path, int num_vertices);

// Writes a state file atomically. Numbers read back bit for bit. CHECKs equal sizes. Throws
// InputError when the file cannot be written, std::domain_error for a number that is not finite.
void WriteState(const std::string& path, const State& state);

// A start shape, which decides which equilibrium a drape reaches [MODEL, M37, M38]: the flat cloth
// is lifted outside the support by z(r, θ) = ramp(r) · Σ amplitude · cos(k θ − phase). The ramp
// s²(3 − 2s) is 0 at the support, 1 at the hem and flat at both.
struct StartShape {
  struct Mode {
    int k;               // waves around the hem
    double amplitude_m;  // at the hem [m]
    double phase;        // [rad]
  };
  std::vector<Mode> modes;
};

// The modes of a start shape; the default covers the fold counts of real cloth.
struct ModeRange {
  int first = 2;
  int last = 12;
};

// Returns positions [m], shape [3V]: rest_x plus z. r and θ are measured about the origin, and the
// outermost vertex defines the hem. Vertices with r ≤ support_radius [m] stay exactly at rest.
// Throws InputError when no vertex lies outside the support.
Eigen::VectorXd ApplyStartShape(const Mesh& mesh, double support_radius, const StartShape& shape);

// The distance of the outermost rest vertex from the axis [m].
double HemRadius(const Mesh& mesh);

// The root mean square of z around the hem [m].
double HemRms(const StartShape& shape);

// Random modes with independent normal cosine and sine amplitudes of equal variance. hem_rms [m] is
// the root of the expected mean square. The same seed gives the same shape (see random.h). CHECKs
// hem_rms ≥ 0.
StartShape RandomStartShape(uint64_t seed, double hem_rms, const ModeRange& range = {});

// Straight radial flaps below a hem that is seen from above at `outline` [m], shape [n] at θ_i = 2π
// i/n [MODEL, M38]: the cloth outside the support hangs down by the angle lift · φ(θ), where φ is
// the angle at which the hem of a straight flap lies at r(θ). Lift 1 matches the outline where the
// length of the flap allows it. A smaller lift starts higher and leaves room for the cloth to form
// its own folds. Returns positions [m], shape [3V]. Throws InputError when no vertex lies outside
// the support. CHECKs n ≥ 3 and lift in (0, 1].
Eigen::VectorXd FlapsFromOutline(const Mesh& mesh, double support_radius,
                                 const Eigen::VectorXd& outline, double lift);

// Files of the form
//   {"format": "drapefit-start-shape", "version": 1, "modes": [{"k", "amplitude_m", "phase"}, …]}
// of at most 100 modes with k = 0 … 1000, amplitudes and a HemRms of at most 0.1 m, and phases of
// at most 1000 rad. Throws InputError naming the file, key and index.
StartShape ReadStartShape(const std::string& path);

// Reads the file that --start names: a start shape (at rest, v = 0) or a state of this mesh
// (state.h). Throws InputError as ReadStartShape and ReadState do, and when the file is neither.
State ReadStart(const std::string& path, const Mesh& mesh, double support_radius);

}  // namespace drape
