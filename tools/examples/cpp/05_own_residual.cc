// SPDX-License-Identifier: Apache-2.0
// Fits factors on stretching and bending to markers on the cloth by a residual of our own and
// Ceres. usage: 05_own_residual <fabric.json>
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "solver/drapefit.h"

using namespace drape;

// A drape after 2 s by θ = (ln of the factor on stretch, ln of the factor on bend).
DrapeBatch MakeDrape(Backend& backend, const Material& fabric, const double* theta) {
  const Eigen::VectorXd start =
      ApplyStartShape(backend.model().mesh, DrapeDiscs().support, RandomStartShape(1, 3e-3));
  const Eigen::Map<const Eigen::RowVector2d> factors(theta);
  DrapeBatch drape(backend, {fabric.field}, {factors, start.transpose()}, {.h = .05, .steps = 40});
  drape.Run();
  return drape;
}
// Positions of the markers, here all vertices, minus the measured ones [mm].
struct MarkerCost final : ceres::SizedCostFunction<ceres::DYNAMIC, 2> {
  MarkerCost(Backend& b, const Material& m, RowMatrix x)
      : backend(b), fabric(m), measured(std::move(x)) {
    set_num_residuals(static_cast<int>(measured.size()));
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const DrapeBatch drape = MakeDrape(backend, fabric, theta[0]);
    if (!drape.IsFound()[0]) return false;  // Ceres then takes a shorter step
    Eigen::Map<RowMatrix>(residuals, 1, num_residuals()) = 1e3 * (drape.Positions() - measured);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    // A column of the exact Jacobian is the change of the positions in one direction of θ.
    const PositionReadout positions(backend.model().mesh);
    for (int k = 0; k < 2; ++k)
      Eigen::Map<RowMatrix>(jacobians[0], num_residuals(), 2).col(k) =
          1e3 * drape.Jvp(positions, {.log_factors = RowMatrix::Identity(2, 2).row(k)}).transpose();
    return true;
  }
  Backend& backend;
  const Material& fabric;
  const RowMatrix measured;
};
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const Material fabric = ReadMaterial(argv[1]);
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), CusickScene(),
                                                  MakeLaw("smooth"));
  const auto backend = MakeBackend("cpu", model, 1);
  // The measurement: a simulated drape of a fabric with twice the bending stiffness.
  double theta[] = {0.0, 0.0}, known[] = {0.0, std::log(2.0)};
  const RowMatrix measured = MakeDrape(*backend, fabric, known).Positions();
  ceres::Problem problem;
  problem.AddResidualBlock(new MarkerCost(*backend, fabric, measured), nullptr, theta);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres::Solver::Options(), &problem, &summary);
  std::printf("bend times %.4f, stretch times %.4f\n", std::exp(theta[1]), std::exp(theta[0]));
  return std::abs(theta[1] - known[1]) < 0.01 ? 0 : 1;
}
