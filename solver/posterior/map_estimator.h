// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/util/run_control.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/posterior/posterior_types.h"

namespace drape {

// The part that the posteriors of all models share: from a candidate to the mode of the fabric's
// log factors, alternating with σ of the outline, and then samples about it.
class MapEstimator {
 public:
  // References outlive the object. The result is collected in *fit.
  MapEstimator(const FitProblem& problem, const StagedFitOptions& staged,
               const PosteriorOptions& options, const FitCandidate& candidate,
               const RunControl& control, PosteriorFit* fit);
  MapEstimator(const MapEstimator&) = delete;
  MapEstimator& operator=(const MapEstimator&) = delete;

  // Fills hierarchy, specimen, mode, sigma_px, counts. False when there is none.
  [[nodiscard]] bool Find();
  // Fills materials and shapes: the drapes at the fabric's log factors u, or those at the mode if
  // the branches end before u. False when those at the mode are not stable either.
  [[nodiscard]] bool ReportDrapes(Eigen::VectorXd u);

  // Samples of the hierarchy, from the drapes of the mode.
  HierarchicalSamples MakeSamples(int count, LostBranchPolicy policy) const;
  // Of each specimen: what was seen, with the drapes of the mode as starts.
  const std::vector<SpecimenDrapes>& specimens() const { return specimens_; }
  OutlineResidualOptions MakeResidualOptions() const;
  // from, to: the share of the progress.
  VariationalOptions MakeOptions(SampleKind kind, int iterations, double from, double to) const;
  bool Cancelled() const { return control_.cancelled(); }

  static constexpr double kModeShare = 0.2, kFitShare = 0.65;  // of the time

 private:
  void SetHierarchy(const FitCandidate& candidate);
  void SetSpecimens(const FitCandidate& candidate);
  Eigen::VectorXd StartNumbers(const FitCandidate& candidate) const;
  bool FindOnce(int round, int rounds);
  void StartFrom(const std::vector<Eigen::VectorXd>& shapes);
  void EstimateSigma(const Eigen::VectorXd& residual);

  const FitProblem& problem_;
  const StagedFitOptions& staged_;
  const PosteriorOptions& options_;
  const RunControl& control_;
  const CandidateFitter candidate_fitter_;
  std::vector<SpecimenDrapes> specimens_;
  Eigen::VectorXd mean_;
  PosteriorFit& fit_;
};

// A Pareto tail cannot be fitted to fewer samples.
inline constexpr int kMinElboSamples = 25;

// Judges a fit by independent samples: fills elbo, elbo_error, pareto_k, elbo_samples_valid and
// sample_rms_px. residuals: of the valid samples; log_ratios: ln p(u) − ln q(u) of the random part
// of each. With fewer than kMinElboSamples these numbers are NaN.
void EstimateElbo(const std::vector<Eigen::VectorXd>& residuals,
                  const std::vector<double>& log_ratios, PosteriorFit* fit);

}  // namespace drape
