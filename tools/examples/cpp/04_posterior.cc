// SPDX-License-Identifier: Apache-2.0
// Samples fabrics from the posterior of one silhouette, says which quantities the silhouette has
// measured and which are from the prior, and drapes some of the samples.
// usage: 04_posterior <silhouette.png> <start.json>
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 3) return 2;
  // Model bayes: the fit of one table, then the distribution of its free numbers. Here these are
  // two: a factor on stretching and a factor on bending.
  FitSpec spec;
  spec.mesh = "disc:300";
  spec.simpler_models = false;
  spec.model = FitModel::kBayes;
  spec.stages.parameters = ParameterTying::kScales;
  const DrapeFit fit = FitDrapes(spec, {.drapes = {ReadImageObservation(argv[1], spec.observation)},
                                        .start = ReadMaterial(argv[2]).field});
  if (!fit.fitted()) return 1;
  const Posterior posterior = SamplePosterior(fit, 200, /*seed=*/1);
  // A k-hat below 0.7 says that the samples are reliable.
  std::printf("k-hat %.2f\n", posterior.pareto_k);
  // Each quantity has a value for each sample. "from the prior": the silhouette does not tell.
  for (const PosteriorQuantity& quantity : posterior.quantities)
    std::printf("%-28s %9.3g (%.3g to %.3g) %s, %s\n", quantity.name.c_str(),
                quantity.Quantile(0.5), quantity.Quantile(0.05), quantity.Quantile(0.95),
                quantity.unit.c_str(), quantity.source.c_str());
  // How further drapes of the fabric may look: one drape of each of eight samples.
  constexpr int kDrapes = 8;
  const std::vector<MaterialField> fabrics(posterior.fabrics.begin(),
                                           posterior.fabrics.begin() + kDrapes);
  const auto backend = MakeBackend("cpu", fit.cloth, 1);
  DrapeInputs inputs{.log_factors = RowMatrix::Zero(kDrapes, 1),
                     .start = RowMatrix(kDrapes, fit.cloth->num_dofs())};
  for (int i = 0; i < kDrapes; ++i)
    inputs.start.row(i) =
        ApplyStartShape(fit.cloth->mesh, DrapeDiscs().support, RandomStartShape(i, 3e-3));
  DrapeBatch drapes(*backend, fabrics, inputs, {.h = 0.05, .steps = 60});
  drapes.Run();
  const Eigen::VectorXd coefficients =
      drapes.Read(FeatureReadout(fit.cloth->mesh, DrapeDiscs())).col(0);
  std::printf("drape coefficients of further drapes: %.3f to %.3f\n", coefficients.minCoeff(),
              coefficients.maxCoeff());
  return posterior.of("bending_in_drape_un_m").measured() ? 0 : 1;
}
