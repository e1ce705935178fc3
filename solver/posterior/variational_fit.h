// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "physics/linalg/blocks/block_matrix.h"
#include "solver/fit/fit.h"

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
  Eigen::VectorXd Deviations() const;  // square roots of its diagonal, shape [P]
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

}  // namespace drape
