// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/experiment.h"

#include <cmath>

#include "losses/readout/place_readouts.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "solver/fit/fit.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

constexpr const char* kScene =
    R"({"gravity": [0, 0, -9.81], "handles": {"vertices": [0, 4], "stiffness": 1e4}})";

class ExperimentFileTest : public FileFixture {
 protected:
  // A file of one experiment with these measurements.
  std::string WithMeasurements(const std::string& measurements) const {
    return Write("experiment.json",
                 std::string(R"({"density": 0.15, "experiments": [{"mesh": "strip:0.2x0.2x4",)") +
                     R"("scene": )" + kScene + R"(, "measurements": [)" + measurements + "]}]}");
  }
  Experiment Read(const std::string& measurements) const {
    return std::move(ReadExperiments(WithMeasurements(measurements)).experiments.front());
  }
};

TEST_F(ExperimentFileTest, MarkersAreReadWhereTheyAreOnTheCloth) {
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.11,0.02,-0.03\n0.2,0.1,0.2,0.1,0\n");
  const Experiment experiment =
      Read(R"({"markers": "m.csv", "sigma": 0.01, "loss": {"huber": 2}})");
  EXPECT_EQ(experiment.name, "experiment_1");
  ASSERT_TRUE(experiment.scene.handles);
  EXPECT_EQ(experiment.scene.handles->vertices, (std::vector{0, 4}));
  const std::vector<Sight> sights = MakeSights(experiment, experiment.mesh);
  ASSERT_EQ(sights.size(), 1u);
  EXPECT_EQ(sights[0].readouts.front()->group(), 3);
  const Eigen::VectorXd residual = ReadResiduals(sights[0], experiment.mesh.rest_x).value();
  EXPECT_LT((residual.head(3) - Eigen::Vector3d(-1, -2, 3)).norm(), 1e-9);
  EXPECT_LT(residual.tail(3).norm(), 1e-9);
  // The first marker is √14 sigma away: by Huber's loss of width 2, ρ = 2·2·√14 − 4.
  EXPECT_NEAR(Misfit(experiment, experiment.mesh, experiment.mesh.rest_x).value(),
              std::sqrt((4 * std::sqrt(14.0) - 4) / 6), 1e-9);
  EXPECT_EQ(CountResiduals(experiment, experiment.mesh), 6);
}

TEST_F(ExperimentFileTest, ARegisteredShapeIsAStartOfItsOwn) {
  const Mesh mesh = ParseMeshSpec("strip:0.2x0.2x4");
  Eigen::VectorXd x = mesh.rest_x;
  for (Eigen::Index i = 2; i < x.size(); i += 3) x[i] = -0.1 * x[i - 2];
  WriteObj(Path("scan.obj"), mesh, x);
  const Experiment experiment = Read(R"({"shape": "scan.obj", "sigma": 0.002})");
  EXPECT_LT((experiment.start - x).norm(), 1e-6);
  EXPECT_LT(Misfit(experiment, mesh, x).value(), 1e-3);
  // On another mesh of the cloth too.
  const Mesh finer = ParseMeshSpec("strip:0.2x0.2x8");
  Eigen::VectorXd same = finer.rest_x;
  for (Eigen::Index i = 2; i < same.size(); i += 3) same[i] = -0.1 * same[i - 2];
  EXPECT_LT(Misfit(experiment, finer, same).value(), 1e-3);
  const ClothModel model(finer, experiment.scene, MakeLaw("smooth"));
  EXPECT_LT((MakeStart(experiment, model, 0).x - same).norm(), 1e-6);
  EXPECT_EQ(StartNumber(experiment, ListStarts(experiment)[2]), 2);
}

TEST_F(ExperimentFileTest, PointsDrawClothAndClothDrawsPoints) {
  Write("p.csv", "x,y,z\n0.1,0.0,0.003\n0.05,0.05,0.0\n");
  const Experiment experiment =
      Read(R"({"points": "p.csv", "sigma": 0.001, "spacing": 0.02, "max_distance": 0.05})");
  const std::vector<Sight> sights = MakeSights(experiment, experiment.mesh);
  ASSERT_EQ(sights.size(), 2u);
  EXPECT_EQ(sights[0].data.size(), 6);
  EXPECT_EQ(sights[1].data.size(), experiment.mesh.num_vertices());
  const Eigen::VectorXd residual = ReadResiduals(sights[0], experiment.mesh.rest_x).value();
  EXPECT_NEAR(residual.norm(), 3.0, 1e-9);
}

TEST_F(ExperimentFileTest, BadInputIsOneLineWithItsKey) {
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.5,0.0,0.1,0,0\n");
  Write("good.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.1,0,0\n");
  const std::string good = R"("markers": "good.csv")";
  EXPECT_INPUT_ERROR(Read(R"({"markers": "m.csv", "sigma": 0.01})"), "m.csv");
  EXPECT_INPUT_ERROR(Read("{" + good + "}"), "sigma");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 0})"), "measurements[0].sigma");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "loss": {"l1": 2}})"), "loss");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "loss": {}})"), "huber, cauchy and tukey");
  EXPECT_INPUT_ERROR(Read(R"({"marker": "good.csv", "sigma": 1})"), "one of markers");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "x": 2})"), "'experiments[0]");
  EXPECT_INPUT_ERROR(Read(""), "at least one measurement");
  EXPECT_INPUT_ERROR(
      Read(R"({"angle": 30, "tip": [99], "clamp": [0, 0, 0], "along": [1, 0, 0], "sigma": 1})"),
      "tip[0]");
  EXPECT_INPUT_ERROR(
      Read(R"({"angle": 30, "tip": [4], "clamp": [0, 0, 0], "along": [1, 0, 1], "sigma": 1})"),
      "a horizontal direction");
  std::string points = "x,y,z\n";
  for (int i = 0; i < 90000; ++i) points += "0,0,0\n";
  Write("many.csv", points);
  EXPECT_INPUT_ERROR(Read(R"({"points": "many.csv", "sigma": 1})"), "at most 262144");
  EXPECT_INPUT_ERROR(ReadExperiments(Write("e.json", R"({"experiments": []})")),
                     "at least one experiment");
  EXPECT_INPUT_ERROR(ReadExperiments(Write("e.json", R"({"experiments": [{"name": "../x"}]})")),
                     "name");
  EXPECT_INPUT_ERROR(
      ReadExperiments(Write("e.json", R"({"experiments": [{"mesh": "strip:0.2.x005x4"}]})")),
      "e.json: key 'experiments[0].mesh': strip:0.2.x005x4");
}

// A cost with a loss is what Ceres makes of it: from far outliers the fit turns away.
TEST(RobustBlocks, AnOutlierIsPassedBy) {
  const auto model = std::make_shared<const ClothModel>(
      MakeStrip(0.2, 0.05, 12, 4), CantileverScene(0.01, 9.81), MakeLaw("smooth"));
  const auto backend = MakeCpuBackend(model, 1);
  const MaterialField reference = LinearMaterial(200.0, 5e-5, 0.2);
  const EquilibriumResult rest = SolveFromRest(*backend, reference, {});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  const auto fitted = [&](std::shared_ptr<ceres::LossFunction> loss) {
    Eigen::VectorXd data = rest.x;
    data[data.size() - 1] -= 0.2;
    const TableParametrisation scales(Scaled(reference, 1.0, 0.7), ParameterTying::kBendScale);
    RolloutBlock block{.runs = {{.backend = backend.get(), .start = {rest.x, {}}}},
                       .sights = {{.readouts = {std::make_shared<PositionReadout>(model->mesh)},
                                   .data = data,
                                   .sigma = 1e-3,
                                   .loss = std::move(loss)}}};
    ResidualOptions options;
    options.max_outline_change = options.max_jump = 1e9;
    RolloutResiduals residuals(&scales, {block}, options);
    FitOptions fit;
    fit.prior_sigma = 10.0;
    fit.trust_region.cost_tolerance = 1e-10;
    const FitSummary summary = Fit(residuals, fit);
    // The cost that is reported is that which Ceres lowered.
    EXPECT_NEAR(summary.final_cost, summary.iterations.back().cost,
                1e-6 * summary.final_cost + 1e-9);
    return std::exp(summary.theta[0]) * 0.7;
  };
  EXPECT_GT(std::abs(fitted(nullptr) - 1.0), 0.02);
  EXPECT_NEAR(fitted(std::make_shared<ceres::TukeyLoss>(5.0)), 1.0, 1e-3);
}

}  // namespace
}  // namespace drape
