// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/feature_way.h"

#include <algorithm>

#include "losses/metrics/distribution_metrics.h"
#include "solver/studies/recognition/sample_model.h"

namespace drape {
namespace {

constexpr double kNotSeen = 1e6;  // variance of a feature of a face that has no capture
constexpr double kExact = 1e-8;   // variance of a measured feature

// Shape [2·kNumFeatures]; a capture of unknown face counts for both.
NormalDistribution FeaturesOfSample(const ListedSample& sample) {
  NormalDistribution seen{Eigen::VectorXd::Zero(2 * kNumFeatures),
                          kExact * Eigen::MatrixXd::Identity(2 * kNumFeatures, 2 * kNumFeatures)};
  Eigen::Vector2d count = Eigen::Vector2d::Zero();
  for (const ObservedCapture* image : sample.images) {
    for (int face = 0; face < 2; ++face) {
      if (image->capture.face == (face == 0 ? ClothFace::kDown : ClothFace::kUp)) continue;
      seen.mean.segment(face * kNumFeatures, kNumFeatures) +=
          ComputeFeatures(image->drape.shape).cwiseQuotient(kFeatureScales);
      ++count[face];
    }
  }
  for (int face = 0; face < 2; ++face) {
    seen.mean.segment(face * kNumFeatures, kNumFeatures) /= std::max(1.0, count[face]);
    if (count[face] == 0)
      seen.covariance.diagonal().segment(face * kNumFeatures, kNumFeatures).setConstant(kNotSeen);
  }
  return seen;
}

}  // namespace

std::vector<Eigen::VectorXd> CompareByFeatures(const SampleList& list) {
  std::vector<SeenSample> seen;
  for (const ListedSample& sample : list.samples)
    seen.push_back({sample.fabric, FeaturesOfSample(sample)});
  return CompareWithOthers(seen, list.num_fabrics(), Eigen::VectorXd::Ones(2 * kNumFeatures));
}

}  // namespace drape
