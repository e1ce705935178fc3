// SPDX-License-Identifier: Apache-2.0
// Fits a fabric to one silhouette and prints what the fit can tell.
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 3) return 2;
  FitSpec spec;  // with the defaults of drape_fit
  spec.mesh = "disc:300";
  const DrapeFit fit = FitDrapes(spec, {.drapes = {ReadImageObservation(argv[1], spec.observation)},
                                        .start = ReadMaterial(argv[2]).field});
  if (!fit.fitted()) return 1;
  const StiffnessEstimate& bend = fit.stiffness.bend;
  std::printf("%s: bending rigidity %.3g uN m, 90 %% interval %.3g to %.3g\n",
              ToString(fit.verdict.grade), 1e6 * bend.value, 1e6 * bend.value / bend.factor(),
              1e6 * bend.value * bend.factor());
}
