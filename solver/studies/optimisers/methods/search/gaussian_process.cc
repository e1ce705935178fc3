// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/search/gaussian_process.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <utility>

namespace drape {
namespace {

// Squared scaled distances ρ² between the columns of a and b.
Eigen::ArrayXXd SquaredDistances(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                 const Eigen::VectorXd& lengths) {
  const Eigen::MatrixXd scaled_a = lengths.cwiseInverse().asDiagonal() * a;
  const Eigen::MatrixXd scaled_b = lengths.cwiseInverse().asDiagonal() * b;
  Eigen::MatrixXd squares = -2.0 * (scaled_a.transpose() * scaled_b);
  squares.colwise() += scaled_a.colwise().squaredNorm().transpose();
  squares.rowwise() += scaled_b.colwise().squaredNorm();
  return squares.array().max(0.0);
}

Eigen::ArrayXXd Correlation(Kernel kernel, const Eigen::ArrayXXd& squares) {
  if (kernel == Kernel::kSquaredExponential) return (-0.5 * squares).exp();
  const Eigen::ArrayXXd r = (5.0 * squares).sqrt();
  return (1.0 + r + r.square() / 3.0) * (-r).exp();
}

// −2·∂(correlation)/∂(ρ²): that of ln ℓ_i is this times (x_i − x'_i)²/ℓ_i².
Eigen::ArrayXXd Slope(Kernel kernel, const Eigen::ArrayXXd& squares) {
  if (kernel == Kernel::kSquaredExponential) return (-0.5 * squares).exp();
  const Eigen::ArrayXXd r = (5.0 * squares).sqrt();
  return 5.0 / 3.0 * (1.0 + r) * (-r).exp();
}

// Line searches try steps of any length, and fail for good on values that overflow: here the prior
// is e^−200 times its peak.
constexpr double kFarthestSd = 20.0;

// −ln of the density that FitHyperparameters maximises, but for a constant.
class NegativeLogDensity final : public ceres::FirstOrderFunction {
 public:
  NegativeLogDensity(Kernel kernel, const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                     const Hyperparameters& prior_mean)
      : kernel_(kernel), points_(points), values_(values), prior_mean_(prior_mean) {}
  int NumParameters() const override { return static_cast<int>(prior_mean_.size()); }
  bool Evaluate(const double* at, double* cost, double* gradient) const override {
    const Hyperparameters here = Eigen::Map<const Eigen::VectorXd>(at, prior_mean_.size());
    const Eigen::VectorXd off = (here - prior_mean_) / kHyperpriorSd;
    if (!(off.norm() <= kFarthestSd)) return false;
    GaussianProcess process(kernel_, here);
    if (!process.SetPoints(points_)) return false;
    const GaussianProcess::Likelihood likelihood =
        process.ComputeLikelihood(values_, gradient != nullptr);
    *cost = 0.5 * off.squaredNorm() - likelihood.log;
    if (gradient == nullptr) return std::isfinite(*cost);
    Eigen::Map<Eigen::VectorXd> slope(gradient, here.size());
    slope = off / kHyperpriorSd - likelihood.gradient;
    return std::isfinite(*cost) && slope.allFinite();
  }

 private:
  Kernel kernel_;
  const Eigen::MatrixXd& points_;
  const Eigen::VectorXd& values_;
  const Hyperparameters& prior_mean_;
};

}  // namespace

GaussianProcess::GaussianProcess(Kernel kernel, Hyperparameters hyperparameters)
    : kernel_(kernel),
      hyperparameters_(std::move(hyperparameters)),
      points_(hyperparameters_.size() - 2, 0) {}

Eigen::MatrixXd GaussianProcess::Covariance(const Eigen::MatrixXd& a,
                                            const Eigen::MatrixXd& b) const {
  const Eigen::VectorXd lengths = hyperparameters_.segment(1, points_.rows()).array().exp();
  const double signal = std::exp(2.0 * hyperparameters_[0]);
  return signal * Correlation(kernel_, SquaredDistances(a, b, lengths)).matrix();
}

bool GaussianProcess::SetPoints(const Eigen::MatrixXd& points) {
  CHECK_EQ(points.rows(), points_.rows());
  Eigen::MatrixXd covariance = Covariance(points, points);
  covariance.diagonal().setConstant(std::exp(2.0 * hyperparameters_[0]) * (1.0 + kNugget) +
                                    std::exp(2.0 * hyperparameters_.tail<1>()[0]));
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const bool definite = factor.info() == Eigen::Success;
  points_ = definite ? points : Eigen::MatrixXd(points.rows(), 0);
  factor_ = definite ? Eigen::MatrixXd(factor.matrixL()) : Eigen::MatrixXd();
  return definite;
}

bool GaussianProcess::Add(const Eigen::VectorXd& point) {
  const Eigen::Index n = points_.cols();
  const double diagonal = std::exp(2.0 * hyperparameters_[0]) * (1.0 + kNugget) +
                          std::exp(2.0 * hyperparameters_.tail<1>()[0]);
  Eigen::VectorXd row(n);
  if (n > 0) row = factor_.triangularView<Eigen::Lower>().solve(Covariance(points_, point).col(0));
  const double pivot = diagonal - row.squaredNorm();
  if (!(pivot > 0.0)) return false;
  points_.conservativeResize(Eigen::NoChange, n + 1);
  points_.col(n) = point;
  factor_.conservativeResize(n + 1, n + 1);
  factor_.col(n).setZero();
  factor_.row(n).head(n) = row.transpose();
  factor_(n, n) = std::sqrt(pivot);
  return true;
}

GaussianProcess::Posterior GaussianProcess::Predict(const Eigen::VectorXd& values,
                                                    const Eigen::MatrixXd& at) const {
  CHECK_EQ(values.size(), points_.cols());
  const auto lower = factor_.triangularView<Eigen::Lower>();
  Eigen::MatrixXd cross = Covariance(points_, at);
  lower.solveInPlace(cross);
  const Eigen::VectorXd whitened = lower.solve(values);
  const double signal = std::exp(2.0 * hyperparameters_[0]);
  return {cross.transpose() * whitened,
          (signal - cross.colwise().squaredNorm().transpose().array()).max(0.0)};
}

GaussianProcess::Likelihood GaussianProcess::ComputeLikelihood(const Eigen::VectorXd& values,
                                                               bool with_gradient) const {
  CHECK_EQ(values.size(), points_.cols());
  const Eigen::Index n = points_.cols(), d = points_.rows();
  const auto lower = factor_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd weights = lower.transpose().solve(lower.solve(values));
  Likelihood likelihood;
  likelihood.log = -0.5 * values.dot(weights) - factor_.diagonal().array().log().sum() -
                   0.5 * static_cast<double>(n) * std::log(2.0 * std::numbers::pi);
  if (!with_gradient) return likelihood;
  const Eigen::VectorXd lengths = hyperparameters_.segment(1, d).array().exp();
  const double signal = std::exp(2.0 * hyperparameters_[0]);
  const double noise = std::exp(2.0 * hyperparameters_[d + 1]);
  // W = α·αᵀ − K⁻¹; a derivative is ½ Σ W∘∂K.
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
  lower.solveInPlace(inverse);
  inverse = (inverse.transpose() * inverse).eval();
  const Eigen::ArrayXXd w = weights * weights.transpose() - inverse;
  const Eigen::ArrayXXd squares = SquaredDistances(points_, points_, lengths);
  likelihood.gradient.resize(d + 2);
  likelihood.gradient[0] =
      signal * ((w * Correlation(kernel_, squares)).sum() + kNugget * w.matrix().trace());
  const Eigen::MatrixXd m = signal * w * Slope(kernel_, squares);
  // ½ Σ_ab m_ab (x_a − x_b)² = Σ_a (Σ_b m_ab) x_a² − x·m·x for each coordinate.
  const Eigen::VectorXd sums = m.rowwise().sum();
  const Eigen::MatrixXd products = points_ * m;
  for (Eigen::Index i = 0; i < d; ++i)
    likelihood.gradient[1 + i] =
        (points_.row(i).array().square().matrix().dot(sums) - points_.row(i).dot(products.row(i))) /
        (lengths[i] * lengths[i]);
  likelihood.gradient[d + 1] = noise * w.matrix().trace();
  return likelihood;
}

Hyperparameters FitHyperparameters(Kernel kernel, const Eigen::MatrixXd& points,
                                   const Eigen::VectorXd& values, const Hyperparameters& start,
                                   const Hyperparameters& prior_mean, int iterations) {
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  Hyperparameters best = start;
  const ceres::GradientProblem problem(new NegativeLogDensity(kernel, points, values, prior_mean));
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, best.data(), &summary);
  return summary.IsSolutionUsable() && best.allFinite() ? best : start;
}

}  // namespace drape
