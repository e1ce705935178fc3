// SPDX-License-Identifier: Apache-2.0
// Fits a fabric to one silhouette, prints what the fit can tell, and writes the fitted fabric.
// usage: 03_fit <silhouette.png> <start.json> <fitted.json>
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 4) return 2;
  // How to fit. The defaults are those of drape_fit; here fewer vertices and models, for speed.
  FitSpec spec;
  spec.mesh = "disc:300";
  spec.simpler_models = false;
  // What to fit: a silhouette, and the tables from which the fit starts. Of the fabric's weight
  // nothing is known here; `density` would say it [kg/m²].
  const Material start = ReadMaterial(argv[2]);
  const DrapeFit fit = FitDrapes(
      spec, {.drapes = {ReadImageObservation(argv[1], spec.observation)}, .start = start.field});
  if (!fit.fitted()) return 1;
  // Whether to trust it, and why not.
  std::printf("verdict: %s\n", ToString(fit.verdict.grade));
  for (const std::string& reason : fit.verdict.reasons) std::printf("  %s\n", reason.c_str());
  // The fabric as laboratories report it, with 90 % intervals: what the drape has measured.
  for (const LaboratoryRow& row : fit.sheet.rows)
    if (row.source.starts_with("measured") && row.interval)
      std::printf("%s: %.3g %s (%.3g to %.3g), %s\n", row.name.c_str(), row.value, row.unit.c_str(),
                  row.interval->low, row.interval->high, row.source.c_str());
  WriteMaterial(argv[3], {.name = "fitted", .field = fit.material});
}
