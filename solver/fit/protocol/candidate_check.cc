// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/candidate_check.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/statics.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

// By which a stored number may differ from the recomputed one, relative and absolute: what Newton's
// tolerance leaves of a drape that was solved twice.
constexpr double kTolerance = 1e-5;
// Length of an edge by its rest length: far outside what a cloth does.
constexpr double kCrushed = 0.02, kTorn = 10.0;

[[noreturn]] void Refuse(const std::string& where, const std::string& found) {
  throw InputError(where, found + ": the file is damaged or was altered");
}

void ExpectAgreement(double stored, double computed, const std::string& name,
                     const std::string& where) {
  const double most = std::max(std::abs(stored), std::abs(computed));
  if (std::abs(stored - computed) <= kTolerance * (1.0 + most)) return;
  Refuse(where, Format("found %s %g, expected %g as its shapes and theta have it", name.c_str(),
                       stored, computed));
}

void CheckTables(const MaterialField& base, const MaterialField& fitted, const std::string& where) {
  const StretchTable& stretch = fitted.stretch.front();
  const BendTable& bend = fitted.bend.front();
  const auto is_finite = [](double entry) { return std::isfinite(entry); };
  if (!std::all_of(stretch.entries(), stretch.entries() + kStretchEntries, is_finite) ||
      !std::all_of(bend.entries(), bend.entries() + kBendEntries, is_finite))
    Refuse(where, "found a theta whose tables are not finite");
  if (ResistsAllStrains(base) && !ResistsAllStrains(fitted))
    Refuse(where, "found a theta whose tables do not resist all strains");
}

bool IsCloth(const Mesh& mesh, const Eigen::VectorXd& x) {
  const auto edge = [](const Eigen::VectorXd& at, int i, int j) {
    return (at.segment<3>(3 * i) - at.segment<3>(3 * j)).norm();
  };
  return std::all_of(mesh.faces.begin(), mesh.faces.end(), [&](const Face& face) {
    for (int k = 0; k < 3; ++k) {
      const int i = face.vertex[k], j = face.vertex[(k + 1) % 3];
      const double ratio = edge(x, i, j) / edge(mesh.rest_x, i, j);
      if (!(ratio > kCrushed && ratio < kTorn)) return false;
    }
    return true;
  });
}

// The outline's distance [px].
double CheckShape(const ClothModel& model, const MaterialField& material, SolveMode mode,
                  const Eigen::VectorXd& x, const Observation& observation,
                  const std::string& where) {
  if (!IsCloth(model.mesh, x)) Refuse(where, "found a torn or crushed cloth");
  if (mode == SolveMode::kStatic && !(ForceResidual(model, material, x) <= kAtRestResidual))
    Refuse(where, "found a drape that is not at rest under its tables");
  const std::optional<double> rms = OutlineRms(model.mesh, x, observation);
  if (!rms) Refuse(where, "found a drape without an outline around the support");
  return *rms;
}

}  // namespace

void CheckCandidate(const FitProblem& problem, const StagedFitOptions& options,
                    const FitCandidate& candidate, const std::string& where) {
  const TableParametrisation parametrisation(candidate.base, options.parameters);
  CHECK_EQ(candidate.theta.size(), parametrisation.size());
  CHECK_EQ(candidate.shapes.size(), problem.observations.size());
  const MaterialField material = parametrisation.Material(candidate.theta);
  CheckTables(parametrisation.base(), material, where);
  std::vector<double> errors;
  for (std::size_t i = 0; i < candidate.shapes.size(); ++i) {
    const Observation& observation = problem.observations[i];
    errors.push_back(CheckShape(problem.fine->model(), material, options.residuals.solve_mode,
                                candidate.shapes[i], observation,
                                where + Format(", drape %zu", i + 1)));
  }
  ExpectAgreement(candidate.profile_rms, RootMeanSquare(errors), "an outline error [px] of", where);
  const std::optional<double> cost = ComputeCost(problem, options, candidate, errors);
  if (!cost)
    Refuse(where, "found a theta with which the laboratory measurements cannot be computed");
  ExpectAgreement(candidate.cost, *cost, "a cost of", where);
}

}  // namespace drape
