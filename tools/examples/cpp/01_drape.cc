// SPDX-License-Identifier: Apache-2.0
// Drapes a fabric, measures its outline as a laboratory does, and draws what a camera above sees.
// usage: 01_drape <fabric.json> <picture.png>
#include <algorithm>
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 3) return 2;
  // A fabric: tables of stretching and bending stiffness, and a density.
  const Material fabric = ReadMaterial(argv[1]);
  // A scene: a disc of 30 cm on a support of 18 cm, and the law that maps strain to stiffness.
  const DrapeDiscs discs;
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 400}), CusickScene(),
                                                  MakeLaw("smooth"));
  // What simulates it: "cpu" or "cuda", on one thread.
  const auto backend = MakeBackend("cpu", model, 1);
  // A start: the flat cloth with small random waves, which select one of the many stable drapes.
  const Eigen::VectorXd start =
      ApplyStartShape(model->mesh, discs.support, RandomStartShape(1, 3e-3));
  // A batch of one drape, which has one row in each array: 40 steps of 0.1 s, then Newton's method
  // to rest. The factor on bend is exp(0).
  const DrapeInputs inputs{.log_factors = RowMatrix::Zero(1, 1), .start = start.transpose()};
  DrapeBatch drapes(*backend, {fabric.field}, inputs,
                    {.h = 0.1, .steps = 40, .solve_mode = SolveMode::kStatic});
  drapes.Run();
  if (!drapes.IsFound()[0]) {
    std::printf("no drape: %s\n", drapes.status()[0].c_str());
    return 1;
  }
  // Features of the outline, in the order of kShapeFeatureNames.
  const RowMatrix shape = drapes.Read(FeatureReadout(model->mesh, discs));
  std::printf("%s: drape coefficient %.3f, %.0f folds\n", fabric.name.c_str(), shape(0, 0),
              shape(0, 1));
  // The silhouette: the share of each pixel that cloth covers.
  const Camera camera = CameraAbove(discs);
  const RowMatrix coverage = drapes.Read(SilhouetteReadout(model->mesh, {camera}, {}));
  GrayImage picture(camera.width, camera.height);
  std::copy(coverage.data(), coverage.data() + coverage.size(), picture.coverage.begin());
  WritePng(picture, argv[2], discs);
}
