// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/normal_mixture.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "physics/util/math/random.h"

namespace drape {
namespace {

using Axes = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

double LogDeterminant(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

double SquaredLength(const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::VectorXd& x) {
  return factor.matrixL().solve(x).squaredNorm();
}

// The square root of a matrix whose negative eigenvalues are rounding.
Eigen::MatrixXd SquareRoot(const Eigen::MatrixXd& matrix) {
  const Axes axes(matrix);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         axes.eigenvectors().transpose();
}

using Observations = std::vector<NormalDistribution>;

constexpr double kLeastSpread = 1e-6;  // variance of a population in a direction, in prior units
constexpr int kObservationsForOne = 3;
constexpr int kStarts = 4, kIterations = 300;
constexpr double kTolerance = 1e-7;  // of the log likelihood per observation
constexpr uint64_t kSeed = 1;

double LogSumExp(const Eigen::ArrayXd& logs) {
  const double largest = logs.maxCoeff();
  return largest + std::log((logs - largest).exp().sum());
}

// What the shrinkage draws covariances towards, and as how many observations it counts.
struct Shrinkage {
  Eigen::MatrixXd target;
  double count = 1.0;
};

// One expectation and one maximisation step. Returns the log likelihood before it.
double Improve(const Observations& observations, const Shrinkage& shrinkage,
               NormalMixture* mixture) {
  const int count = static_cast<int>(observations.size()), k = mixture->size();
  const int d = observations[0].size();
  Eigen::ArrayXXd logs(k, count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < k; ++j) {
      const NormalDistribution& part = mixture->components[j];
      logs(j, i) = std::log(mixture->weights[j]) +
                   LogDensity({part.mean, part.covariance + observations[i].covariance},
                              observations[i].mean);
    }
  double likelihood = 0.0;
  for (int i = 0; i < count; ++i) {
    const double all = LogSumExp(logs.col(i));
    likelihood += all;
    logs.col(i) = (logs.col(i) - all).exp();
  }
  for (int j = 0; j < k; ++j) {
    const NormalDistribution part = mixture->components[j];
    const double sum = std::max(logs.row(j).sum(), std::numeric_limits<double>::min());
    Eigen::MatrixXd values(d, count), spread = Eigen::MatrixXd::Zero(d, d);
    for (int i = 0; i < count; ++i) {
      const Eigen::MatrixXd total = part.covariance + observations[i].covariance;
      const Eigen::MatrixXd gain = total.llt().solve(part.covariance).transpose();
      values.col(i) = part.mean + gain * (observations[i].mean - part.mean);
      spread += logs(j, i) * (part.covariance - gain * part.covariance);
    }
    NormalDistribution& next = mixture->components[j];
    next.mean = values * logs.row(j).transpose().matrix() / sum;
    for (int i = 0; i < count; ++i) {
      const Eigen::VectorXd off = values.col(i) - next.mean;
      spread += logs(j, i) * off * off.transpose();
    }
    next.covariance = (spread + shrinkage.count * shrinkage.target) / (sum + shrinkage.count);
    next.covariance = 0.5 * (next.covariance + next.covariance.transpose()).eval();
    next.covariance.diagonal().array() += kLeastSpread;
    mixture->weights[j] = sum / count;
  }
  return likelihood;
}

// Runs to convergence; returns the log likelihood.
double Maximise(const Observations& observations, const Shrinkage& shrinkage,
                NormalMixture* mixture) {
  double before = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kIterations; ++i) {
    const double now = Improve(observations, shrinkage, mixture);
    if (std::abs(now - before) < kTolerance * double(observations.size())) return now;
    before = now;
  }
  return before;
}

NormalDistribution EstimateMoments(const Observations& observations) {
  const int count = static_cast<int>(observations.size()), d = observations[0].size();
  NormalDistribution all{Eigen::VectorXd::Zero(d), Eigen::MatrixXd::Zero(d, d)};
  for (const NormalDistribution& x : observations) all.mean += x.mean / count;
  for (const NormalDistribution& x : observations)
    all.covariance += (x.mean - all.mean) * (x.mean - all.mean).transpose() / count;
  all.covariance.diagonal().array() += kLeastSpread;
  return all;
}

// Shrunk towards the same scatter in all directions, which follows from a fit that is not shrunk.
NormalMixture DeconvolveOne(const Observations& observations) {
  const int d = observations[0].size();
  NormalMixture mixture{{1.0}, {EstimateMoments(observations)}};
  Maximise(observations, {Eigen::MatrixXd::Zero(d, d), 0.0}, &mixture);
  const double scatter = mixture.components[0].covariance.trace() / d;
  Maximise(observations, {scatter * Eigen::MatrixXd::Identity(d, d), 1.0}, &mixture);
  return mixture;
}

// Means at observations that are drawn with probabilities by their squared distance from those
// before, as [Arthur 2007].
NormalMixture DrawStart(const Observations& observations, const NormalDistribution& all,
                        int components, std::mt19937_64& random) {
  const int count = static_cast<int>(observations.size());
  const Eigen::LLT<Eigen::MatrixXd> factor(all.covariance);
  NormalMixture mixture;
  Eigen::ArrayXd distance = Eigen::ArrayXd::Ones(count);
  for (int k = 0; k < components; ++k) {
    double left = SampleUniform(random) * distance.sum();
    int drawn = 0;
    while (drawn + 1 < count && (left -= distance[drawn]) > 0) ++drawn;
    const Eigen::VectorXd& mean = observations[drawn].mean;
    mixture.components.push_back({mean, all.covariance / components});
    mixture.weights.push_back(1.0 / components);
    for (int i = 0; i < count; ++i) {
      const double squared = factor.matrixL().solve(observations[i].mean - mean).squaredNorm();
      distance[i] = k == 0 ? squared : std::min(distance[i], squared);
    }
  }
  return mixture;
}

}  // namespace

double LogDensity(const NormalDistribution& p, const Eigen::VectorXd& x) {
  const Eigen::LLT<Eigen::MatrixXd> factor(p.covariance);
  return -0.5 * (SquaredLength(factor, x - p.mean) + LogDeterminant(factor) +
                 p.size() * std::log(2 * std::numbers::pi));
}

double KullbackLeibler(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::LLT<Eigen::MatrixXd> of_p(p.covariance), of_q(q.covariance);
  const double trace = of_q.solve(p.covariance).trace();
  return 0.5 * (trace + SquaredLength(of_q, q.mean - p.mean) - p.size() + LogDeterminant(of_q) -
                LogDeterminant(of_p));
}

double Bhattacharyya(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::LLT<Eigen::MatrixXd> of_p(p.covariance), of_q(q.covariance),
      middle(0.5 * (p.covariance + q.covariance));
  return 0.125 * SquaredLength(middle, q.mean - p.mean) +
         0.5 * (LogDeterminant(middle) - 0.5 * (LogDeterminant(of_p) + LogDeterminant(of_q)));
}

double Hellinger(const NormalDistribution& p, const NormalDistribution& q) {
  return std::sqrt(std::max(0.0, -std::expm1(-Bhattacharyya(p, q))));
}

double Wasserstein(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::MatrixXd root = SquareRoot(p.covariance);
  const double cross = SquareRoot(root * q.covariance * root).trace();
  const double spread = p.covariance.trace() + q.covariance.trace() - 2.0 * cross;
  return std::sqrt(std::max(0.0, (p.mean - q.mean).squaredNorm() + spread));
}

NormalDistribution Project(const NormalDistribution& p, const Eigen::MatrixXd& axes) {
  return {axes.transpose() * p.mean, axes.transpose() * p.covariance * axes};
}

DeterminedDirections FindDetermined(const Eigen::MatrixXd& covariance, int count, double most) {
  const Axes axes(covariance);
  const Eigen::Index below = (axes.eigenvalues().array() < most).count();
  const Eigen::Index kept = std::min<Eigen::Index>(below, count);
  return {axes.eigenvectors().leftCols(kept), axes.eigenvalues().head(kept)};
}

NormalDistribution WithoutPrior(const NormalDistribution& posterior,
                                const Eigen::VectorXd& centre) {
  const Axes axes(posterior.covariance);
  const Eigen::MatrixXd& v = axes.eigenvectors();
  const Eigen::ArrayXd s = axes.eigenvalues().array().max(0.0).min(kMostNoise / (1 + kMostNoise));
  const Eigen::ArrayXd mean = (v.transpose() * posterior.mean).array();
  const Eigen::ArrayXd prior = (v.transpose() * centre).array();
  return {v * ((mean - s * prior) / (1 - s)).matrix(),
          v * (s / (1 - s)).matrix().asDiagonal() * v.transpose()};
}

double NormalMixture::LogLikelihood(const NormalDistribution& x) const {
  Eigen::ArrayXd logs(size());
  for (int k = 0; k < size(); ++k)
    logs[k] = std::log(weights[k]) +
              LogDensity({components[k].mean, components[k].covariance + x.covariance}, x.mean);
  return LogSumExp(logs);
}

NormalDistribution NormalMixture::Moments() const {
  const int d = components[0].size();
  NormalDistribution all{Eigen::VectorXd::Zero(d), Eigen::MatrixXd::Zero(d, d)};
  for (int k = 0; k < size(); ++k) all.mean += weights[k] * components[k].mean;
  for (int k = 0; k < size(); ++k) {
    const Eigen::VectorXd off = components[k].mean - all.mean;
    all.covariance += weights[k] * (components[k].covariance + off * off.transpose());
  }
  return all;
}

NormalMixture Deconvolve(const Observations& observations, int components) {
  CHECK(!observations.empty());
  NormalMixture one = DeconvolveOne(observations);
  if (components == 1) return one;
  const Shrinkage shrinkage{one.components[0].covariance, double(observations[0].size())};
  NormalMixture best;
  double best_likelihood = -std::numeric_limits<double>::infinity();
  std::mt19937_64 random(kSeed);
  for (int start = 0; start < kStarts; ++start) {
    NormalMixture mixture = DrawStart(observations, one.components[0], components, random);
    const double likelihood = Maximise(observations, shrinkage, &mixture);
    if (likelihood <= best_likelihood) continue;
    best_likelihood = likelihood;
    best = std::move(mixture);
  }
  return best;
}

ComponentChoice ChooseComponents(const Observations& observations, int most) {
  const int count = static_cast<int>(observations.size());
  CHECK_GE(count, 2);
  const int limit = std::clamp(count / kObservationsForOne, 1, most);
  Eigen::ArrayXXd logs(count, limit);
  for (int i = 0; i < count; ++i) {
    Observations others = observations;
    others.erase(others.begin() + i);
    for (int k = 1; k <= limit; ++k)
      logs(i, k - 1) = Deconvolve(others, k).LogLikelihood(observations[i]);
  }
  ComponentChoice choice;
  const Eigen::ArrayXd sums = logs.colwise().sum();
  choice.log_likelihoods = {sums.begin(), sums.end()};
  int best = 0;
  sums.maxCoeff(&best);
  for (int k = best; k >= 0; --k) {
    const Eigen::ArrayXd loss = logs.col(best) - logs.col(k);
    const double error = std::sqrt((loss - loss.mean()).square().sum() / (count - 1.0) / count);
    if (loss.mean() <= error) choice.components = k + 1;
  }
  const Eigen::ArrayXd chosen = logs.col(choice.components - 1);
  choice.left_out = {chosen.begin(), chosen.end()};
  return choice;
}

}  // namespace drape
