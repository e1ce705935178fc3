// SPDX-License-Identifier: Apache-2.0
// Parity of the `reference` law with the public reference simulator [MODEL, M20].
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_io.h"
#include "physics/mesh/obj_io.h"
#include "physics/simulation/rollout.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

using Json = nlohmann::json;

const std::string kShared = DRAPE_SHARED_DIR;

Json Golden(const std::string& name) {
  std::ifstream in(kShared + "/golden/" + name + "_cotton_blue.json");
  return Json::parse(in);
}

Eigen::VectorXd ToVector(const Json& j) {
  const auto v = j.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

double RelativeError(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).norm() / b.norm();
}

class GoldenTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::ifstream(kShared + "/golden/materials.json"))
      GTEST_SKIP() << "no golden data in " << kShared;
    material_ =
        ReadMaterial(kShared + "/golden/materials.json#cotton_blue", {NegativeEntries::kWarn})
            .field;
  }
  std::shared_ptr<const ClothModel> Model(const std::string& circle) {
    ObjOptions options;
    options.round_to_float = true;
    return std::make_shared<ClothModel>(
        ReadObj(kShared + "/cusick/mesh_in/" + circle + ".obj", options), CusickScene(),
        MakeLaw("reference"));
  }
  MaterialField material_;
};

TEST_F(GoldenTest, ForcesAndStepMatrixAgreeTo1em12) {
  const auto model = Model("circle1");
  const Json golden = Golden("force_circle1");
  const Eigen::VectorXd x = ToVector(golden["pert_x"]);
  Eigen::VectorXd force;
  BlockMatrix A(model->pattern);
  AssembleStep(*model, material_, x, 1.0, force, A);
  const double force_error = RelativeError(force, ToVector(golden["pert_f"]));
  EXPECT_LT(force_error, 1e-12);

  // A − M = −J at h = 1, as a dense matrix.
  const int n = model->num_dofs();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, n), expected = J;
  const RowMatrix identity = RowMatrix::Identity(n, n);
  RowMatrix product = RowMatrix::Zero(n, n);
  AddMultiply(model->pattern, A, identity, product);
  J = -product;
  J.diagonal() += model->LumpedMass(material_.density);
  const auto rows = golden["pert_J_row"].get<std::vector<int>>();
  const auto cols = golden["pert_J_col"].get<std::vector<int>>();
  const auto values = golden["pert_J_val"].get<std::vector<double>>();
  for (std::size_t k = 0; k < rows.size(); ++k) expected(rows[k], cols[k]) += values[k];
  const double matrix_error = (J - expected).norm() / expected.norm();
  EXPECT_LT(matrix_error, 1e-12);
  std::printf("relative error of the force %.1e, of J %.1e\n", force_error, matrix_error);
}

void ExpectSameTrajectory(const Json& golden, StepSolver& solver, const MaterialField& material) {
  State state = solver.model().RestState();
  int done = 0;
  for (const int step : {1, 2, 5, 10, 20, 50, 100}) {
    RolloutOptions options;
    options.steps = step - done;
    const RolloutResult result = Rollout(solver, material, state, options);
    ASSERT_EQ(result.status, RolloutStatus::kOk);
    state = result.end;
    done = step;
    const double error = (state.x - ToVector(golden[std::string("x").append(std::to_string(step))]))
                             .cwiseAbs()
                             .maxCoeff();
    std::printf("step %3d: largest position error %.2e m\n", step, error);
    // Rounding is amplified up to 1e6 times until step 50 and damped again after it.
    EXPECT_LT(error, step == 20 || step == 50 ? 1e-6 : 1e-9) << "step " << step;
  }
}

TEST_F(GoldenTest, TrajectoryOfCircle1) {
  StepSolver solver(Model("circle1"));
  ExpectSameTrajectory(Golden("trajectory_circle1"), solver, material_);
}

TEST_F(GoldenTest, TrajectoryOfCircle2) {
  StepSolver solver(Model("circle2"));
  ExpectSameTrajectory(Golden("trajectory_circle2"), solver, material_);
}

TEST_F(GoldenTest, GradientsAfter10And100Steps) {
  StepSolver solver(Model("circle1"));
  const Json golden = Golden("gradient_circle1");
  const RowMatrix weights = ToVector(golden["w"]);
  for (const int steps : {10, 100}) {
    RolloutOptions options;
    options.steps = steps;
    Recording recording;
    const State start = solver.model().RestState();
    const RolloutResult result = Rollout(solver, material_, start, options, &recording);
    const AdjointResult adjoint = RolloutAdjoint(solver, material_, options, recording, weights);
    const std::string K = std::string("_").append(std::to_string(steps));
    EXPECT_NEAR(weights.col(0).dot(result.end.x), golden["L" + K].get<double>(), 1e-10);

    Eigen::VectorXd stretch(kStretchEntries), bend(kBendEntries);
    for (int m = 0; m < kStretchCols; ++m)  // golden rows are c11 c12 c22 c33
      for (int r = 0; r < kStretchRows; ++r)
        stretch[r * kStretchCols + m] = golden["gstretch" + K][m][r].get<double>();
    for (int k = 0; k < kBendEntries; ++k)
      bend[k] = golden["gbend" + K][k / kBendCols][k % kBendCols].get<double>();
    const double errors[] = {RelativeError(adjoint.material.stretch, stretch),
                             RelativeError(adjoint.material.bend, bend),
                             RelativeError(adjoint.v0, ToVector(golden["gv0" + K]))};
    std::printf("%3d steps: relative error of stretch %.1e, bend %.1e, v0 %.1e\n", steps, errors[0],
                errors[1], errors[2]);
    for (double error : errors) EXPECT_LT(error, 1e-6) << steps << " steps";
  }
}

}  // namespace
}  // namespace drape
