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
  const LaboratoryRow& bend = fit.sheet.of("bending_in_drape_un_m");
  std::printf("%s: %s\n", ToString(fit.verdict.bending.grade), bend.Text().c_str());
}
