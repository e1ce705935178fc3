// SPDX-License-Identifier: Apache-2.0
// Fits a factor on bending to markers on the cloth by a residual of our own and Ceres.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "solver/drapefit.h"
#include "solver/fit/parametrisation.h"

using namespace drape;
constexpr RolloutOptions kSteps{.h = 0.05, .steps = 40};
// Positions of the markers minus the measured ones [mm] by θ = (ln stretch, ln bend).
struct MarkerCost final : ceres::SizedCostFunction<ceres::DYNAMIC, 2> {
  MarkerCost(Backend& b, const TableParametrisation& m, const State& s, const Eigen::VectorXd& x)
      : backend(b), map(m), start(s), measured(x) {
    set_num_residuals(static_cast<int>(x.size()));
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const Eigen::Vector2d t(theta[0]);
    const MaterialField fabric = map.Material(t);
    const MaterialField* weights = &fabric;
    const RolloutInput input{&fabric, &start};
    // Positions, and their derivatives by the logarithms of all 39 entries, shape [3V, 39].
    const TangentResult result = backend.Tangents({&input, 1}, {&weights, 1}, kSteps)[0];
    if (result.rollout.status != RolloutStatus::kOk) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) =
        1e3 * (result.rollout.end.x - measured);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMatrix>(jacobians[0], num_residuals(), 2) =
          1e3 * result.dx * map.LogEntriesByTheta(t);
    return true;
  }
  Backend& backend;
  const TableParametrisation& map;
  const State& start;
  const Eigen::VectorXd& measured;
};
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const TableParametrisation map(ReadMaterial(argv[1]).field, ParameterTying::kScales);
  const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), CusickScene(),
                                                  MakeLaw("smooth"));
  const auto backend = MakeBackend("cpu", model, 1);
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support, RandomStartShape(1, 3e-3));
  // The measurement: a simulated drape of a fabric with twice the bending stiffness.
  const MaterialField known = map.Material(Eigen::Vector2d(0.0, std::log(2.0)));
  const RolloutInput input{&known, &start};
  const Eigen::VectorXd measured = backend->Rollouts({&input, 1}, kSteps, nullptr)[0].end.x;
  double theta[2] = {0.0, 0.0};
  ceres::Problem problem;
  problem.AddResidualBlock(new MarkerCost(*backend, map, start, measured), nullptr, theta);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres::Solver::Options(), &problem, &summary);
  std::printf("bend times %.4f, stretch times %.4f\n", std::exp(theta[1]), std::exp(theta[0]));
  return std::abs(std::exp(theta[1]) - 2.0) < 0.02 ? 0 : 1;
}
