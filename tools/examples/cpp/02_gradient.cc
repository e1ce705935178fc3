// SPDX-License-Identifier: Apache-2.0
// Differentiates the mean height of a drape by all 39 entries of its fabric, and checks one of
// them.
#include <cmath>
#include <cstdio>

#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "solver/drapefit.h"

namespace {

// The mean height of all vertices [m]. x: positions, shape [3V].
double MeanHeight(const Eigen::VectorXd& x) {
  double sum = 0.0;
  for (Eigen::Index i = 2; i < x.size(); i += 3) sum += x[i];
  return 3.0 * sum / static_cast<double>(x.size());
}

}  // namespace

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 2) return 2;
  MaterialField fabric = ReadMaterial(argv[1]).field;
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), CusickScene(),
                                                  MakeLaw("smooth"));
  const auto backend = MakeBackend("cpu", model, 1);
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support, RandomStartShape(1, 3e-3));
  const RolloutInput input{&fabric, &start};
  const RolloutOptions options{.h = 0.05, .steps = 20};
  // The forward simulation records what the adjoint needs.
  std::vector<Recording> recording;
  const Eigen::VectorXd x = backend->Rollouts({&input, 1}, options, &recording)[0].end.x;
  // The gradient of the mean height by the positions at the end, shape [3V, 1].
  RowMatrix by_x = RowMatrix::Zero(x.size(), 1);
  for (Eigen::Index i = 2; i < x.size(); i += 3) by_x(i, 0) = 3.0 / static_cast<double>(x.size());
  const AdjointResult adjoint = backend->Adjoints({&input, 1}, recording, {&by_x, 1}, options)[0];
  const double exact = adjoint.material.bend(0, 0);
  // The same number by a central difference.
  const double step = 1e-4 * fabric.bend[0].b[0][0];
  double height[2];
  for (int side = 0; side < 2; ++side) {
    fabric.bend[0].b[0][0] += side == 0 ? step : -2.0 * step;
    height[side] = MeanHeight(backend->Rollouts({&input, 1}, options, nullptr)[0].end.x);
  }
  const double difference = (height[0] - height[1]) / (2.0 * step);
  std::printf("by the first entry of bend: adjoint %.6g, difference %.6g m/(N m)\n", exact,
              difference);
  return std::abs(exact - difference) <= 1e-4 * std::abs(exact) ? 0 : 1;
}
