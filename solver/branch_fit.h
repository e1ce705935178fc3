// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "solver/staged_fit.h"

namespace drape {

// A branch while a round works on it, and what the state is to get of it.
struct BranchWork {
  int index = 0;  // in the state
  BranchFit branch;
  int iterations = 0;
  BatchCounts counts;
  std::vector<std::string> log;  // lines
};

// What a round does to one branch. Several of them may run side by side.
class BranchFitter {
 public:
  // References outlive the object; `fine` stands for problem.fine.
  BranchFitter(const FitProblem& problem, const StagedFitOptions& options, Backend& fine,
               const std::atomic<bool>* cancel, int round)
      : problem_(problem), options_(options), fine_(fine), cancel_(cancel), round_(round) {}

  // The drapes of the branch's seeds; without shapes where one has none that is stable.
  void Seed(BranchWork& work) const;
  // Seeds that come nearer to their images under the material fitted so far replace the shapes.
  void Reseed(BranchWork& work) const;
  // Without shapes afterwards when not even the start could be evaluated.
  // progress: share of the iterations.
  void Fit(BranchWork& work, const std::function<void(double share)>& progress) const;
  // The targets with the branch's drapes as their starts.
  std::vector<Target> WithStarts(const BranchFit& branch) const;
  BatchOptions BatchOptionsOf() const;
  // As FitJacobian.
  Eigen::MatrixXd Jacobian(const BranchFit& branch) const;

 private:
  bool Cancelled() const { return cancel_ != nullptr && cancel_->load(); }
  void Log(BranchWork& work, const char* format, auto... values) const;
  Eigen::VectorXd SettledSeed(const MaterialField& material, int i, double lift,
                              BranchWork& work) const;
  double ProfileRmsOf(int i, const Eigen::VectorXd& x) const;
  TableParametrisation Parametrisation(const BranchFit& branch) const;
  std::optional<StripReadings> Tests() const;
  FitOptions FitOptionsOf() const;
  void Keep(const FitSummary& summary, const std::vector<Target>& targets,
            BranchWork& work) const;

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  Backend& fine_;
  const std::atomic<bool>* cancel_;
  int round_;
};

}  // namespace drape
