// SPDX-License-Identifier: Apache-2.0
// Samples fabrics from the posterior of one silhouette and prints how their bending stiffness
// scatters.
#include <cmath>
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 3) return 2;
  FitSpec spec;
  spec.mesh = spec.search_mesh = "disc:300";
  spec.simpler_models = false;
  // Two numbers, a factor on stretching and a factor on bending, and their distribution.
  spec.model = FitModel::kBayes;
  spec.stages.parameters = ParameterTying::kScales;
  const FitReport fit =
      FitDrapes(spec, ReadMaterial(argv[2]).field, {ReadImageObservation(argv[1], {})});
  if (!fit.posterior) return 1;
  // A k-hat below 0.7 says that the approximation of the posterior is reliable.
  std::printf("k-hat %.2f\n", fit.posterior->pareto_k);
  double sum = 0.0, squares = 0.0;
  constexpr int kSamples = 100;
  for (const MaterialField& sample : SamplePosterior(fit, kSamples, 1)) {
    const double log_bend = std::log(sample.bend[0].b[0][0]);
    sum += log_bend;
    squares += log_bend * log_bend;
  }
  const double mean = sum / kSamples;
  std::printf("bend: median %.3g N m, factor %.2f for one standard deviation\n", std::exp(mean),
              std::exp(std::sqrt(squares / kSamples - mean * mean)));
}
