// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/statistics/outline_data.h"

#include <glog/logging.h>

#include "physics/util/math/random.h"
#include "solver/posterior/variational/gaussian_posterior.h"

namespace drape {
namespace {

constexpr uint64_t kNoiseStream = 0x6e6f6973;  // separates it from the samples of the same seed

NetcdfDimension Images(const StoredSamples& samples) {
  NetcdfDimension images{.name = "image", .size = static_cast<int>(samples.images.size())};
  for (const StoredSamples::Image& image : samples.images) images.labels.push_back(image.name);
  return images;
}

NetcdfDimension Angles(const StoredSamples& samples) {
  NetcdfDimension angles{.name = "angle", .size = samples.angles(), .units = "degree"};
  for (int k = 0; k < angles.size; ++k) angles.numbers.push_back(360.0 * k / angles.size);
  return angles;
}

void AddDimension(const NetcdfDimension& dimension, NetcdfGroup* group) {
  for (const NetcdfDimension& known : group->dimensions)
    if (known.name == dimension.name) return;
  group->dimensions.push_back(dimension);
}

NetcdfVariable OutlineVariable(const std::string& name, const std::string& units,
                               const std::string& long_name) {
  return {name, {"chain", "draw", "image", "angle"}, {}, units, long_name};
}

// Image after image.
void Append(const Eigen::MatrixXd& by_image, NetcdfVariable* variable) {
  variable->values.insert(variable->values.end(), by_image.data(),
                          by_image.data() + by_image.size());
}

// r(θ) of the images of a sample with errors of the observation.
Eigen::MatrixXd WithErrors(const StoredSamples& samples, const Eigen::MatrixXd& radius,
                           uint64_t seed) {
  const Eigen::MatrixXd errors = IndependentSamples(samples.angles(), radius.cols(), seed);
  Eigen::MatrixXd seen = radius;
  for (Eigen::Index i = 0; i < seen.cols(); ++i)
    seen.col(i) += samples.images[i].sigma * errors.col(i);
  return seen;
}

}  // namespace

void AddObservedOutlines(const StoredSamples& samples, NetcdfGroup* observed_data) {
  AddDimension(Images(samples), observed_data);
  AddDimension(Angles(samples), observed_data);
  NetcdfVariable outline = {
      "outline", {"image", "angle"}, {}, "m", "radius of the outline in the image"};
  for (const StoredSamples::Image& image : samples.images) Append(image.radius, &outline);
  observed_data->variables.push_back(std::move(outline));
}

void AddSigma(const StoredSamples& samples, NetcdfGroup* constant_data) {
  AddDimension(Images(samples), constant_data);
  NetcdfVariable sigma = {
      "sigma", {"image"}, {}, "m", "standard deviation of a radius of the outline"};
  for (const StoredSamples::Image& image : samples.images) sigma.values.push_back(image.sigma);
  constant_data->variables.push_back(std::move(sigma));
}

void AddSampleOutlines(const StoredSamples& samples, NetcdfGroup* posterior) {
  AddDimension(Images(samples), posterior);
  AddDimension(Angles(samples), posterior);
  NetcdfVariable outline = OutlineVariable("drape_outline", "m", "radius of the drape's outline");
  for (const StoredSamples::Sample& sample : samples.samples) Append(sample.radius, &outline);
  posterior->variables.push_back(std::move(outline));
}

std::vector<NetcdfGroup> OutlineGroups(const StoredSamples& samples, int chains, uint64_t seed) {
  const auto count = static_cast<int>(samples.samples.size());
  CHECK_EQ(count % chains, 0);
  seed = SeedOfStream(seed, kNoiseStream);
  NetcdfVariable predicted = OutlineVariable("outline", "m", "radius of an outline as it is seen");
  NetcdfVariable likelihood =
      OutlineVariable("outline", "1", "ln of the density of the radius that was seen [1/m]");
  NetcdfVariable joint = {"lp", {"chain", "draw"}, {}, "1", "ln of likelihood times prior"};
  NetcdfVariable approximate = {
      "lp_approx", {"chain", "draw"}, {}, "1", "ln of the density that was sampled from"};
  for (int s = 0; s < count; ++s) {
    const StoredSamples::Sample& sample = samples.samples[s];
    const Eigen::MatrixXd log_likelihood = samples.LogLikelihood(sample);
    Append(WithErrors(samples, sample.radius, SeedOfStream(seed, s)), &predicted);
    Append(log_likelihood, &likelihood);
    joint.values.push_back(log_likelihood.sum() + sample.log_prior);
    approximate.values.push_back(sample.log_density);
  }
  const std::vector<NetcdfDimension> draws = {{.name = "chain", .size = chains},
                                              {.name = "draw", .size = count / chains}};
  std::vector<NetcdfDimension> outlines = draws;
  outlines.push_back(Images(samples));
  outlines.push_back(Angles(samples));
  return {{.name = "posterior_predictive",
           .dimensions = outlines,
           .variables = {std::move(predicted)},
           .attributes = {}},
          {.name = kLogLikelihoodGroup,
           .dimensions = outlines,
           .variables = {std::move(likelihood)},
           .attributes = {}},
          {.name = kSampleStatsGroup,
           .dimensions = draws,
           .variables = {std::move(joint), std::move(approximate)},
           .attributes = {}}};
}

}  // namespace drape
