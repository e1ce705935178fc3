// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "physics/cloth/state.h"
#include "physics/mesh/mesh.h"

namespace drape {

// The start of a drape that decides its branch [MODEL, M37, M38]: the flat cloth, lifted beyond the
// support by z(r, θ) = ramp(r) · Σ amplitude · cos(k θ − phase), with ramp 0 at the support, 1 at
// the hem and flat at both, ramp = s²(3 − 2s).
struct StartShape {
  struct Mode {
    int k;               // waves around the hem
    double amplitude_m;  // at the hem [m]
    double phase;        // [rad]
  };
  std::vector<Mode> modes;
};

// Which modes a seed has: the fold counts of real cloth.
struct ModeRange {
  int first = 2;
  int last = 12;
};

// Positions [m], shape [3V]: rest_x plus z. r and θ are about the origin, the hem is the outermost
// vertex; vertices with r ≤ support_radius stay exactly at rest.
// Throws InputError when no vertex lies outside the support.
Eigen::VectorXd ApplyStartShape(const Mesh& mesh, double support_radius, const StartShape& shape);

// Root mean square of z around the hem [m].
double HemRms(const StartShape& shape);

// The Fourier modes of an outline r(θ_i), θ_i = 2π i/n, in metres, scaled to HemRms = hem_rms [m]:
// where the outline reaches far out the cloth is a ridge, so there it starts high.
// Throws InputError when the outline is a circle to 1e-9.
// CHECKs n > 2·last, finite radii, hem_rms ≥ 0.
StartShape GuessFromOutline(const std::vector<double>& outline, double hem_rms,
                            const ModeRange& range = {});

// Independent normal cosine and sine amplitudes of equal variance; hem_rms [m] is the root of the
// expected mean square. The same seed gives the same shape (see random.h).
StartShape RandomStartShape(uint64_t seed, double hem_rms, const ModeRange& range = {});

// Straight radial flaps under a hem seen from above at `outline` [m], shape [n] at θ_i = 2π i/n:
// the cloth beyond the support hangs down by lift · φ(θ), with φ the angle at which a straight
// flap's hem lies at r(θ). Lift 1 hits the outline where the flap's length allows it; less lift
// starts higher and leaves room for the cloth to fall into folds of its own. Positions [m], shape
// [3V]. Throws InputError when no vertex lies outside the support. CHECKs n ≥ 3 and lift in (0, 1].
Eigen::VectorXd FlapsFromOutline(const Mesh& mesh, double support_radius,
                                 const Eigen::VectorXd& outline, double lift);

// {"format": "drapefit-start-shape", "version": 1, "modes": [{"k", "amplitude_m", "phase"}, …]}.
// Throw InputError naming the file, key and index; writing is atomic and exact.
StartShape ReadStartShape(const std::string& path);
void WriteStartShape(const std::string& path, const StartShape& shape);

// What --start names: a start shape (at rest, v = 0) or a state file (state_io.h) of this mesh.
State ReadStart(const std::string& path, const Mesh& mesh, double support_radius);

}  // namespace drape
