// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "physics/util/options/field.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/prediction/exchange/fabric_sheet.h"

namespace drape {

struct FitProblem;
struct FitReport;

// What a person may do with a fit, and which of its numbers to trust [METHODS, P57].

inline constexpr double kReliableK = 0.7;  // of importance weights [Vehtari 2024]
// The largest misfit of an experiment's measurement [sigma] that leaves its numbers trusted.
inline constexpr double kTrustedMisfit = 1.5;

// The rows of a Jacobian ∂residual/∂θ, whitened by the assumed σ: of outlines or experiments, then
// of strips.
struct WeightedRows {
  Eigen::MatrixXd jacobian;       // shape [K, P]; no rows: the prior alone
  Eigen::Index outline_rows = 0;  // the first of them
  double outline_weight = 1.0;    // factor on the squares of the outlines' residuals
  bool tell_stretching = false;   // they too, as experiments do
};
// Judges by the Laplace approximation at a fitted table. What strips do not determine has the error
// that fits of silhouettes had on twins, model_deviation. With `tell_stretching`, not strips alone
// determine stretching, and intervals reach further on the stiff side [METHODS, P57]. tie:
// T = ∂(log entries)/∂θ, shape [39, P], zero for numbers beside the table; prior_sigma: of each θ.
Judgement JudgeByLaplace(const MaterialField& table, const Eigen::MatrixXd& tie,
                         const WeightedRows& rows, double prior_sigma,
                         double model_deviation = kModelDeviation);

enum class FitGrade { kGood, kUsable, kDoNotUse };
constexpr auto EnumNames(FitGrade) {
  return MakeNames<FitGrade>({{FitGrade::kGood, "good"},
                              {FitGrade::kUsable, "usable"},
                              {FitGrade::kDoNotUse, "do not use"}});
}

// A part of a verdict: its worst reason decides.
struct Lamp {
  FitGrade grade = FitGrade::kGood;
  std::vector<std::string> reasons = {};  // why it is not better, those of the worst grade first
};

// Three lamps, since each can be right where another is not, and the worst of them.
struct FitVerdict {
  Lamp measurement;  // scale, outline and size of the images: the drape coefficient
  Lamp shape;        // the fitted drapes against the images and the readings of strips, at rest
  Lamp bending;      // what the fit says of the bending stiffness
  FitGrade grade = FitGrade::kGood;
  std::vector<std::string> reasons = {};  // of all lamps, as a Lamp has them
};
// Judges a report that is complete but for its verdict.
FitVerdict JudgeFit(const FitProblem& problem, const FitReport& report);

// The side from which drapes bound the bending rigidity only: from below where no image differs
// from the flat cloth by more than the outline's error, and where the initial guess lies at an edge
// of its grid and the prior holds the fit there. left: KnownTo::left of the rigidity.
Bound FindBendBound(const FitProblem& problem, const FitReport& report,
                    const InitialGuessOptions& grid, const InitialGuess& guess, double left);
// The least rigidity [N·m] of a cloth that differs from the flat one by no more than the images and
// the outline's error do: a beam of the overhang's length, clamped at the support. 0 where an image
// differs by more.
double LeastRigidityOfFlat(const FitProblem& problem, const FitReport& report);

// For summary.json: {"grade", "reasons", "lamps": {"measurement": {"grade", "reasons"}, …}}.
nlohmann::ordered_json VerdictJson(const FitVerdict& verdict);
// For a person: the drape coefficient, and a line for each lamp with what to trust.
std::string VerdictText(const FitProblem& problem, const FitReport& report);

}  // namespace drape
