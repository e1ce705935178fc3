// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/simulation/backend.h"
#include "solver/fit/fit.h"
#include "solver/fit/observed/observation.h"
#include "solver/fit/rollout_residuals.h"

namespace drape {

// A normal distribution of P numbers u = mean + V·L·ε, ε standard normal. Numbers are in units of
// their prior, which is standard normal itself.
struct GaussianPosterior {
  Eigen::VectorXd mean;      // shape [P]
  Eigen::MatrixXd rotation;  // V, orthogonal, shape [P, P]
  Eigen::MatrixXd factor;    // L, lower triangular with a positive diagonal, shape [P, P]

  int size() const { return static_cast<int>(mean.size()); }
  // Columns of samples from columns of standard normal ones, shape [P, S].
  Eigen::MatrixXd Draws(const Eigen::MatrixXd& standard) const;
  Eigen::MatrixXd Covariance() const;
  // KL(q ‖ N(0, 1)) = ½ Σ mean² + ½ Σ_{i>j} L_ij² + ½ Σ_i (L_ii² − 1 − ln L_ii²).
  double DivergenceFromPrior() const;
};

// The distribution of that mean and covariance, shape [P, P]: V its eigenvectors, those of least
// variance first, which the data determine best, so that L is diagonal.
GaussianPosterior FromCovariance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

// A root R of a covariance, R·Rᵀ = covariance, shape [P, P]; variances that rounding makes negative
// count as zero.
Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& covariance);

// Standard normal samples as columns, shape [size, count], that depend on the seed alone.
Eigen::MatrixXd IndependentSamples(int size, int count, uint64_t seed);

// Standard normal samples as antithetic pairs (column i + count/2 is minus column i), so that odd
// moments vanish, and with exact second moments in the first min(size, count/2) numbers: Σ ε·εᵀ /
// count = 1 there. count even.
Eigen::MatrixXd BalancedSamples(int size, int count, uint64_t seed);

// Residuals r(u), shape [K], of S samples of P latent numbers, computed together.
class SampledResiduals {
 public:
  virtual ~SampledResiduals() = default;
  virtual int num_latents() const = 0;    // P
  virtual int num_residuals() const = 0;  // K, of each sample
  virtual int num_draws() const = 0;      // S
  // points: u of each sample, shape [P, S].
  virtual void Prepare(const Eigen::MatrixXd& points, bool with_jacobians) = 0;
  // The residuals [K] of a prepared sample and, if not null, ∂r/∂u, shape [K, P]. False when it has
  // none.
  [[nodiscard]] virtual bool Residuals(int draw, Eigen::VectorXd* residual,
                                       RowMatrix* jacobian) const = 0;
};

// The point of each sample of the residuals.
enum class SampleKind {
  kMode,    // u = mean: the mode of the posterior instead of a distribution
  kShared,  // u = mean + V·L·ε: one number for the whole cloth
  // u = (mean, diagonal of L), shape [2P]: the residuals hold noise of their own for each element,
  // which they scale by the second half ("bdp" [METHODS, P33]: ElementwiseSamples). What then
  // is maximised is a bound on ln p(r, u), whose prior of u counts once (posterior_fit.h)
  kElementwise
};

struct VariationalOptions {
  SampleKind kind = SampleKind::kShared;
  int draws = 16;  // S, even
  uint64_t seed = 1;
  // Leading directions of V whose L is a full triangle; after them, L is diagonal. 0: mean field.
  int rank = 0;
  // The latent numbers are of one kind, in units of their prior.
  TrustRegionOptions trust_region = {.max_damping = std::numeric_limits<double>::infinity(),
                                     .initial_damping = 1.0,
                                     .unit_damping = true,
                                     .cost_tolerance = kLastCostTolerance};
};

struct VariationalFit {
  // kMode: the Laplace approximation about the mode, by Ceres's covariance.
  GaussianPosterior gaussian;
  FitTermination termination = FitTermination::kFailed;
  // kShared and kElementwise: −ELBO without the residuals' normalisation ½·K·ln 2π: E_q ½‖r‖² over
  // the fixed samples + KL.
  double cost = 0.0, initial_cost = 0.0;
  double divergence = 0.0;  // KL(q ‖ prior), part of it
  int iterations = 0;
  double seconds = 0.0;
};

// Maximises the evidence lower bound over q = N(mean, V·L·Lᵀ·Vᵀ) against a unit prior, from
// `start`, whose V is kept. With fixed samples ε (common random numbers, BalancedSamples) its
// negative is a sum of squares [METHODS, P28],
//   ½ Σ_s ‖r(u_s)‖²/S + ½ Σ mean² + ½ Σ_{i>j} L_ij² + ½ Σ_i (t_i − 1 − ln t_i), t_i = L_ii²,
// the last with the signed root of t − 1 − ln t, smooth at t = 1, as residual: so Ceres's trust
// region fits the posterior as it fits a material. L_ii lives on a log scale.
// Exact for linear r where the samples are at least 2·(rank or, for mean field, P).
VariationalFit FitPosterior(SampledResiduals& residuals, const GaussianPosterior& start,
                            const VariationalOptions& options);

// sign(ρ)·√(e^2ρ − 1 − 2ρ), smooth, and its derivative: what a log deviation ρ adds to the
// residuals.
double SignedRoot(double log_deviation, double* derivative = nullptr);

// The hierarchy [METHODS, P30], on a log scale and in units of the prior: what specimens of a
// fabric have in common, then how each of them differs. The branch of each drape is given, by its
// start.
struct HierarchicalModel {
  MaterialField base;  // the prior's median: one table
  ParameterTying fabric = ParameterTying::kEntries;
  double fabric_sigma = 1.0;  // prior standard deviation of each log factor of the fabric
  // Prior standard deviations of a specimen's log factors on all stretch and on all bend entries;
  // 0: specimens are alike.
  double specimen_stretch_sigma = 0.0, specimen_bend_sigma = 0.0;
  int specimens = 1;
  // Instead of fabric_sigma: R, and R·Rᵀ is the prior covariance of the fabric's log factors; shape
  // [num_fabric(), num_fabric()] or empty.
  Eigen::MatrixXd fabric_root = {};

  int num_fabric() const { return static_cast<int>(TyingMatrix(fabric).cols()); }
  bool has_specimens() const { return specimen_stretch_sigma > 0.0 || specimen_bend_sigma > 0.0; }
  int num_latents() const { return num_fabric() + (has_specimens() ? 2 * specimens : 0); }
  // ∂(log entries of a specimen)/∂u, shape [39, num_latents()]; kFabric: of the fabric itself.
  static constexpr int kFabric = -1;
  Eigen::MatrixXd LogEntries(int specimen) const;
  // Log factors of the fabric and of its specimens by u, shape [num_latents(), num_latents()].
  Eigen::MatrixXd LatentRoot() const;
  // "bend[2][4]", "specimen 3 bend".
  std::string NameFor(int latent) const;
};

// What happens to a sample whose drape leaves its branch, or is not found, on the way to its point.
enum class LostBranchPolicy {
  kReject,        // it has no residuals, and the optimiser shortens its step for all samples
  kRejectAtOnce,  // the same, without smaller steps: an optimiser of one sample takes them itself
  kExtrapolate    // its residuals are linear from the last point with a valid drape
};

// The drapes of one specimen: what was seen, and where each starts.
struct SpecimenDrapes {
  std::vector<Observation> observations;
  std::vector<State> starts;
};

// What was seen of all specimens as residuals of samples of the hierarchy: (r − seen)/σ of each
// observation, specimen by specimen, then of blocks of the fabric itself. Each sample follows its
// own drapes from trial to trial (RolloutResiduals), in halved steps where they are lost at once;
// all rollouts of an evaluation go to the backend together.
class HierarchicalSamples final : public SampledResiduals {
 public:
  // The backend outlives the object. of_fabric: blocks whose runs own their backends.
  HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                      const std::vector<SpecimenDrapes>& specimens, const ResidualOptions& options,
                      int draws, LostBranchPolicy policy = LostBranchPolicy::kReject,
                      std::vector<RolloutBlock> of_fabric = {});
  // Model bdp [Gong 2024], [METHODS, P33]: each face and hinge of each specimen has a sample of its
  // own, exp(m + s·ε) times the base for each of the 39 entries, with
  //   m = mean_sigma · u[0, 39), s = element_sigma · u[39, 78),
  // so u, shape [78], has the units of the priors of m and of s. Specimens share m and s, not their
  // noise ε, which depends on (seed, sample, specimen) alone.
  struct ElementScales {
    double mean_sigma = 1.0, element_sigma = 0.3;
  };
  static std::unique_ptr<HierarchicalSamples> Elementwise(
      Backend* backend, const MaterialField& base, const ElementScales& scales,
      const std::vector<SpecimenDrapes>& specimens, const ResidualOptions& options, int draws,
      uint64_t seed, LostBranchPolicy policy = LostBranchPolicy::kReject);
  ~HierarchicalSamples() override;

  int num_latents() const override { return num_latents_; }
  int num_residuals() const override;
  int num_draws() const override { return num_draws_; }
  void Prepare(const Eigen::MatrixXd& points, bool with_jacobians) override;
  [[nodiscard]] bool Residuals(int draw, Eigen::VectorXd* residual,
                               RowMatrix* jacobian) const override;

  // Takes the drapes from the starts to those of u, shape [num_latents()], for all samples at once;
  // they are then predicted from there. False when these are not stable.
  [[nodiscard]] bool StartAt(const Eigen::VectorXd& u);
  // Other samples of the same residuals, whose drapes are predicted from those of StartAt.
  std::unique_ptr<HierarchicalSamples> WithSamples(int draws, LostBranchPolicy policy) const;
  // The number of samples of the last Prepare with a drape that is not valid; of elementwise ones,
  // over all specimens.
  int num_extrapolated() const;
  // The drapes of a sample as last prepared, specimen by specimen.
  std::vector<Eigen::VectorXd> Shapes(int draw) const;
  RolloutCounts counts() const;

 private:
  struct SampleState;  // of one part: a specimen, or the fabric itself
  HierarchicalSamples() = default;
  const SampleState& state(int draw, int part) const { return *states_[draw * parts_ + part]; }
  bool is_elementwise() const { return prototypes_.empty(); }
  double least_step() const;  // of the way to a point, as a share

  Backend* backend_ = nullptr;
  int num_latents_ = 0, num_draws_ = 0, specimens_ = 1, parts_ = 1;
  double element_ratio_ = 1.0;  // element_sigma / mean_sigma
  LostBranchPolicy policy_ = LostBranchPolicy::kReject;
  std::vector<std::unique_ptr<SampleState>>
      prototypes_;                                    // of each part, at StartAt; elementwise: none
  std::vector<std::unique_ptr<SampleState>> states_;  // sample by sample
};

}  // namespace drape
