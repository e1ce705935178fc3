// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "physics/util/options/field.h"
#include "physics/util/run_control.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/variational_fit.h"

namespace drape {

// A normal prior of a fabric's log factors: of covariance root·rootᵀ, shape [N, N], about the
// tables `median`, of the density of the fabric.
struct FabricPrior {
  MaterialField median;
  Eigen::MatrixXd root;  // lower triangular
};

// A posterior over a fabric's tables and its specimens' scales, given the branches of their drapes
// [METHODS, P30].
struct PosteriorOptions {
  PosteriorKind kind = PosteriorKind::kHierarchy;
  // Prior standard deviations of a specimen's log factors on stretch and on bend; both 0: specimens
  // are alike. Trials gave 0.07 to 0.17 [METHODS, P41].
  double specimen_stretch_sigma = 0.1, specimen_bend_sigma = 0.1;
  // Whether σ of the outline is estimated from the residuals at the mode, so that model error
  // widens the posterior. Else it is ResidualOptions::sigma_px. All σ of an experiment are enlarged
  // by one factor (EnlargeSigma).
  bool estimate_sigma = true;
  // kElements: scale of the prior of an entry's standard deviation over the elements (log factor).
  double element_sigma = 0.3;
  int angles = 36;         // K of r(θ): a silhouette's are not independent nearer than its folds
  int draws = 16;          // S, even
  int rank = 8;            // leading directions with correlations beside the Laplace axes
  int iterations = 20;     // of Ceres
  int elbo_samples = 100;  // for the evidence lower bound and k̂
  uint64_t seed = 1;
  // kHierarchy: replaces the prior about the initial guess.
  std::shared_ptr<const FabricPrior> prior = {};

  void Check() const;  // programmer errors
};

template <MutableOrConst<PosteriorOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [kind, specimen_stretch_sigma, specimen_bend_sigma, estimate_sigma, element_sigma, angles,
         draws, rank, iterations, elbo_samples, seed, prior] = options;
  visit(kind, Field{.key = "posterior_kind", .is_option = false});
  visit(specimen_stretch_sigma,
        Field{.key = "specimen_stretch_sigma",
              .doc = "model bayes: how specimens of the fabric differ, standard deviation of a log "
                     "factor on all stretch entries",
              .range = {.least = 0}});
  visit(specimen_bend_sigma, Field{.key = "specimen_bend_sigma",
                                   .doc = "model bayes: the same on all bend entries",
                                   .range = {.least = 0}});
  visit(element_sigma, Field{.key = "element_sigma",
                             .doc = "model bdp: how faces and hinges scatter, most likely standard "
                                    "deviation of a log factor in the prior",
                             .range = {.least = 0, .above_least = true}});
  visit(estimate_sigma, Field{.key = "estimate_sigma",
                              .doc = "models bayes, bdp: estimate sigma_px from the residuals at "
                                     "the mode; the sigmas of an experiment grow with them"});
  visit(angles,
        Field{.key = "posterior_angles", .range = {.least = 31, .most = 3600}, .is_option = false});
  visit(draws, Field{.key = "posterior_samples",
                     .doc = "models bayes, bdp: number of samples of the variational fit, even",
                     .range = {.least = 2, .most = 10000}});
  visit(rank, Field{.key = "posterior_rank",
                    .doc = "model bayes: number of directions whose correlations are free, beside "
                           "those of the Laplace approximation",
                    .range = {.least = 0, .most = 1000}});
  visit(iterations, Field{.key = "posterior_iterations",
                          .doc = "models bayes, bdp: iterations of Ceres for the posterior",
                          .range = {.least = 0, .most = 10000}});
  visit(elbo_samples, Field{.key = "elbo_samples",
                            .doc = "models bayes, bdp: number of independent samples that estimate "
                                   "the evidence and k",
                            .range = {.least = 25, .most = 100000}});
  visit(seed, Field{.key = "posterior_seed", .is_option = false});
}

struct PosteriorFit {
  PosteriorKind kind = PosteriorKind::kHierarchy;
  HierarchicalModel hierarchy;  // kElements: its fabric, all specimens alike
  VariationalFit mode;          // with the Laplace approximation
  // kElements: mean and standard deviation of each face and hinge, in units of the fabric's prior.
  VariationalFit distribution;
  // Given or estimated: σ of the outline [px]; of an experiment, the factor on its σ.
  double sigma = 0.0;
  bool of_experiment = false;
  int independent = 0;  // numbers that a χ² counts
  // Evidence lower bound by independent samples [nat] and its standard error; k̂ of their importance
  // weights: below 0.7 the approximation is reliable. kElements: of ln p(r, m, s), see
  // posterior_fit.h. NaN if fewer than 25 of these samples are valid: then nothing confirms the
  // posterior.
  double elbo = 0.0, elbo_error = 0.0, pareto_k = 0.0;
  int elbo_samples_valid = 0;  // of these samples, with stable drapes; the others are not counted
  std::optional<StoredSamples> samples = {};  // kHierarchy: the valid ones
  double sample_rms = 0.0;  // root mean square of what is off in them, in MisfitUnit
  // Samples of the distribution with a drape that is extrapolated past the end of its branch.
  int num_extrapolated = 0;
  RolloutCounts counts;
  std::vector<int> specimen;  // of each observation, from 0
  // Tables and drapes of each observation are those at the mean of the distribution, or at the mode
  // if a branch ends before the mean or nothing confirms the distribution (elbo).
  bool reported_at_mode = false;
  std::vector<MaterialField> materials;
  std::vector<Eigen::VectorXd> shapes;  // the drapes there [m], shape [3V]

  bool valid() const { return !shapes.empty(); }
  // Tables of the fabric at u, without those of its specimens.
  MaterialField FabricAt(const Eigen::VectorXd& u) const;
  // The median of the distribution, or the mode: as reported.
  MaterialField Fabric() const { return FabricAt(reported_mean()); }
  const Eigen::VectorXd& reported_mean() const {
    return (reported_at_mode ? mode : distribution).gaussian.mean;
  }
};

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

  // Fills hierarchy, specimen, mode, sigma, independent, counts. False when there is none.
  [[nodiscard]] bool Find();
  // Fills materials, shapes and reported_at_mode. False when the drapes at the mode are not stable
  // either.
  [[nodiscard]] bool ReportDrapes();

  // Samples of the hierarchy, from the drapes of the mode.
  HierarchicalSamples MakeSamples(int count, LostBranchPolicy policy) const;
  // What was seen of each specimen, with the drapes of the mode as starts.
  const std::vector<SpecimenDrapes>& specimens() const { return specimens_; }
  ResidualOptions MakeResidualOptions() const;
  // from, to: the share of the progress.
  VariationalOptions MakeOptions(SampleKind kind, int iterations, double from, double to) const;
  bool Cancelled() const { return control_.cancelled(); }

  static constexpr double kModeShare = 0.2, kFitShare = 0.65;  // of the time

 private:
  void SetHierarchy(const FitCandidate& candidate);
  void SetSpecimens(const FitCandidate& candidate);
  int CountIndependentNumbers() const;
  double SigmaBy(double misfit) const;
  Observation ForPosterior(Observation observation) const;
  std::vector<RolloutBlock> BlocksOfFabric() const;
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

// How heavy the tail of importance weights is [Vehtari 2024]: the shape k̂ of a generalised Pareto
// distribution fitted to the largest min(N/5, 3√N) weights by the estimate of [Zhang 2009], drawn
// towards ½ as there. Below 0.7 estimates by these weights can be trusted; above, the distribution
// that was drawn from is too far from the other.
// log_weights: of N ≥ 25 draws, finite, shape [N]. 0 when all are equal, infinite when fewer than 5
// are above the tail threshold.
double ParetoShape(const Eigen::VectorXd& log_weights);

// Model bdp (PosteriorKind::kElements) [METHODS, P33]: the tables of all faces and hinges are
// independent samples η = m + s·ε on the log scale, of means m and deviations s that all elements
// share. The fit is by its bound on ln p(r, m, s):
//   E_ε ln p(r | η) − KL(q(η | m, s) ‖ p(η | m, s)) + ln p(m, s).
// The variational density of the elements is their own conditional prior, so their divergence is
// zero, whatever their count, and E_ε is taken inside the residuals. What remains is the prior of
// 78 numbers, counted once: in units of their scales, m is standard normal and s has the Rayleigh
// density s·exp(−s²/2). −ln of it, relative to its peak, is
//   ½ Σ m² + ½ Σ (s² − 1 − ln s²),
// term by term the divergence of N(m, s²) from N(0, 1), which the shared cost already has as
// squares. (Were N(0, 1) the prior of each element, this would count once for each of thousands of
// elements and outweigh the images.) m and s are points: their own uncertainty is not included.
// `elbo` is that bound, relative to the peak of the prior; only ε is random, and its importance
// weights p(r | η) give k̂.
// This fit follows the mode.
[[nodiscard]] bool FitElements(const FitProblem& problem, const PosteriorOptions& options,
                               MapEstimator& mode, PosteriorFit* fit);

// Lets entries vary about their column or row in the posterior of an experiment [METHODS, P57].
void CountForm(StagedFitOptions& staged, FitCandidate& candidate, PosteriorOptions& options);

// Starts from the tables and drapes of a candidate. The prior is about the tables of its initial
// guess, as in the fit before, with the tying and prior_sigma of `staged`. First the mode, then the
// distribution.
PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& candidate,
                               const RunControl& control);

// Judges a fit by independent samples: fills elbo, elbo_error, pareto_k, elbo_samples_valid and
// sample_rms. residuals: of the valid samples; log_ratios: ln p(u) − ln q(u) of the random part
// of each. With fewer than 25 samples, these numbers are NaN.
void EstimateElbo(const std::vector<Eigen::VectorXd>& residuals,
                  const std::vector<double>& log_ratios, PosteriorFit* fit);

}  // namespace drape
