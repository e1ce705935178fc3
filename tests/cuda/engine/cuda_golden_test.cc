// SPDX-License-Identifier: Apache-2.0
// Parity with what the public reference simulator computes, on the device [MODEL, M20].
#include <fstream>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/mesh/obj_io.h"
#include "tests/cuda/data_folders.h"
#include "tests/cuda/engine/gpu_fixture.h"

namespace drape {
namespace {

using Json = nlohmann::json;

Eigen::VectorXd ToVector(const Json& j) {
  const auto v = j.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

class CudaGoldenTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::ifstream(shared_ + "/golden/materials.json"))
      GTEST_SKIP() << "needs the golden files, found no " << shared_
                   << "/golden/materials.json: set DRAPE_SHARED to the folder with golden/ and "
                      "cusick/";
    DRAPE_NEEDS_GPU();
    material_ =
        ReadMaterial(shared_ + "/golden/materials.json#cotton_blue", {NegativeEntries::kWarn})
            .field;
  }
  Json Golden(const std::string& name) const {
    std::ifstream in(shared_ + "/golden/" + name + "_cotton_blue.json");
    return Json::parse(in);
  }
  std::unique_ptr<Backend> MakeDevice(const std::string& circle) const {
    ObjOptions options;
    options.round_to_float = true;
    return MakeCudaBackend(std::make_shared<ClothModel>(
                               ReadObj(shared_ + "/cusick/mesh_in/" + circle + ".obj", options),
                               CusickScene(), MakeLaw("reference")),
                           1);
  }
  void ExpectSameTrajectory(const std::string& circle) const {
    const Json golden = Golden("trajectory_" + circle);
    const auto device = MakeDevice(circle);
    const State start = device->model().RestState();
    const RolloutInput input{&material_, &start};
    for (const int step : {1, 2, 5, 10, 20, 50, 100}) {
      const auto result = device->Rollouts({&input, 1}, {.h = 0.05, .steps = step}, nullptr);
      const double error =
          (result[0].end.x - ToVector(golden[std::string("x").append(std::to_string(step))]))
              .cwiseAbs()
              .maxCoeff();
      std::printf("%s, step %3d: largest position error %.2e m\n", circle.c_str(), step, error);
      // Rounding is amplified up to 1e6 times until step 50 and damped again after it.
      EXPECT_LT(error, step == 20 || step == 50 ? 1e-6 : 1e-9) << "step " << step;
    }
  }

  std::string shared_ = test::SharedFolder();
  MaterialField material_;
};

TEST_F(CudaGoldenTest, TrajectoryOfCircle1) { ExpectSameTrajectory("circle1"); }
TEST_F(CudaGoldenTest, TrajectoryOfCircle2) { ExpectSameTrajectory("circle2"); }

TEST_F(CudaGoldenTest, GradientsAfter10And100Steps) {
  const auto device = MakeDevice("circle1");
  const Json golden = Golden("gradient_circle1");
  const RowMatrix weights = ToVector(golden["w"]);
  const State start = device->model().RestState();
  const RolloutInput input{&material_, &start};
  for (const int steps : {10, 100}) {
    const RolloutOptions options{.h = 0.05, .steps = steps};
    std::vector<Recording> recording;
    (void)device->Rollouts({&input, 1}, options, &recording);
    const auto adjoint = device->Adjoints({&input, 1}, recording, {&weights, 1}, options);
    const std::string K = std::string("_").append(std::to_string(steps));
    Eigen::VectorXd stretch(kStretchEntries), bend(kBendEntries);
    for (int k = 0; k < kStretchEntries; ++k)  // golden rows are c11 c12 c22 c33
      stretch[k] = golden["gstretch" + K][k % kStretchCols][k / kStretchCols].get<double>();
    for (int k = 0; k < kBendEntries; ++k)
      bend[k] = golden["gbend" + K][k / kBendCols][k % kBendCols].get<double>();
    const double errors[] = {
        test::RelativeError(Eigen::VectorXd(adjoint[0].material.stretch.col(0)), stretch),
        test::RelativeError(Eigen::VectorXd(adjoint[0].material.bend.col(0)), bend),
        test::RelativeError(Eigen::VectorXd(adjoint[0].v0.col(0)), ToVector(golden["gv0" + K]))};
    std::printf("%3d steps: relative error of stretch %.1e, bend %.1e, v0 %.1e\n", steps, errors[0],
                errors[1], errors[2]);
    for (const double error : errors) EXPECT_LT(error, 1e-6) << steps << " steps";
  }
}

}  // namespace
}  // namespace drape
