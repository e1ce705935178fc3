// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "physics/util/options/enum_names.h"
#include "solver/prediction/exchange/fabric_sheet.h"

namespace drape {

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
