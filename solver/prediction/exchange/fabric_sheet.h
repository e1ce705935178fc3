// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// A fabric as textile laboratories report it [METHODS, P71]: bending rigidity and bending length by
// direction, shear rigidity, and what FAST and KES-FB would read. The rows are made here alone,
// with their intervals and origins. Verdict, page, exports and spaces of materials repeat them.

// The logarithm of a quantity of tables of one entry for the whole cloth.
using LogQuantity = std::function<double(const MaterialField& tables)>;

// The deformation that a quantity resists. It decides which tests can have measured the quantity.
enum class Resistance { kBending, kStretching };

// How well a quantity is known: its 90 % interval, as shares of its value, and whether the data
// have narrowed that of the prior. None where the model does not vary the quantity.
struct KnownTo {
  double low = 1.0, high = 1.0;
  bool determined = false;
  bool by_outlines = false;  // and not by strips
  double middle = 1.0;       // the share that is as likely too large as too small
  double left = 0.0;         // share of the prior's variance of its logarithm that is left
};
using Judgement = std::function<std::optional<KnownTo>(const LogQuantity&, Resistance)>;

// Standard deviation of the log bending stiffness that silhouettes of twins leave: shear
// stiffness, nonlinear tables and other branches make up for it [METHODS, P57].
inline constexpr double kModelDeviation = 0.3;
// The deviation about each branch, where differences of branches count apart (JudgeOverBranches).
inline constexpr double kBranchDeviation = 0.1;
inline constexpr double kQuantile90 = 1.645;  // of a normal distribution, two-sided

// Judges by samples of a posterior of kind hierarchy. A quantity is determined where the fit has
// removed at least half of the variance of its logarithm in the prior; stretching only where strips
// have measured it, since no silhouette does (P57). bend_deviation: standard deviation of the
// logarithm of a rigidity, the model's error beside the posterior's; 0 of one that counts branches
// (CountBranches), which has it.
Judgement JudgeByPosterior(const StoredPosterior& posterior, bool stretch_measured = false,
                           double bend_deviation = kModelDeviation);

// Tables that explain an image, and how much they count.
struct BranchTables {
  MaterialField tables;
  double weight = 1.0;
};
// Judges what outlines alone know of bending by a mixture over branches [METHODS, P78]: normal
// distributions of the logarithm about each branch, as wide as `judge` says. tables: of `judge`.
// Without branches it is `judge`.
Judgement JudgeOverBranches(const Judgement& judge, const MaterialField& tables,
                            const std::vector<BranchTables>& branches);

// The power of the rigidities in a quantity: 1 of a rigidity, 1/3 of a bending length.
double BendDegree(const LogQuantity& log_quantity, const MaterialField& tables);

// The side from which drapes bound the rigidity of a fabric.
enum class Bound { kNone, kAtLeast, kAtMost };
// Takes the other end off the intervals of what outlines alone know of bending. A ratio of
// rigidities is then not determined. least: the end from below, that of a cloth of this rigidity in
// all directions [N·m]; 0: that of `judge`.
Judgement JudgeByBound(const Judgement& judge, Bound bound, const MaterialField& tables,
                       double least = 0.0);

struct FabricSheetInput {
  MaterialField tables;  // one of each kind
  Law law;
  Eigen::VectorXd weights;  // StiffnessWeights of the fitted drapes, shape [39]
  bool density_is_given = false;
  DirectionNames directions = {};
  std::vector<LabMeasurement> tests = {};
};
// Rigidities are those in the drapes (LineariseInDrape); stretching and shear are those at zero
// strain, of a strip that is free to contract, and extensions are taken as linear, up to the
// largest that the instrument reads. Where cantilevers of `tests` have read the bending length of a
// direction, its rows are that reading (EstimateBending), and "overall" is the geometric mean of
// the readings of both. "measured" is another bending rigidity or length of one direction only if
// the data also determine the ratio of the two. Of a fabric whose weight is not known the bending
// lengths are measured, and the rigidities as far as the assumed weight is right. Where the
// directions are a stiffer and a softer one, a row has the ratio of their rigidities. Values are
// KnownTo::middle of those of the tables.
LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge);
// The numbers of the linear record (LinearNumbers) in the drapes, as exports have them [SI units]:
// those of the tables, which drape as they were fitted.
LaboratorySheet MakeLinearSheet(const FabricSheetInput& input, const Judgement& judge);

}  // namespace drape
