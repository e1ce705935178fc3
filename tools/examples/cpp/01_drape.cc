// SPDX-License-Identifier: Apache-2.0
// Drapes a fabric and measures what a camera above sees.
#include <cstdio>

#include "losses/outline/outline.h"
#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 2) return 2;
  // A fabric: tables of stretching and bending stiffness, and a density.
  const Material fabric = ReadMaterial(argv[1]);
  // A scene: a disc of 30 cm on a support of 18 cm, and the law that maps strain to stiffness.
  const DrapeDiscs discs;
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 400}), CusickScene(),
                                                  MakeLaw("smooth"));
  // A start: the flat cloth with small random waves, which select one of the many stable drapes.
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, discs.support, RandomStartShape(1, 3e-3));
  // One rollout of 100 steps of 0.05 s. A batch holds any number of inputs.
  const RolloutInput input{&fabric.field, &start};
  const auto backend = MakeBackend("cpu", model, 1);
  const RolloutResult drape = backend->Rollouts({&input, 1}, {.h = 0.05, .steps = 100}, nullptr)[0];
  if (drape.status != RolloutStatus::kOk) return 1;
  // The outline in the image of a camera above, and the laboratory's measures of it.
  const Camera camera;
  Outline outline;
  if (!OutlineFromMesh(model->mesh, drape.end.x, camera, 360, &outline)) return 1;
  const ShapeFeatures shape = MeasureShape(MetresFromPixels(outline.radius, camera), discs);
  std::printf("%s: drape coefficient %.3f, %d folds\n", fabric.name.c_str(),
              shape.drape_coefficient, shape.folds);
}
