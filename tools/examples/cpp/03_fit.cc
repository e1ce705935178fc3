// SPDX-License-Identifier: Apache-2.0
// Fits a fabric to one silhouette and prints what the fit can tell.
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 3) return 2;
  const Observation image = ReadImageObservation(argv[1], {});
  FitSpec spec;
  spec.mesh = spec.search_mesh = "disc:300";
  spec.simpler_models = false;
  const FitReport fit = FitDrapes(spec, ReadMaterial(argv[2]).field, {image});
  if (!fit.fitted()) return 1;
  const StiffnessEstimate& bend = fit.stiffness->bend;
  std::printf("%s: bending rigidity %.3g uN m, 90 %% interval %.3g to %.3g\n",
              ToString(fit.verdict.grade), 1e6 * bend.value, 1e6 * bend.value / bend.factor(),
              1e6 * bend.value * bend.factor());
}
