// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/scene_io.h"

#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/rollout.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

const std::string kScenes = std::string(DRAPE_SOURCE_DIR) + "/configs/scenes/";

class SceneFile : public FileFixture {};

TEST_F(SceneFile, ListsOnlyWhatActs) {
  const Scene empty = ReadScene(Write("a.json", "{}"));
  EXPECT_TRUE(empty.stretch);
  EXPECT_TRUE(empty.bend);
  EXPECT_FALSE(empty.gravity || empty.handles || empty.load);
  const Scene scene = ReadScene(Write("b.json", R"({"bend": false, "gravity": [1, 2, 3],
      "load": {"region": {"half_plane": {"normal": [0, -2, 0], "offset": -0.1}}, "force": [0, 4, 0]},
      "handles": {"region": {"ring": {"inner": 0.1}}, "stiffness": 7}})"));
  EXPECT_FALSE(scene.bend);
  EXPECT_EQ(*scene.gravity, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(std::get<RingRegion>(scene.handles->regions.front()).inner, 0.1);
  EXPECT_EQ(scene.handles->stiffness, 7.0);
  EXPECT_EQ(std::get<HalfPlaneRegion>(scene.load->region).normal, -Eigen::Vector3d::UnitY());
  // normal·x ≤ offset, whatever the length of the normal: here y ≥ 0.05.
  EXPECT_TRUE(Contains(scene.load->region, {0.0, 0.06, 0.0}));
  EXPECT_FALSE(Contains(scene.load->region, {0.0, 0.04, 0.0}));
  EXPECT_EQ(scene.load->force.y(), 4.0);
}

TEST_F(SceneFile, BadValuesAreNamed) {
  const auto expect = [&](const std::string& text, const std::string& message) {
    EXPECT_INPUT_ERROR(ReadScene(Write("a.json", text)), message);
  };
  expect(R"({"gravty": [0, 0, -9]})", "unknown key 'gravty', allowed: stretch bend gravity");
  expect(R"({"gravity": [0, -9]})", "a.json: key 'gravity': found an array of 2");
  expect(R"({"bend": 1})", "key 'bend': found 1, expected true or false");
  expect(R"({"handles": {"region": {}, "stiffness": 1}})", "one of disc, ring, half_plane");
  expect(R"({"handles": {"region": {"disc": {"radius": -1}}, "stiffness": 1}})",
         "key 'handles.region.disc.radius': found -1");
  expect(R"({"handles": {"region": {"disc": {"radius": 1}}, "stiffness": 0}})",
         "'handles.stiffness'");
  expect(R"({"load": {"region": {"half_plane": {"offset": 1}}}})", "'load.force' is missing");
  const auto handles = [](const std::string& held) {
    return R"({"handles": {)" + held + R"(, "stiffness": 1}})";
  };
  expect(handles(R"("regions": [{"disc": {"radius": 1}}, {"disk": {"radius": 1}}])"),
         "a.json: unknown key 'handles.regions[1].disk', allowed: disc ring half_plane");
  expect(handles(R"("regions": [{"disc": {"radius": 1, "centre": [0, 0, 0]}}])"),
         "a.json: key 'handles.regions[0].disc.centre': found an array of 3");
  expect(handles(R"("regions": {"disc": {"radius": 1}})"), "'handles.regions': found an object");
  expect(handles(R"("region": {"disc": {"radius": 1}}, "regions": [])"),
         "a.json: key 'handles': found an object, expected region or regions, not both");
  expect(handles(R"("regions": [])"), "expected region, regions or vertices");
  expect(handles(R"("vertices": [2, -1])"), "'handles.vertices[1]': found -1, expected a whole");
  expect(handles(R"("vertices": [0.5])"), "'handles.vertices[0]': found 0.5");
}

TEST_F(SceneFile, ContactOfTheClothWithItselfIsAnOption) {
  const auto read = [&](const std::string& text) {
    return ReadScene(Write("a.json", R"({"contact": {"obstacles": [])" + text + "}}"))
        .contact->self;
  };
  EXPECT_FALSE(read(""));
  EXPECT_TRUE(read(R"(, "self": true)"));
  EXPECT_INPUT_ERROR(read(R"(, "self": 1)"), "'contact.self': found 1, expected true or false");
}

TEST_F(SceneFile, AbsurdValuesAreRefused) {
  const auto expect = [&](const std::string& text, const std::string& message) {
    EXPECT_INPUT_ERROR(ReadScene(Write("a.json", text)), message);
  };
  expect(R"({"gravity": [0, 0, -1e308]})", "'gravity[2]': found -1e+308");
  expect(R"({"handles": {"region": {"disc": {"radius": 1e308}}, "stiffness": 1}})", "radius");
  expect(R"({"handles": {"vertices": [0], "stiffness": 1e300}})", "'handles.stiffness'");
  expect(R"({"handles": {"region": {"disc": {"radius": 1, "centre": [0, 1e9]}}, "stiffness": 1}})",
         "'handles.region.disc.centre[1]'");
  expect(R"({"load": {"region": {"half_plane": {"offset": 1}}, "force": [1e308, 0, 0]}})",
         "'load.force[0]'");
  expect(R"({"load": {"region": {"half_plane": {"offset": 1, "normal": [1e-320, 0, 0]}},
             "force": [1, 0, 0]}})",
         "'load.region.half_plane.normal'");
}

TEST_F(SceneFile, HoldsSeveralRegionsAndVertices) {
  const Scene scene = ReadScene(Write("a.json", R"({"handles": {"stiffness": 3, "vertices": [5, 2],
      "regions": [{"ring": {"inner": 0.1, "centre": [0.1, -0.2]}}, {"half_plane": {"offset": 1}},
                  {"disc": {"radius": 0.02, "centre": [0.3, 0.4]}}]}})"));
  const auto& regions = scene.handles->regions;
  ASSERT_EQ(regions.size(), 3u);
  EXPECT_EQ(std::get<RingRegion>(regions[0]).centre, Eigen::Vector3d(0.1, -0.2, 0));
  EXPECT_EQ(std::get<HalfPlaneRegion>(regions[1]).offset, 1.0);
  EXPECT_EQ(std::get<DiscRegion>(regions[2]).centre, Eigen::Vector3d(0.3, 0.4, 0));
  EXPECT_EQ(scene.handles->vertices, (std::vector<int>{5, 2}));
}

TEST(ShippedScene, CusickIsTheDefault) {
  const Scene scene = ReadScene(kScenes + "cusick.json"), expected = CusickScene();
  EXPECT_EQ(*scene.gravity, *expected.gravity);
  EXPECT_EQ(SupportRadius(scene), SupportRadius(expected));
  EXPECT_EQ(scene.handles->stiffness, expected.handles->stiffness);
}

Eigen::VectorXd AtRest(const std::string& scene, const std::string& mesh,
                       const MaterialField& material, EquilibriumOptions options = {}) {
  StepSolver solver(std::make_shared<const ClothModel>(
      ParseMeshSpec(mesh), ReadScene(kScenes + scene + ".json"), MakeLaw("smooth")));
  const EquilibriumResult rest = SolveFromRest(solver, material, options);
  EXPECT_EQ(rest.status, EquilibriumStatus::kStable) << scene << " " << rest.residual;
  return rest.x;
}

// A square with its mesh hangs from two corners; both are symmetric about u = 0.1 m.
struct TwoCorners {
  std::shared_ptr<const ClothModel> model = std::make_shared<const ClothModel>(
      ParseMeshSpec("strip:0.2x0.2x20"), ReadScene(kScenes + "two_corners.json"),
      MakeLaw("smooth"));
  MaterialField material = LinearMaterial(100.0, 1e-5, 0.2);
  StepSolver solver{model};

  Eigen::Vector3d At(const Eigen::VectorXd& x, int i) const { return x.segment<3>(3 * i); }
  int Mirror(int i) const {
    const Eigen::Vector2d place(0.2 - model->mesh.uv(0, i), model->mesh.uv(1, i));
    Eigen::Index nearest;
    EXPECT_LT((model->mesh.uv.colwise() - place).colwise().norm().minCoeff(&nearest), 1e-12);
    return static_cast<int>(nearest);
  }
};

TEST(ShippedScene, TwoCornersHoldASymmetricDrape) {
  TwoCorners square;
  const int count = square.model->mesh.num_vertices();
  ASSERT_EQ(square.model->held.size(), 2u);
  const State end =
      Rollout(square.solver, square.material, square.model->RestState(), {.steps = 20}).end;
  double lowest = 0.0, asymmetry = 0.0;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d here = square.At(end.x, i), there = square.At(end.x, square.Mirror(i));
    asymmetry =
        std::max(asymmetry, (here - Eigen::Vector3d(0.2 - there.x(), there.y(), there.z())).norm());
    lowest = std::min(lowest, here.z());
  }
  EXPECT_LT(asymmetry, 1e-9);
  EXPECT_LT(lowest, -0.1);  // it hangs
  for (const int i : square.model->held)
    EXPECT_LT((square.At(end.x, i) - square.At(square.model->mesh.rest_x, i)).norm(), 1e-3);
}

// Σ m·(v' − v) = h·(weight + forces of the handles at x'): forces within the cloth sum to zero.
TEST(ShippedScene, OnlyGravityAndTheCornersChangeTheMomentum) {
  TwoCorners square;
  const Eigen::VectorXd mass = square.model->LumpedMass(square.material.density);
  const auto momentum = [&](const State& state) -> Eigen::Vector3d {
    return mass.cwiseProduct(state.v).reshaped(3, mass.size() / 3).rowwise().sum();
  };
  const State start =
      Rollout(square.solver, square.material, square.model->RestState(), {.steps = 5}).end;
  const RolloutOptions one{.h = 0.05, .steps = 1};
  const State end = Rollout(square.solver, square.material, start, one).end;
  Eigen::Vector3d force = mass.sum() / 3.0 * *square.model->scene.gravity;
  for (const int i : square.model->held)
    force -= square.model->scene.handles->stiffness *
             (square.At(end.x, i) - square.At(square.model->mesh.rest_x, i));
  const Eigen::Vector3d change = momentum(end) - momentum(start);
  EXPECT_LT((change - one.h * force).norm(), 1e-10 * momentum(start).norm());
  EXPECT_GT(change.norm(), 1e-3 * momentum(start).norm());
}

// The overhang is 6 cm; the strip is so narrow that it is a beam, and its triangles are
// equilateral.
TEST(ShippedScene, CantileverFallsToTheAngleOfTheStandard) {
  const std::string mesh = "strip:0.07x0.00361x84";
  const double EI = 0.2 * 9.81 * std::pow(0.06, 3) / 8.0042;
  const Eigen::VectorXd x = AtRest("cantilever", mesh, LinearBeam(200.0, EI, 0.2));
  const Eigen::Vector3d tip = Eigen::Vector3d(0.07, 0, 0) + TipMove(ParseMeshSpec(mesh), x);
  EXPECT_NEAR(std::atan2(-tip.z(), tip.x() - 0.01) * 180.0 / M_PI, 41.5, 0.5);
}

TEST(ShippedScene, HangingStripStretchesByItsWeight) {
  const std::string mesh = "strip:0.3x0.02x60";
  const Eigen::VectorXd x = AtRest("hanging_strip", mesh, LinearMaterial(100.0, 1e-6, 0.2));
  const double load = 0.2 * 9.81 * 0.3;
  EXPECT_NEAR(TipMove(ParseMeshSpec(mesh), x).x() / 0.3, load / 200.0 * (1.0 - load / 100.0), 3e-6);
}

TEST(ShippedScene, UniaxialStretchesInClosedForm) {
  const std::string mesh = "strip:0.2x0.05x40";
  EquilibriumOptions options;
  options.tolerance = 1e-8;
  const Eigen::VectorXd x = AtRest("uniaxial", mesh, LinearMaterial(100.0, 1e-3, 0.2), options);
  const double l = 1.0 + TipMove(ParseMeshSpec(mesh), x).x() / 0.2;
  EXPECT_NEAR(100.0 * (l * l - 1.0) * l / 2.0, 0.5 / 0.05, 0.01);
}

// The disc is held from a ring of vertices outwards. 3 %: hinges of unstructured meshes are softer
// than a plate by 2.1 to 3.0 % on 1,000 to 4,800 vertices [MODEL, M58].
TEST(ShippedScene, ClampedDiscSagsAsAPlate) {
  const double D = 1e-6, density = 2e-5;  // soft in comparison with the springs of the clamp
  EquilibriumOptions options;
  options.tolerance = 1e-5;  // of a weight of 14 µN
  const Eigen::VectorXd x =
      AtRest("disc_clamped", "disc:1200", LinearMaterial(0.1, D, density), options);
  constexpr double kRadius = 0.09;
  double sag = 0.0;
  for (Eigen::Index i = 2; i < x.size(); i += 3) sag = std::max(sag, -x[i]);
  EXPECT_NEAR(sag * 64.0 * D / (density * 9.81 * std::pow(kRadius, 4)), 1.0, 0.03);
}

}  // namespace
}  // namespace drape
