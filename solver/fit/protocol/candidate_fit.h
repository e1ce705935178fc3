// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A branch while a round works on it, and what the state is to get of it.
struct CandidateTask {
  int index = 0;  // in the state
  FitCandidate branch;
  int iterations = 0;
  RolloutCounts counts;
  std::vector<std::string> log;  // lines
};

// What a round does to one branch. Several of them may run side by side.
class CandidateFitter {
 public:
  // References outlive the object; `fine` stands for problem.fine.
  CandidateFitter(const FitProblem& problem, const StagedFitOptions& options, Backend& fine,
                  const std::atomic<bool>* cancel, int round)
      : problem_(problem), options_(options), fine_(fine), cancel_(cancel), round_(round) {}

  // The drapes of the branch's seeds; without shapes where one has none that is stable.
  void Seed(CandidateTask& work) const;
  // Seeds that come nearer to their images under the material fitted so far replace the shapes.
  void Reseed(CandidateTask& work) const;
  // Without shapes afterwards when not even the start could be evaluated.
  // progress: share of the iterations.
  void Fit(CandidateTask& work, const std::function<void(double share)>& progress) const;
  // The targets with the branch's drapes as their starts.
  std::vector<Observation> WithStarts(const FitCandidate& branch) const;
  OutlineResidualOptions MakeResidualOptions() const;
  // As FitJacobian.
  Eigen::MatrixXd Jacobian(const FitCandidate& branch) const;

 private:
  bool Cancelled() const { return cancel_ != nullptr && cancel_->load(); }
  void Log(CandidateTask& work, const char* format, auto... values) const;
  Eigen::VectorXd SettledGuess(const MaterialField& material, int i, double lift,
                               CandidateTask& work) const;
  double ComputeProfileRms(int i, const Eigen::VectorXd& x) const;
  TableParametrisation Parametrisation(const FitCandidate& branch) const;
  std::optional<StripResiduals> Tests() const;
  FitOptions MakeFitOptions() const;
  void Keep(const FitSummary& summary, const std::vector<Observation>& targets,
            CandidateTask& work) const;

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  Backend& fine_;
  const std::atomic<bool>* cancel_;
  int round_;
};

}  // namespace drape
