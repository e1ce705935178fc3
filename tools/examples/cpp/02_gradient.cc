// SPDX-License-Identifier: Apache-2.0
// Differentiates the mean height of a drape by all 39 entries of its fabric, and checks one of the
// derivatives by a difference.
// usage: 02_gradient <fabric.json>
#include <cmath>
#include <cstdio>

#include "solver/drapefit.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 2) return 2;
  const Material fabric = ReadMaterial(argv[1]);
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), CusickScene(),
                                                  MakeLaw("smooth"));
  const auto backend = MakeBackend("cpu", model, 1);
  const Eigen::VectorXd start =
      ApplyStartShape(model->mesh, DrapeDiscs().support, RandomStartShape(1, 3e-3));
  // Three drapes: of the fabric, and of two whose first bend entry is a little larger and smaller.
  // The 39 numbers are logarithms of factors on 24 entries of stretch, then 15 of bend.
  constexpr int kEntry = kStretchEntries;
  constexpr double kStep = 1e-4;
  DrapeInputs inputs{.log_factors = RowMatrix::Zero(3, kMaterialEntries),
                     .start = start.transpose().replicate(3, 1)};
  inputs.log_factors(1, kEntry) = kStep;
  inputs.log_factors(2, kEntry) = -kStep;
  // record: keep what the adjoint needs, so that nothing is simulated again.
  DrapeBatch drapes(*backend, {fabric.field}, inputs, {.h = 0.05, .steps = 20, .record = true});
  drapes.Run();
  // The mean height of the vertices [m] is linear in the positions. Its gradient by them is 1/V for
  // each z.
  const PositionReadout positions(model->mesh);
  RowMatrix by_positions = RowMatrix::Zero(3, positions.size());
  for (int i = 2; i < positions.size(); i += 3)
    by_positions.col(i).setConstant(1.0 / model->mesh.num_vertices());
  // One adjoint gives the gradient by all entries, and by the start as well.
  const DrapeInputs gradient = drapes.Vjp(positions, by_positions);
  const double exact = gradient.log_factors(0, kEntry);
  const Eigen::VectorXd height = drapes.Read(positions).cwiseProduct(by_positions).rowwise().sum();
  const double difference = (height[1] - height[2]) / (2.0 * kStep);
  std::printf("height %.5f m, by the logarithm of a bend entry: adjoint %.6g, difference %.6g m\n",
              height[0], exact, difference);
  return std::abs(exact - difference) <= 1e-4 * std::abs(exact) ? 0 : 1;
}
