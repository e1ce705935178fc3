// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/fit/protocol/candidate_fit.h"
#include "solver/posterior/posterior_fit.h"

namespace drape {

// What the posteriors of all models begin with: from a branch to the mode of the fabric's numbers
// and σ of the outline, by turns, and then the draws about it.
class MapEstimator {
 public:
  // References outlive the object. The result gathers in *fit.
  MapEstimator(const FitProblem& problem, const StagedFitOptions& staged,
               const PosteriorOptions& options, const FitCandidate& branch,
               const StagedFitCallbacks& callbacks, PosteriorFit* fit);

  // Fills hierarchy, specimen, mode, sigma_px, counts. False when there is none.
  [[nodiscard]] bool Find();
  // Fills materials and shapes: the drapes of the fabric's numbers u, or where the way there from
  // the mode ends, those of the mode. False when they do not stand either.
  [[nodiscard]] bool KeepDrapes(Eigen::VectorXd u);

  // Draws of the hierarchy, from the drapes of the mode.
  HierarchicalSamples MakeSamples(int count, LostBranchPolicy beyond) const;
  // The targets of each specimen, with the drapes of the mode as starts.
  const std::vector<std::vector<Observation>>& targets() const { return targets_; }
  OutlineResidualOptions MakeResidualOptions() const;
  // from, to: the share of the progress.
  VariationalOptions MakeOptions(SampleKind kind, int iterations, double from, double to) const;
  bool Cancelled() const { return callbacks_.cancel != nullptr && callbacks_.cancel->load(); }

  static constexpr double kModeShare = 0.3, kFitShare = 0.95;  // of the time

 private:
  void SetHierarchy(const FitCandidate& branch);
  void SetObservations(const FitCandidate& branch);
  bool FindOnce(int round, int rounds);
  void StartFrom(const std::vector<Eigen::VectorXd>& shapes);
  void LearnSigma(const Eigen::VectorXd& residual);

  const FitProblem& problem_;
  const StagedFitOptions& staged_;
  const PosteriorOptions& options_;
  const StagedFitCallbacks& callbacks_;
  const CandidateFitter branch_fitter_;
  std::vector<std::vector<Observation>> targets_;
  Eigen::VectorXd mean_;
  PosteriorFit& fit_;
};

// Draws that a Pareto tail can be fitted to: fewer say nothing.
inline constexpr int kLeastFresh = 25;

// What fresh draws say of a fit: fills elbo, elbo_error, pareto_k, fresh and draw_rms_px.
// residuals: of the draws that stand; log_ratios: of each, ln p(u) − ln q(u) of what is random in
// it. Of fewer than kLeastFresh these numbers are NaN.
void EstimateElbo(const std::vector<Eigen::VectorXd>& residuals,
                  const std::vector<double>& log_ratios, PosteriorFit* fit);

// Model bdp after the mode: means and deviations of the elements.
[[nodiscard]] bool FitElements(const FitProblem& problem, const PosteriorOptions& options,
                               MapEstimator& mode, PosteriorFit* fit);

}  // namespace drape
