// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cmath>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/studies/bench/bench_drape.h"

namespace drape {

// Work against precision: what a drape or its derivative costs with some setting, and how far it is
// from the exact answer of the model: the drape at rest on an infinitely fine mesh.

struct ReferenceOptions {
  std::string fine = "disc:4800", coarse = "disc:2400";  // the two finest meshes
  std::string relax_mesh = "disc:1200";  // on which the start relaxes; Newton continues from there,
                                         // so that both are on one branch
  double order = 2.0;                    // of the error in the size of the elements
};

// [Richardson 1911]: of a quantity q(s) = q(0) + c·s^order of the size s of the elements or steps,
// the limit q(0) from the values at s_fine and s_coarse = ratio·s_fine, ratio > 1. Scalars or
// arrays of Eigen. The error of q(s_fine) is estimated as its difference from the limit, and taken
// for the error of the limit.
template <class Quantity>
Quantity Extrapolate(const Quantity& fine, const Quantity& coarse, double ratio, double order) {
  return fine + (fine - coarse) / (std::pow(ratio, order) - 1.0);
}

// The drape and its derivative on two meshes. Newton leaves no error of the time step.
struct BenchReference {
  BenchDrape fine, coarse;
  Mesh fine_mesh, coarse_mesh;
  double ratio = 0.0, order = 2.0;  // of the elements' sizes

  // The limit of an infinitely fine mesh (Extrapolate), positions at points of the cloth, shape
  // [2, N]: [3N].
  Eigen::VectorXd PositionsAt(const Eigen::Matrix2Xd& points) const;
  Eigen::VectorXd outline() const, gradient() const;
  double area() const;  // of the silhouette [m²]
  RowMatrix jacobian() const;
};

// Throws InputError unless the second mesh of a reference is the finer one.
void CheckReference(const ReferenceOptions& options);

// Computes the drapes of a reference: {"fine", "coarse"}, or {"failure": "the drape on disc:300 is
// 'slow'"}. The law, model, material and backend are those of `setting`.
nlohmann::json FindReference(const BenchSetting& setting, const BenchProblem& problem,
                             const ReferenceOptions& options, BenchWork work,
                             const std::atomic<bool>* cancel);
// What FindReference found. Throws InputError (prefix `where`) for anything else.
BenchReference ReadReference(const nlohmann::json& found, const ReferenceOptions& options,
                             const std::string& where);

struct MeasuringOptions {
  int repeats = 3;          // at most
  double seconds = 10.0;    // and no more runs once so many seconds of wall clock are spent
  double branch_mm = 15.0;  // a drape with other folds than the reference's fine one, or whose
                            // outline, turned to match, is further from it (root mean square),
                            // is on another branch
};

// Measures one setting of a forward, gradient or jacobian work in this process: "status" ("ok",
// "other branch", "not at rest", or why there is no drape), "seconds" and "cpu_seconds" of a drape
// (the median) with "seconds_spread" and "cpu_spread" (slowest − fastest), "setup_seconds" (model,
// symbolic analysis, backend), "vertices" and "repeats". Of a drape also its errors against the
// reference: "vertex_mm", root mean square distance of the vertices, "outline_mm", of the outline
// r(θ), "radius_mm", of the radius of the circle of the silhouette's area (the error of the drape
// coefficient as a length), "dc", "dc_error", "folds", and "derivative_error", ‖d −
// d_reference‖/‖d_reference‖ of gradient or Jacobian by log entries; "force_residual" (the forces
// that remain, by the weight), "drift_mm" (the largest movement of a vertex once it is released)
// and "reference_errors" (the same errors of the reference's fine drape, an estimate of the error
// of the reference). Throws what SettingSolver throws.
nlohmann::json RunBenchSetting(BenchWork work, const BenchSetting& setting,
                               const BenchProblem& problem, const BenchReference& reference,
                               const MeasuringOptions& options, const std::atomic<bool>* cancel);

}  // namespace drape
