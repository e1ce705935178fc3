// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/fabric_samples.h"

#include <glog/logging.h>

#include <utility>

#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"
#include "solver/posterior/variational_fit.h"

namespace drape {
namespace {

// Separate the two sets, and both from the samples of a prediction, which have the same seed.
constexpr uint64_t kPosteriorStream = 0x706f7374, kPriorStream = 0x7072696f;

FabricSamples SampleLogFactors(const StoredPosterior& posterior, const Eigen::VectorXd& mean,
                               const Eigen::MatrixXd& covariance, int count, uint64_t seed) {
  CHECK_GE(count, 1);
  return SamplesAt(
      posterior,
      (CovarianceRoot(covariance) * IndependentSamples(posterior.size(), count, seed)).colwise() +
          mean);
}

}  // namespace

FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors) {
  CHECK(posterior.kind == PosteriorKind::kHierarchy);
  CHECK_EQ(log_factors.rows(), posterior.size());
  FabricSamples samples;
  for (int i = 0; i < posterior.size(); ++i) samples.names.push_back(posterior.NameFor(i));
  samples.log_factors = std::move(log_factors);
  const TableParametrisation table(posterior.base, posterior.fabric);
  samples.tables.reserve(samples.log_factors.cols());
  for (const auto& sample : samples.log_factors.colwise())
    samples.tables.push_back(table.Material(sample.head(posterior.num_fabric())));
  return samples;
}

FabricSamples SamplePosterior(const StoredPosterior& posterior, int count, uint64_t seed) {
  return SampleLogFactors(posterior, posterior.mean, posterior.covariance, count,
                          SeedOfStream(seed, kPosteriorStream));
}

FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed) {
  const int n = posterior.num_fabric();
  Eigen::MatrixXd covariance = posterior.prior_sd.cwiseAbs2().asDiagonal();
  covariance.topLeftCorner(n, n) = posterior.FabricPrior();
  return SampleLogFactors(posterior, Eigen::VectorXd::Zero(posterior.size()), covariance, count,
                          SeedOfStream(seed, kPriorStream));
}

MaterialField MedianTables(const StoredPosterior& posterior) {
  return TableParametrisation(posterior.base, posterior.fabric)
      .Material(posterior.mean.head(posterior.num_fabric()));
}

}  // namespace drape
