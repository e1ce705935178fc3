// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A candidate while a round works on it, and what the state gets of it.
struct CandidateTask {
  int index = 0;  // in the state
  FitCandidate candidate;
  int iterations = 0;
  RolloutCounts counts;
  std::vector<std::string> log;  // lines
};

// What a round does to one candidate. Several may run side by side.
class CandidateFitter {
 public:
  // References outlive the object; `fine` takes the place of problem.fine.
  CandidateFitter(const FitProblem& problem, const StagedFitOptions& options, Backend& fine,
                  const std::atomic<bool>* cancel, int round)
      : problem_(problem), options_(options), fine_(fine), cancel_(cancel), round_(round) {}

  // Finds the drapes of the candidate's initial guess; without shapes where one is not stable.
  void SettleGuess(CandidateTask& task) const;
  // Tries all start shapes with the material fitted so far; drapes that come nearer to their images
  // replace the candidate's.
  void RetryGuesses(CandidateTask& task) const;
  // Continues a fit of an experiment on a branch that is nearer to what was measured, if pulls from
  // its drapes find one [METHODS, P58]. Returns whether the fit has improved.
  bool FitNearer(CandidateTask& task) const;
  // Takes the drapes of a fit on another mesh over to this one, where they settle under the
  // material fitted so far, guided by their images. Where one is not stable, the start shapes are
  // tried again, then smaller stretch entries of the base. Without shapes afterwards when nothing
  // is stable here.
  void CarryOver(const Mesh& from, CandidateTask& task) const;
  // Without shapes afterwards when not even the start could be evaluated.
  // progress: share of the iterations.
  void Fit(CandidateTask& task, const std::function<void(double share)>& progress) const;
  ResidualOptions MakeResidualOptions() const;
  // ∂residual/∂θ of all observations, then of all points of strips, at a candidate, shape
  // [ΣK + N, P]; empty when its drapes or strips are not stable.
  Eigen::MatrixXd Jacobian(const FitCandidate& candidate) const;

 private:
  bool Cancelled() const { return cancel_ != nullptr && cancel_->load(); }
  void Log(CandidateTask& task, const char* format, auto... values) const;
  Eigen::VectorXd Fall(const MaterialField& material, const Observation& observation, double lift,
                       CandidateTask& task) const;
  Eigen::VectorXd Rest(const MaterialField& material, Eigen::VectorXd x, CandidateTask& task) const;
  // Settles a start shape on the cloth and on its mirror image, and takes the drape whose misfit is
  // below `most` [px] and the least. Returns its misfit, or `most`.
  double SettleBest(const MaterialField& material, int i, double lift, double most,
                    CandidateTask& task) const;
  SettleOptions CancellableSettle() const;
  bool SettleNearer(int i, CandidateTask& task) const;
  void SettleCarried(const std::vector<State>& starts, CandidateTask& task) const;
  void RetryGuesses(const MaterialField& material, int i, CandidateTask& task) const;
  std::optional<double> ComputeProfileRms(const Observation& observation,
                                          const MaterialField& material,
                                          const Eigen::VectorXd& x) const;
  // Empty where a shape has no outline.
  std::vector<double> ListProfileRms(const FitCandidate& candidate) const;
  TableParametrisation Parametrisation(const FitCandidate& candidate) const;
  // Blocks of all observations, then FurtherBlocks.
  RolloutResiduals Residuals(const TableParametrisation& parametrisation,
                             const FitCandidate& candidate) const;
  FitOptions MakeFitOptions() const;
  void TakeResult(const FitSummary& summary, const std::vector<State>& drapes,
                  CandidateTask& task) const;

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  Backend& fine_;
  const std::atomic<bool>* cancel_;
  int round_;
};

// Calls CandidateFitter::Jacobian on the problem's own backend.
Eigen::MatrixXd FitJacobian(const FitProblem& problem, const StagedFitOptions& options,
                            const FitCandidate& candidate);

}  // namespace drape
