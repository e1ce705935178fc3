// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "physics/util/options/field.h"
#include "solver/fit/parametrisation.h"

namespace drape {

class JsonInput;
struct PosteriorFit;

enum class PosteriorKind {
  kHierarchy,  // "hierarchy": log factors of a fabric, then of its specimens, jointly normal
  kElements    // "bdp": of each face and hinge, independent normal, the same for all [METHODS, P33]
};
constexpr auto EnumNames(PosteriorKind) {
  return MakeNames<PosteriorKind>(
      {{PosteriorKind::kHierarchy, "hierarchy"}, {PosteriorKind::kElements, "bdp"}});
}

// The posterior of a fit as its files hold it: posterior.json, with base.json beside it,
//   {"format": "drapefit-posterior", "version": 2, "kind", "log_factors_on": "base.json",
//    "names" [P], "prior_sd" [P], "mean" [P],
//    kind hierarchy: "covariance" [P][P], "fabric_prior" [N][N] where the fabric's N log factors
//    have no independent prior, and "branch_deviation" where the covariance counts other branches
//    (CountBranches); kind bdp: "element_sd" [P]}.
// Names say what a log factor is on: those of a tying (NameFor), then of a hierarchy "specimen 1
// stretch", "specimen 1 bend", "specimen 2 stretch", ….
struct StoredPosterior {
  PosteriorKind kind = PosteriorKind::kHierarchy;
  ParameterTying fabric = ParameterTying::kEntries;  // kElements: kEntries
  int specimens = 0;                                 // with numbers of their own
  MaterialField base;                                // one table
  bool warp_known = true;                            // Material::warp_known of it
  Eigen::VectorXd prior_sd;                          // of the log factors in the prior, shape [P]
  Eigen::VectorXd mean;                              // shape [P]
  Eigen::MatrixXd covariance;                        // kHierarchy, shape [P, P]; kElements: empty
  Eigen::VectorXd element_sd;                        // kElements, shape [39]; kHierarchy: empty
  // Covariance of the fabric's log factors in the prior; empty: independent, of prior_sd.
  Eigen::MatrixXd fabric_prior = {};
  double branch_deviation = 0.0;  // of CountBranches; 0: not counted

  int num_fabric() const { return static_cast<int>(TyingMatrix(fabric).cols()); }
  int size() const { return num_fabric() + 2 * specimens; }
  std::string NameFor(int i) const;
  Eigen::MatrixXd FabricPrior() const;  // shape [num_fabric(), num_fabric()]
};

// Writes posterior.json and base.json, each atomically. CHECKs shapes. Throws InputError when one
// cannot be written. source: a note on the origin.
void WritePosterior(const std::string& folder, const StoredPosterior& posterior,
                    const std::string& source);

// The largest mean of a posterior or of a population: no fabric has a factor of 1e43.
inline constexpr double kMostLogFactor = 100.0;
// The means of `count` log factors. Throws InputError for one above kMostLogFactor.
Eigen::VectorXd ReadLogFactors(const JsonInput& input, int count);

// Reads both. Throws InputError naming the file and the key: another format, version or kind, names
// of no tying, a mean above kMostLogFactor, a negative deviation, a covariance that is not
// symmetric or has a negative variance.
StoredPosterior ReadPosterior(const std::string& folder, const MaterialPolicy& policy = {});

// Independent samples of a posterior of kind hierarchy with the outlines of their drapes, as a fit
// leaves them for statisticians: samples.json beside posterior.json,
//   {"format": "drapefit-samples", "version": 1, "drawn": 100,
//    "images": [{"name", "sigma_m", "radius_m" [K]}],
//    "samples": [{"log_factors" [P], "log_prior", "log_density", "radius_m" [I][K]}]}.
// Samples of an experiment have no images, but each its "log_likelihood".
// An outline r(θ) is that in the image, in the frame of the cloth, at the scale of the support
// plane.
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
    Eigen::MatrixXd radius;       // r(θ_k) of the drape in each image [m], shape [K, I]
    double log_likelihood = 0.0;  // ln p(r | u), but for a constant; read only without images
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

// Mean and standard deviation of the stiffness, estimated by samples: of the fabric under its
// posterior; of model bdp, of single faces and hinges. weights: StiffnessWeights of the fitted
// drapes; EqualStiffnessWeights for the means over the table of [Gong 2024, table 3].
struct PosteriorStiffness {
  double stretch = 0.0, stretch_deviation = 0.0;  // EffectiveStretch [N/m]
  double bend = 0.0, bend_deviation = 0.0;        // EffectiveBend [N m]
};
PosteriorStiffness ComputePosteriorStiffness(const PosteriorFit& fit,
                                             const Eigen::VectorXd& weights);

// For summary.json: each number's prior and posterior beside the Laplace approximation's, evidence,
// k̂, estimated σ.
nlohmann::ordered_json PosteriorJson(const PosteriorFit& fit, const Eigen::VectorXd& weights);

// The posterior as its files hold it (WritePosterior).
StoredPosterior MakeStoredPosterior(const PosteriorFit& fit);

// Widens a posterior of kind hierarchy by what other branches leave: its data tell of a fabric each
// of whose columns is off by this deviation of the logarithm. The prior remains, and the mean
// [METHODS, P57].
void CountBranches(double deviation, StoredPosterior& posterior);

// For a person: the stiffness, how many log factors the data determine, and whether k̂ allows
// to rely on it.
std::string PosteriorTable(const PosteriorFit& fit, const Eigen::VectorXd& weights);

}  // namespace drape
