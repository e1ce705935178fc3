// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <string>
#include <vector>

#include "physics/mesh/mesh.h"
#include "physics/util/options/field.h"
#include "solver/fit/fit.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// Smooth random fields on a flat cloth, Σ_j coefficient_j · sd_j · φ_j with normal coefficients.
// φ_j are eigenfunctions of the Laplacian with free edges, sd_j² the Matérn spectrum [Lindgren
// 2011]. They are found on one mesh and read at the points of another, so that
// coefficients mean the same on both.

// ∫∇φ·∇ψ by linear elements ("cotangent" weights) on the rest shape, shape [V, V], symmetric.
Eigen::SparseMatrix<double> LaplaceStiffness(const Mesh& mesh);

struct LaplaceModes {
  Eigen::VectorXd eigenvalues;  // ascending from 0 [1/m²], shape [count]
  Eigen::MatrixXd vectors;  // at the vertices, shape [V, count]: of mean square 1 over the cloth,
                            // orthogonal by area, first entry of largest magnitude positive
};

// The lowest modes of LaplaceStiffness against the lumped area. 1 ≤ count < V − 1; CHECKs that
// Spectra finds them.
LaplaceModes FindLaplaceModes(const Mesh& mesh, int count);

struct MaternOptions {
  double length = 0.03;  // correlation length ℓ [m]: correlation about 0.14 at a distance of 2ℓ
  double sigma = 0.5;    // standard deviation of the field, averaged over the cloth
};

// sd_j of each mode, shape [count]: sd² ∝ (2/ℓ² + eigenvalue)^−2, that is smoothness ν = 1 in the
// plane, with Σ sd² = sigma²: what the modes left out would have carried is given to those kept.
Eigen::VectorXd MaternDeviations(const Eigen::VectorXd& eigenvalues, const MaternOptions& options);

// Fields [METHODS, P24]: after the fit of one table, how the stiffness varies over the cloth.

enum class FieldBasis {
  kModes,    // smooth random fields of LaplaceModes: carry over to other meshes
  kElements  // each face and hinge on its own
};
constexpr auto EnumNames(FieldBasis) {
  return MakeNames<FieldBasis>(
      {{FieldBasis::kElements, "elements"}, {FieldBasis::kModes, "modes"}});
}

// Which entries of a table vary over the cloth, and which of them together.
enum class FieldGroups {
  kScales,   // one factor on the stretch entries of a face, one on the bend entries of a hinge
  kStretch,  // only the first
  kBend,     // only the second
  kEntries   // each entry on its own: 24 and 15 numbers per element or mode
};
constexpr auto EnumNames(FieldGroups) {
  return MakeNames<FieldGroups>({{FieldGroups::kScales, "scales"},
                                 {FieldGroups::kStretch, "stretch"},
                                 {FieldGroups::kBend, "bend"},
                                 {FieldGroups::kEntries, "entries"}});
}

struct FieldOptions {
  FieldBasis basis = FieldBasis::kElements;
  FieldGroups groups = FieldGroups::kScales;
  double sigma = 1.0;    // standard deviation of a log factor in the prior
  double length = 0.03;  // kModes: its correlation length [m]
  int modes = 60;        // kModes: how many
  int iterations = 40;   // of Ceres in each attempt
  int restarts = 3;      // attempts after the first, each from a neighbouring branch of the best

  void Check() const;  // programmer errors
};

template <MutableOrConst<FieldOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [basis, groups, sigma, length, modes, iterations, restarts] = options;
  visit(basis, Field{.key = "field_basis",
                     .doc = "model heterogeneous: each face and hinge on its own, or smooth random "
                            "fields"});
  visit(groups,
        Field{.key = "field_groups",
              .doc = "model heterogeneous, what varies: a factor on all stretch entries and "
                     "one on all bend entries, one of the two only, or each entry on its "
                     "own"});
  visit(sigma, Field{.key = "field_sigma",
                     .doc = "model heterogeneous: standard deviation of a log factor over the "
                            "cloth, in the prior",
                     .range = {.least = 1e-4, .most = 1e4}});
  visit(
      length,
      Field{.key = "field_length", .range = {.least = 0, .above_least = true}, .is_option = false});
  visit(modes, Field{.key = "field_modes",
                     .doc = "field_basis modes: number of modes",
                     .range = {.least = 1, .most = 1000}});
  visit(iterations, Field{.key = "field_iterations",
                          .doc = "model heterogeneous: iterations of Ceres for the fields, in each "
                                 "attempt",
                          .range = {.least = 0, .most = 10000}});
  visit(restarts, Field{.key = "field_restarts",
                        .doc = "model heterogeneous: attempts after the first, each from a branch "
                               "next to the best one",
                        .range = {.least = 0, .most = 1000}});
}

// One number for each of the 39 entries, the same for all elements: `sigma` its prior standard
// deviation. 24 of the stretch, then 15 of the bend entries.
std::vector<FieldTerm> CommonTerms(const Mesh& mesh, double sigma);
// CommonTerms, then standard normal noise of each element and entry, times one number for each of
// the 39 entries, in units of `sigma` [METHODS, P33].
std::vector<FieldTerm> NoiseTerms(const Mesh& mesh, double sigma, uint64_t seed);

// The terms that vary over a mesh, beside the 39 factors of the whole cloth. Modes are those of one
// disc, whatever the mesh, so that their numbers mean the same on each.
std::vector<FieldTerm> MakeFieldTerms(const Mesh& mesh, const FieldOptions& options);

struct FieldFit {
  FitSummary summary;      // θ: 39 log factors of all entries, then those of the terms
  MaterialField material;  // a table for each face and hinge
  std::vector<Eigen::VectorXd> shapes;  // the fitted drape of each observation [m], shape [3V]
  // Mean log factor of each element's entries by its prior and with the data, one standard
  // deviation, linearised at the fit (Laplace): equal where the data contain no information. Shape
  // [F], [E].
  Eigen::VectorXd prior_face, posterior_face, prior_hinge, posterior_hinge;

  int iterations = 0;  // of all attempts
  int determined = 0;  // directions of θ that the data determine better than the prior

  bool valid() const { return !shapes.empty(); }
};

// Starts from the tables and drapes of a candidate. Equilibria only (SolveMode::kStatic).
FieldFit FitFields(const FitProblem& problem, const StagedFitOptions& staged,
                   const FieldOptions& options, const FitCandidate& candidate,
                   const RunControl& control);

}  // namespace drape
