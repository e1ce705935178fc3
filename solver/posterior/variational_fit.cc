// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/variational_fit.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "physics/util/math/random.h"

namespace drape {
namespace {

// The numbers that Ceres changes: mean [P] and, unless only a mode is wanted, ln L_ii [P] and L_ij
// of the leading triangle by rows.
class Layout {
 public:
  Layout(int latents, const VariationalOptions& options)
      : latents_(latents),
        rank_(options.kind == SampleKind::kShared ? std::min(options.rank, latents) : 0),
        only_mean_(options.kind == SampleKind::kMode) {
    CHECK_GE(options.rank, 0);
  }
  int size() const { return only_mean_ ? latents_ : 2 * latents_ + rank_ * (rank_ - 1) / 2; }
  int latents() const { return latents_; }

  Eigen::VectorXd Pack(const GaussianPosterior& q) const {
    Eigen::VectorXd numbers(size());
    numbers.head(latents_) = q.mean;
    if (only_mean_) return numbers;
    numbers.segment(latents_, latents_) = q.factor.diagonal().array().log();
    ForEachBelow([&](int index, int i, int j) { numbers[index] = q.factor(i, j); });
    return numbers;
  }
  void Unpack(const double* numbers, GaussianPosterior* q) const {
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    q->mean = Vector(numbers, latents_);
    if (only_mean_) return;
    q->factor = Vector(numbers + latents_, latents_).array().exp().matrix().asDiagonal();
    ForEachBelow([&](int index, int i, int j) { q->factor(i, j) = numbers[index]; });
  }
  // visit(index, i, j) for each L_ij below the diagonal.
  template <class Visit>
  void ForEachBelow(const Visit& visit) const {
    int index = 2 * latents_;
    for (int i = 1; i < rank_; ++i)
      for (int j = 0; j < i; ++j) visit(index++, i, j);
  }

 private:
  int latents_, rank_;
  bool only_mean_;
};

// What all cost functions of one fit share, evaluated before Ceres calls them.
class Evaluation final : public ceres::EvaluationCallback {
 public:
  Evaluation(SampledResiduals& residuals, const GaussianPosterior& start,
             const VariationalOptions& options)
      : residuals_(residuals),
        layout_(start.size(), options),
        kind_(options.kind),
        posterior_(start),
        standard_(kind_ == SampleKind::kShared
                      ? BalancedSamples(start.size(), residuals.num_draws(), options.seed)
                      : Eigen::MatrixXd()),
        numbers_(layout_.Pack(start)) {}

  double* numbers() { return numbers_.data(); }
  const Layout& layout() const { return layout_; }
  const GaussianPosterior& posterior() const { return posterior_; }
  int num_draws() const { return residuals_.num_draws(); }
  int num_residuals() const { return residuals_.num_residuals(); }

  void PrepareForEvaluation(bool with_jacobians, bool) override {
    layout_.Unpack(numbers_.data(), &posterior_);
    if (with_jacobians && kind_ == SampleKind::kMode)
      information_ = Eigen::MatrixXd::Identity(posterior_.size(), posterior_.size());
    residuals_.Prepare(Points(), with_jacobians);
  }

  // r(u_s)/√S and its derivatives by the numbers, shape [K, size()].
  bool Copy(int draw, double* residual, double* jacobian) {
    const double weight = 1 / std::sqrt(double(num_draws()));
    Eigen::VectorXd r;
    RowMatrix by_latent;
    if (!residuals_.Residuals(draw, &r, jacobian == nullptr ? nullptr : &by_latent)) return false;
    Eigen::Map<Eigen::VectorXd>(residual, r.size()) = weight * r;
    if (jacobian == nullptr) return true;
    if (kind_ == SampleKind::kMode)
      information_ += weight * weight * by_latent.transpose() * by_latent;
    Chain(draw, weight * by_latent,
          Eigen::Map<RowMatrix>(jacobian, num_residuals(), layout_.size()));
    return true;
  }

  // Inverse of JᵀJ, with the prior's part of J, at the last point whose derivatives were computed:
  // after a solution this is it, since Ceres differentiates there alone. Not by ceres::Covariance:
  // it evaluates once more and ignores a failure of that (2.1), and of its algorithms DENSE_SVD
  // crashes or is wrong where many singular values are equal, as they are where the prior
  // dominates.
  Eigen::MatrixXd LaplaceCovariance() const {
    return information_.llt().solve(
        Eigen::MatrixXd::Identity(information_.rows(), information_.cols()));
  }

 private:
  Eigen::MatrixXd Points() const {
    if (kind_ == SampleKind::kShared) return posterior_.Draws(standard_);
    if (kind_ == SampleKind::kMode) return posterior_.mean.replicate(1, num_draws());
    Eigen::VectorXd point(2 * posterior_.size());
    point << posterior_.mean, posterior_.factor.diagonal();
    return point.replicate(1, num_draws());
  }

  void Chain(int draw, const RowMatrix& by_latent, Eigen::Map<RowMatrix> by_number) const {
    const int n = layout_.latents();
    const auto diagonal = posterior_.factor.diagonal();
    by_number.leftCols(n) = by_latent.leftCols(n);
    if (kind_ == SampleKind::kMode) return;
    if (kind_ == SampleKind::kElementwise) {
      by_number.middleCols(n, n) = by_latent.rightCols(n) * diagonal.asDiagonal();
      return;
    }
    const auto noise = standard_.col(draw);
    const RowMatrix turned = by_latent * posterior_.rotation;
    by_number.middleCols(n, n) = turned * diagonal.cwiseProduct(noise).asDiagonal();
    layout_.ForEachBelow(
        [&](int index, int i, int j) { by_number.col(index) = turned.col(i) * noise[j]; });
  }

  SampledResiduals& residuals_;
  Layout layout_;
  SampleKind kind_;
  GaussianPosterior posterior_;
  Eigen::MatrixXd standard_;
  Eigen::VectorXd numbers_;
  Eigen::MatrixXd information_;  // of the mode
};

class DrawCost final : public ceres::CostFunction {
 public:
  DrawCost(Evaluation* evaluation, int draw) : evaluation_(evaluation), draw_(draw) {
    set_num_residuals(evaluation->num_residuals());
    mutable_parameter_block_sizes()->push_back(evaluation->layout().size());
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    return evaluation_->Copy(draw_, residuals, jacobians == nullptr ? nullptr : jacobians[0]);
  }

 private:
  Evaluation* evaluation_;
  int draw_;
};

// KL(q ‖ prior) as squares: one residual for each number.
class DivergenceCost final : public ceres::CostFunction {
 public:
  explicit DivergenceCost(const Layout& layout) : latents_(layout.latents()) {
    set_num_residuals(layout.size());
    mutable_parameter_block_sizes()->push_back(layout.size());
  }
  bool Evaluate(double const* const* numbers, double* residuals,
                double** jacobians) const override {
    const int size = num_residuals();
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    if (with_jacobian) std::fill_n(jacobians[0], std::size_t{1} * size * size, 0.0);
    for (int i = 0; i < size; ++i) {
      double slope = 1.0;
      const bool is_deviation = i >= latents_ && i < 2 * latents_;
      residuals[i] = is_deviation ? SignedRoot(numbers[0][i], &slope) : numbers[0][i];
      if (with_jacobian) jacobians[0][std::size_t{1} * i * size + i] = slope;
    }
    return true;
  }

 private:
  int latents_;
};

}  // namespace

Eigen::MatrixXd GaussianPosterior::Draws(const Eigen::MatrixXd& standard) const {
  return (rotation * (factor * standard)).colwise() + mean;
}

Eigen::MatrixXd GaussianPosterior::Covariance() const {
  const Eigen::MatrixXd root = rotation * factor;
  return root * root.transpose();
}

Eigen::VectorXd GaussianPosterior::Deviations() const {
  return (rotation * factor).rowwise().norm();
}

double GaussianPosterior::DivergenceFromPrior() const {
  return 0.5 * (mean.squaredNorm() + factor.squaredNorm() - size()) -
         factor.diagonal().array().log().sum();
}

GaussianPosterior FromCovariance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  CHECK_EQ(covariance.rows(), mean.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return {mean, axes.eigenvectors(), axes.eigenvalues().cwiseSqrt().asDiagonal()};
}

Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd IndependentSamples(int size, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd draws(size, count);
  for (double& value : draws.reshaped()) value = SampleNormal(random);
  return draws;
}

Eigen::MatrixXd BalancedSamples(int size, int count, uint64_t seed) {
  CHECK(count >= 2 && count % 2 == 0) << count;
  const int half = count / 2, exact = std::min(size, half);
  Eigen::MatrixXd draws = IndependentSamples(size, half, seed);
  auto leading = draws.topRows(exact);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> moments(leading * leading.transpose() /
                                                               half);
  leading = (moments.operatorInverseSqrt() * leading).eval();
  Eigen::MatrixXd pairs(size, count);
  pairs << draws, -draws;
  return pairs;
}

double SignedRoot(double log_deviation, double* derivative) {
  const double rho = log_deviation;
  const double square = std::expm1(2 * rho) - 2 * rho;
  // Near 0 the difference cancels: √2·ρ·(1 + ρ/3 + ρ²/9 + …).
  constexpr double kSmall = 1e-4;
  if (std::abs(rho) < kSmall) {
    if (derivative != nullptr) *derivative = std::sqrt(2.0) * (1 + rho * (2.0 / 3 + rho / 3));
    return std::sqrt(2.0) * rho * (1 + rho * (1.0 / 3 + rho / 9));
  }
  const double root = std::copysign(std::sqrt(square), rho);
  if (derivative != nullptr) *derivative = std::expm1(2 * rho) / root;
  return root;
}

VariationalFit FitPosterior(SampledResiduals& residuals, const GaussianPosterior& start,
                            const VariationalOptions& options) {
  Evaluation evaluation(residuals, start, options);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluation;
  ceres::Problem problem(problem_options);
  for (int s = 0; s < evaluation.num_draws(); ++s)
    problem.AddResidualBlock(new DrawCost(&evaluation, s), nullptr, evaluation.numbers());
  problem.AddResidualBlock(new DivergenceCost(evaluation.layout()), nullptr, evaluation.numbers());
  const TrustRegionRun run = RunTrustRegion(problem, options.trust_region);
  VariationalFit fit;
  fit.termination = run.termination;
  fit.gaussian = start;
  if (options.kind == SampleKind::kMode && run.termination != FitTermination::kFailed)
    fit.gaussian = FromCovariance(start.mean, evaluation.LaplaceCovariance());
  evaluation.layout().Unpack(evaluation.numbers(), &fit.gaussian);
  fit.initial_cost = run.initial_cost;
  fit.cost = run.final_cost;
  fit.divergence = fit.gaussian.DivergenceFromPrior();
  if (!run.iterations.empty()) fit.iterations = run.iterations.back().iteration;
  fit.seconds = run.seconds;
  return fit;
}

}  // namespace drape
