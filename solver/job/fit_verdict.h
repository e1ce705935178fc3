// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "physics/util/options/field.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// A fabric as textile laboratories report it [METHODS, P71]: bending rigidity and bending length by
// direction, shear rigidity, and what FAST and KES-FB would read.

// The logarithm of a quantity of tables of one entry for the whole cloth.
using LogQuantity = std::function<double(const MaterialField& tables)>;

// The deformation that a quantity resists. It decides which tests can have measured the quantity.
enum class Resistance { kBending, kStretching };

// How well a quantity is known: its 90 % interval, as shares of its value, and whether the data
// have narrowed that of the prior. None where the model does not vary the quantity.
struct KnownTo {
  double low = 1.0, high = 1.0;
  bool determined = false;
};
using Judgement = std::function<std::optional<KnownTo>(const LogQuantity&, Resistance)>;

// Judges by samples of a posterior of kind hierarchy. A quantity is determined where the fit has
// removed at least half of the variance of its logarithm in the prior, as in an ExchangeRecord;
// stretching only where strips have measured it, since no silhouette does (P57). bend_deviation:
// standard deviation of the logarithm of a rigidity, the model's error beside the posterior's.
Judgement JudgeByPosterior(const StoredPosterior& posterior, bool stretch_measured,
                           double bend_deviation = 0.0);

struct FabricSheetInput {
  MaterialField tables;  // one of each kind
  Law law;
  Eigen::VectorXd weights;  // StiffnessWeights of the fitted drapes, shape [39]
  bool density_is_given = false;
  DirectionNames directions = {};
};
// Rigidities are those in the drapes (LineariseInDrape); stretching and shear are those at zero
// strain, of a strip that is free to contract, and extensions are taken as linear, up to the
// largest that the instrument reads. "measured" is a bending rigidity or length of one direction
// only if the data also determine the ratio of the two. Of a fabric whose weight is not known the
// bending lengths are measured, and the rigidities as far as the assumed weight is right. Where the
// directions are a stiffer and a softer one, a row has the ratio of their rigidities.
LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge);

struct FitProblem;
struct FitReport;

// What a person may do with a fit, and which of its numbers to trust [METHODS, P57].

// A stiffness of the fitted cloth, as its drapes show it, and how well its logarithm is known.
struct StiffnessEstimate {
  double value = 0.0;            // EffectiveStretch [N/m] or EffectiveBend [N m]
  double log_deviation = 0.0;    // standard deviation, the model's error included
  double model_deviation = 0.0;  // that error: what silhouettes leave and strips do not
  bool determined = false;       // by the data; else the prior's

  // The 90 % interval is value/factor … value·factor.
  double factor() const;
};
struct StiffnessEstimates {
  StiffnessEstimate stretch, bend;
};

// The rows of a Jacobian ∂residual/∂θ, whitened by the assumed σ: of outlines, then of strips.
struct WeightedRows {
  Eigen::MatrixXd jacobian;       // shape [K, P]; no rows: the prior alone
  Eigen::Index outline_rows = 0;  // the first of them
  double outline_weight = 1.0;    // factor on the squares of the outlines' residuals
};
// Estimates by the Laplace approximation at a fitted table. What strips do not determine has the
// error that fits of silhouettes had on twins. weights: StiffnessWeights; tie: T = ∂(log
// entries)/∂θ, shape [39, P]; prior_sigma: of each θ.
StiffnessEstimates EstimateStiffness(const MaterialField& table, const Eigen::VectorXd& weights,
                                     const Eigen::MatrixXd& tie, const WeightedRows& rows,
                                     double prior_sigma);
// Judges any quantity in the same way, for the sheet of a laboratory.
Judgement JudgeByLaplace(const MaterialField& table, const Eigen::MatrixXd& tie,
                         const WeightedRows& rows, double prior_sigma);

enum class FitGrade { kGood, kUsable, kDoNotUse };
constexpr auto EnumNames(FitGrade) {
  return MakeNames<FitGrade>({{FitGrade::kGood, "good"},
                              {FitGrade::kUsable, "usable"},
                              {FitGrade::kDoNotUse, "do not use"}});
}

struct FitVerdict {
  FitGrade grade = FitGrade::kGood;
  std::vector<std::string> reasons;  // why it is not better, those of the worst grade first
};
// Judges a report that is complete but for its verdict.
FitVerdict JudgeFit(const FitProblem& problem, const FitReport& report);

// For summary.json.
nlohmann::ordered_json VerdictJson(const FitReport& report);
// For a person, one line: the grade, the outline's error, why, and what to trust to how many
// percent.
std::string VerdictLine(const FitProblem& problem, const FitReport& report);

}  // namespace drape
