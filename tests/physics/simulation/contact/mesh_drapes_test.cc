// SPDX-License-Identifier: Apache-2.0
// Cloth on triangle meshes in linearly implicit steps and at rest: closed forms and derivatives.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

Obstacle AsObstacle(test::ClosedMesh mesh, const Eigen::Vector3d& move) {
  mesh.x.colwise() += move;
  return std::make_shared<const SurfaceObstacle>(mesh.x, mesh.triangles, Eigen::Matrix3Xd(), 0.03,
                                                 SurfaceBlend::kPlaces);
}

// Held in the middle, at z = 0, on what is below it.
Scene HeldOver(const Obstacle& obstacle, double held, double thickness = 4e-4) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.handles = Handles{.regions = {DiscRegion{.radius = held}}, .stiffness = 1e3};
  scene.contact = Contact{.thickness = thickness, .obstacles = {obstacle}};
  return scene;
}

class MeshDrapesTest : public testing::Test {
 protected:
  static std::unique_ptr<Backend> Make(const Scene& scene, int vertices = 400) {
    return MakeCpuBackend(std::make_shared<ClothModel>(MakeDisc({.target_vertices = vertices}),
                                                       scene, MakeLaw("smooth")),
                          1);
  }
  EquilibriumResult Settle(Backend& backend, const MaterialField& material,
                           const Eigen::VectorXd& x, double tolerance = 1e-9) const {
    const State start{x, Eigen::VectorXd::Zero(x.size())};
    const RolloutInput input{&material, &start};
    return backend.Equilibria({&input, 1}, {.tolerance = tolerance})[0];
  }
  // From the flat cloth.
  Eigen::VectorXd Relax(Backend& backend, int steps = 100) const {
    const State flat = backend.model().RestState();
    const RolloutInput input{&material_, &flat};
    const RolloutResult relaxed =
        backend.Rollouts({&input, 1}, {.h = 0.05, .steps = steps}, nullptr)[0];
    EXPECT_EQ(relaxed.status, RolloutStatus::kOk);
    return relaxed.end.x;
  }
  static double LargestMove(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - b).reshaped(3, a.size() / 3).colwise().norm().maxCoeff();
  }
  // The material with entry k of its 39 times a factor.
  MaterialField Changed(int k, double factor) const {
    MaterialField changed = material_;
    (k < kStretchEntries ? changed.stretch[0].entries()[k]
                         : changed.bend[0].entries()[k - kStretchEntries]) *= factor;
    return changed;
  }
  // Largest error of the columns, of each relative to itself or a thousandth of the longest.
  template <class EndOf>
  double ErrorOfColumns(const RowMatrix& tangent, double step, const EndOf& end) const {
    const double longest = tangent.colwise().norm().maxCoeff();
    double error = 0.0;
    for (int k = 0; k < kMaterialEntries; ++k) {
      const Eigen::VectorXd difference =
          (end(Changed(k, 1 + step)) - end(Changed(k, 1 - step))) / (2 * step);
      const Eigen::VectorXd column = tangent.col(k);
      error =
          std::max(error, (difference - column).norm() / std::max(column.norm(), 1e-3 * longest));
    }
    return error;
  }

  MaterialField material_ = LinearMaterial(500.0, 2e-6, 0.3);
};

// Flat facets push as a plane does, over the edges between them too.
TEST_F(MeshDrapesTest, ATableOfFacetsIsAPlane) {
  const auto on_plane = Make(HeldOver(PlaneObstacle{.offset = -7e-4}, 0.02));
  const auto on_table =
      Make(HeldOver(AsObstacle(test::MakeCube(0.5), {-0.25, -0.25, -0.5 - 7e-4}), 0.02));
  const Eigen::VectorXd plane = Relax(*on_plane, 20), table = Relax(*on_table, 20);
  EXPECT_LT(LargestMove(plane, table), 1e-12);
  EXPECT_LT(SmallestGap(*on_table->model().scene.contact, table), 5e-4);
  const EquilibriumResult rest_on_plane = Settle(*on_plane, material_, plane),
                          rest_on_table = Settle(*on_table, material_, table);
  ASSERT_EQ(rest_on_plane.status, EquilibriumStatus::kStable);
  ASSERT_EQ(rest_on_table.status, EquilibriumStatus::kStable);
  EXPECT_LT(LargestMove(rest_on_plane.x, rest_on_table.x), 1e-9);
}

// The same drape over a ball and over meshes of it, with the square of their edges.
TEST_F(MeshDrapesTest, DrapesOverFinerBallsConvergeToThatOverTheBall) {
  constexpr double kRadius = 0.1;
  const Eigen::Vector3d centre(0.0, 0.0, -kRadius - 8e-4);
  const auto ball = Make(HeldOver(SphereObstacle{.centre = centre, .radius = kRadius}, 0.02));
  const EquilibriumResult rest = Settle(*ball, material_, Relax(*ball));
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  double before = 0.0;
  for (int divisions = 3; divisions <= 6; ++divisions) {
    const auto mesh = Make(HeldOver(AsObstacle(test::MakeBall(kRadius, divisions), centre), 0.02));
    const EquilibriumResult there = Settle(*mesh, material_, rest.x);
    EXPECT_EQ(there.status, EquilibriumStatus::kStable) << divisions;
    const double move = LargestMove(there.x, rest.x);
    if (before > 0.0) {
      EXPECT_LT(move, 0.5 * before) << divisions;
    }
    before = move;
  }
  EXPECT_LT(before, 1e-4);
}

// A strip that slides into the concave edge of a stair with one end.
class StairTest : public MeshDrapesTest {
 protected:
  static constexpr double kTread = 0.2;
  StairTest() {
    Scene scene;
    scene.gravity = Eigen::Vector3d(-5.0, 0.0, -9.8);
    scene.contact = Contact{.obstacles = {AsObstacle(test::MakeStair(kTread, 0.4), move_)}};
    backend_ = MakeCpuBackend(
        std::make_shared<ClothModel>(MakeStrip(0.1, 0.1, 12, 14), scene, MakeLaw("smooth")), 1);
    start_ = backend_->model().RestState();
    std::mt19937_64 random(3);
    for (Eigen::Index i = 0; i < start_.x.size(); ++i) start_.x[i] += 5e-5 * SampleNormal(random);
    input_ = {&material_, &start_};
  }
  const Contact& contact() const { return *backend_->model().scene.contact; }

  // The end is .78 mm from the riser, the strip .66 mm over the tread.
  Eigen::Vector3d move_{-7.8e-4 - kTread, -0.2, -6.6e-4 - kTread};
  std::unique_ptr<Backend> backend_;
  State start_;
  RolloutInput input_;
  RolloutOptions options_{.h = 2e-3, .steps = 8};
};

TEST_F(StairTest, RolloutDerivativesAreDifferences) {
  const std::vector<const MaterialField*> weights = {&material_};
  const TangentResult tangent = backend_->Tangents({&input_, 1}, weights, options_)[0];
  ASSERT_EQ(tangent.rollout.status, RolloutStatus::kOk);
  int pushed = 0, blended = 0;
  for (Eigen::Index i = 0; i < start_.x.size(); i += 3) {
    const ObstacleDistance at =
        DistanceTo(contact().obstacles[0], tangent.rollout.end.x.segment<3>(i));
    pushed += at.value - contact().offset() < contact().range;
    blended += at.value - contact().offset() < contact().range && at.curvature.trace() < -100.0;
  }
  EXPECT_GT(pushed, 100);
  EXPECT_GT(blended, 0);
  const double error = ErrorOfColumns(tangent.dx, 3e-4, [&](const MaterialField& material) {
    const RolloutInput input{&material, &start_};
    return backend_->Rollouts({&input, 1}, options_, nullptr)[0].end.x;
  });
  EXPECT_LT(error, 1e-6);
  std::vector<Recording> recordings;
  ASSERT_EQ(backend_->Rollouts({&input_, 1}, options_, &recordings)[0].status, RolloutStatus::kOk);
  const RowMatrix u = RowMatrix::Random(start_.x.size(), 2);
  const AdjointResult adjoint =
      backend_->Adjoints({&input_, 1}, recordings, std::vector<RowMatrix>{u}, options_)[0];
  ASSERT_EQ(adjoint.status, RolloutStatus::kOk);
  const RowMatrix by_tangent = tangent.dx.transpose() * u,
                  by_adjoint = adjoint.material.Contract(material_);
  EXPECT_LT((by_adjoint - by_tangent).norm(), 1e-10 * by_tangent.norm());
}

// At rest over edges and corners, whose distance is curved, and over a stair; the cloth is thick,
// so that more of its vertices are over them.
TEST_F(MeshDrapesTest, DerivativesOfEquilibriaAreDifferences) {
  material_ = LinearMaterial(500.0, 3e-6, 0.3);
  for (const Obstacle& obstacle :
       {AsObstacle(test::MakeBall(0.1, 0), {0.0, 0.0, -0.1 - 2.6e-3}),
        AsObstacle(test::MakeBall(0.06, 2), {0.0, 0.0, -0.06 - 2.6e-3}),
        AsObstacle(test::MakeStair(0.03, 0.1), {-0.01, -0.05, -0.06 - 2.6e-3})}) {
    const auto backend = Make(HeldOver(obstacle, 0.02, 4e-3));
    const Contact& contact = *backend->model().scene.contact;
    const EquilibriumResult rest = Settle(*backend, material_, Relax(*backend), 5e-12);
    ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
    int curved = 0;
    for (Eigen::Index i = 0; i < rest.x.size(); i += 3) {
      const ObstacleDistance at = DistanceTo(obstacle, rest.x.segment<3>(i));
      curved +=
          at.value - contact.offset() < contact.range && std::abs(at.curvature.trace()) > 100.0;
    }
    const State at{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
    const RolloutInput input{&material_, &at};
    const std::vector<const MaterialField*> weights = {&material_};
    const RowMatrix tangent = backend->EquilibriumTangents({&input, 1}, weights)[0];
    ASSERT_EQ(tangent.cols(), kMaterialEntries);
    const double error = ErrorOfColumns(tangent, 3e-5, [&](const MaterialField& material) {
      return Settle(*backend, material, rest.x, 5e-12).x;
    });
    EXPECT_GT(curved, 1);
    EXPECT_LT(error, 1e-6);
    const RowMatrix u = RowMatrix::Random(rest.x.size(), 2);
    const auto gradient = backend->EquilibriumAdjoints({&input, 1}, std::vector<RowMatrix>{u})[0];
    ASSERT_TRUE(gradient);
    const RowMatrix by_tangent = tangent.transpose() * u;
    EXPECT_LT((gradient->Contract(material_) - by_tangent).norm(), 1e-9 * by_tangent.norm());
  }
}

TEST_F(MeshDrapesTest, AMeshThatNothingTouchesChangesNoBit) {
  Scene without = CusickScene(), with = CusickScene();
  with.contact = Contact{.obstacles = {AsObstacle(test::MakeStair(0.1, 0.2), {0.3, 0.0, -0.1})}};
  const auto free = Make(without), beside = Make(with);
  const RolloutOptions options{.h = 0.05, .steps = 10};
  const State start = free->model().RestState();
  const RolloutInput input{&material_, &start};
  const std::vector<const MaterialField*> weights = {&material_};
  const TangentResult a = free->Tangents({&input, 1}, weights, options)[0],
                      b = beside->Tangents({&input, 1}, weights, options)[0];
  EXPECT_EQ(a.rollout.end.x, b.rollout.end.x);
  EXPECT_EQ(a.dx, b.dx);
}

}  // namespace
}  // namespace drape
