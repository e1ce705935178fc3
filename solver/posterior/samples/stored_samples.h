// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace drape {

// Independent samples of a posterior of kind hierarchy with the outlines of their drapes, as a fit
// leaves them for statisticians: samples.json beside posterior.json,
//   {"format": "drapefit-samples", "version": 1, "drawn": 100,
//    "images": [{"name", "sigma_m", "radius_m" [K]}],
//    "samples": [{"log_factors" [P], "log_prior", "log_density", "radius_m" [I][K]}]}.
// An outline r(θ) is that in the image, at the scale of the support plane.
struct StoredSamples {
  struct Image {
    std::string name;
    double sigma = 0.0;      // standard deviation of r(θ) [m]
    Eigen::VectorXd radius;  // r(θ_k) as seen [m], θ_k = 2πk/K, shape [K]
  };
  struct Sample {
    Eigen::VectorXd log_factors;  // as in posterior.json, shape [P]
    // ln p(u) and ln q(u), of prior and posterior, by the latent numbers u in units of the prior.
    double log_prior = 0.0, log_density = 0.0;
    Eigen::MatrixXd radius;  // r(θ_k) of the drape in each image [m], shape [K, I]
  };
  int drawn = 0;  // of which `samples` are those with stable drapes
  std::vector<Image> images;
  std::vector<Sample> samples;

  int angles() const { return images.empty() ? 0 : static_cast<int>(images[0].radius.size()); }
  // ln p(r | u) of each radius [1/m], independent normal of sigma: shape [K, I].
  Eigen::MatrixXd LogLikelihood(const Sample& sample) const;
};

inline constexpr char kSamplesFile[] = "samples.json";

// Throws InputError when the file cannot be written.
void WriteSamples(const std::string& folder, const StoredSamples& samples);

// Throws InputError naming the file and the key: another format or version, shapes that do not
// agree, a deviation that is not positive, or `log_factors` of another number than `parameters`.
StoredSamples ReadSamples(const std::string& folder, int parameters);

}  // namespace drape
