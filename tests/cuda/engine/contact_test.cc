// SPDX-License-Identifier: Apache-2.0
// Contact on a device beside the CPU's.
#include <memory>
#include <span>
#include <vector>

#include "cuda/engine/cuda_backend.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/simulation/textbook.h"
#include "tests/cuda/engine/gpu_fixture.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using test::RelativeError;

// So soft and heavy that it hangs straight down from the rim of the support. Others are stiffer.
MaterialField Soft(double level) { return LinearMaterial(500.0 * level, 5e-8 * level, 0.3); }

// A batch of a disc in a scene with contact.
class CudaContact : public testing::TestWithParam<const char*> {
 protected:
  void Load(const Scene& scene, int vertices, int count) {
    DRAPE_NEEDS_GPU();
    model_ = std::make_shared<const ClothModel>(MakeDisc({.target_vertices = vertices}), scene,
                                                MakeLaw(GetParam()));
    device_ = MakeCudaBackend(model_, 2);
    host_ = MakeCpuBackend(model_, 2);
    fields_.clear();
    starts_.clear();
    for (int i = 0; i < count; ++i) {
      fields_.push_back(Soft(1.0 + 0.2 * i));
      if (i % 2 == 1) fields_.back() = test::Scatter(fields_.back(), model_->mesh, 0.2, random_);
      starts_.push_back(test::NoisyStart(*model_, 1e-4, random_));
    }
    Point();
  }
  void Point() {
    inputs_.clear();
    weights_.clear();
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      inputs_.push_back({&fields_[i], &starts_[i]});
      weights_.push_back(&fields_[i]);
    }
  }
  // Drapes over the support until they are at rest there, on the host.
  void LoadSupportedDrapes(int vertices, int count) {
    Load(CusickScene({ContactModel::kSupport}), vertices, count);
    if (IsSkipped()) return;
    Relax();
    const auto rests = host_->Equilibria(inputs_, {});
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      ASSERT_EQ(rests[i].status, EquilibriumStatus::kStable) << i;
      starts_[i].x = rests[i].x;
    }
    EXPECT_LT(Gap(starts_[0].x), 0.9 * model_->scene.contact->range);
  }
  void Relax(double h = 0.1, int steps = 60) {
    const auto relaxed = host_->Rollouts(inputs_, {.h = h, .steps = steps}, nullptr);
    for (std::size_t i = 0; i < starts_.size(); ++i)
      starts_[i] = {relaxed[i].end.x, Eigen::VectorXd::Zero(relaxed[i].end.x.size())};
  }
  // Drapes over an obstacle, held in the middle at z = 0, until they are at rest there, on the
  // host. The cloth is thick, so that more of its vertices are over edges and corners.
  void LoadDrapesOver(const Contact& contact, int count) {
    Scene scene;
    scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
    scene.handles = Handles{.regions = {DiscRegion{.radius = 0.02}}};
    scene.contact = contact;
    Load(scene, 400, 2 * count);  // not every start ends at rest
    if (IsSkipped()) return;
    for (std::size_t i = 0; i < fields_.size(); ++i)
      fields_[i] = LinearMaterial(500.0, 3e-6 * (1 + 0.1 * static_cast<double>(i)), 0.3);
    Relax(0.05, 100);
    const auto rests = host_->Equilibria(inputs_, {});
    int kept = 0;
    for (std::size_t i = 0; i < rests.size() && kept < count; ++i) {
      if (rests[i].status != EquilibriumStatus::kStable) continue;
      fields_[kept] = fields_[i];
      starts_[kept++].x = rests[i].x;
    }
    ASSERT_EQ(kept, count);
    fields_.resize(count);
    starts_.resize(count);
    Point();
    EXPECT_LT(Gap(starts_[0].x), 0.9 * model_->scene.contact->range);
  }
  void ExpectSameStepDerivatives(const RolloutOptions& options);
  void ExpectSameEquilibria();
  void ExpectSameEquilibriumDerivatives();
  double Gap(const Eigen::VectorXd& x) const { return SmallestGap(*model_->scene.contact, x); }

  std::mt19937_64 random_{5};
  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<Backend> device_, host_;
  std::vector<MaterialField> fields_;
  std::vector<State> starts_;
  std::vector<RolloutInput> inputs_;
  std::vector<const MaterialField*> weights_;
};
INSTANTIATE_TEST_SUITE_P(Laws, CudaContact, testing::Values("smooth", "reference"));

Scene Falling(const std::vector<Obstacle>& obstacles) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.contact = Contact{.obstacles = obstacles};
  return scene;
}

Obstacle MeshObstacle(test::ClosedMesh mesh, const Eigen::Vector3d& move) {
  mesh.x.colwise() += move;
  return std::make_shared<const SurfaceObstacle>(mesh.x, mesh.triangles, Eigen::Matrix3Xd(), 0.03,
                                                 SurfaceBlend::kPlaces);
}
// One that is convex, one with a concave edge. The cloth is thick, so that more of its vertices are
// over edges and corners.
std::vector<Contact> MeshesUnderDrapes() {
  return {
      {.thickness = 4e-3,
       .obstacles = {MeshObstacle(test::MakeBall(0.06, 2), {0.0, 0.0, -0.06 - 2.6e-3})}},
      {.thickness = 4e-3,
       .stiffness = 1e3,
       .obstacles = {MeshObstacle(test::MakeStair(0.03, 0.1), {-0.01, -0.05, -0.06 - 2.6e-3})}}};
}

// Each kind of obstacle, met at a speed that ends moves, with vertices that start within it.
TEST_P(CudaContact, RolloutsAreEquivalentToReference) {
  const std::vector<Obstacle> kinds = {
      PlaneObstacle{.normal = Eigen::Vector3d(1, 2, 30).normalized(), .offset = -0.03},
      SphereObstacle{.centre = {0.01, 0.02, -0.105}, .radius = 0.1},
      CapsuleObstacle{.from = {-0.1, 0.01, -0.05}, .to = {0.1, 0.02, -0.06}, .radius = 0.055},
      PlateObstacle{.top = {0.01, 0.0, -0.003}, .radius = 0.08, .rim_radius = 4e-3},
      MeshObstacle(test::MakeBall(0.1, 3), {0.01, 0.02, -0.105}),
      MeshObstacle(test::MakeStair(0.05, 0.2), {-0.02, -0.1, -0.105})};
  for (const Obstacle& obstacle : kinds) {
    Load(Falling({obstacle, PlaneObstacle{.offset = -0.2}}), 200, 3);
    if (IsSkipped()) return;
    for (int i : {0, 7, 60}) starts_[1].x[3 * i + 2] -= 0.006;
    const RolloutOptions options{.h = 0.02, .steps = 12};
    const auto found = device_->Rollouts(inputs_, options, nullptr);
    const auto expected = host_->Rollouts(inputs_, options, nullptr);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      EXPECT_EQ(found[i].status, expected[i].status);
      EXPECT_LT((found[i].end.x - expected[i].end.x).cwiseAbs().maxCoeff(), 1e-9)
          << obstacle.index() << " " << i;
      EXPECT_LT(RelativeError(found[i].end.v, expected[i].end.v), 1e-6) << obstacle.index();
      EXPECT_GT(Gap(found[i].end.x), 0.0);
      EXPECT_LT(Gap(found[i].end.x), model_->scene.contact->range);
    }
    std::vector<Recording> of_device, of_host;
    const auto recorded = device_->Rollouts(inputs_, options, &of_device);
    const auto recorded_there = host_->Rollouts(inputs_, options, &of_host);
    EXPECT_EQ(recorded[0].status, recorded_there[0].status) << obstacle.index();
  }
}

TEST_P(CudaContact, AShortenedMoveHasNoDerivative) {
  Load(Falling({PlaneObstacle{.offset = -0.01}}), 100, 2);
  if (IsSkipped()) return;
  const RolloutOptions options{.h = 0.1, .steps = 5};
  for (const RolloutResult& result : device_->Rollouts(inputs_, options, nullptr))
    EXPECT_EQ(result.status, RolloutStatus::kOk);
  std::vector<Recording> recordings;
  for (const RolloutResult& result : device_->Rollouts(inputs_, options, &recordings))
    EXPECT_EQ(result.status, RolloutStatus::kBlocked);
  for (const TangentResult& result : device_->Tangents(inputs_, weights_, options))
    EXPECT_EQ(result.rollout.status, RolloutStatus::kBlocked);
}

TEST_P(CudaContact, ObstaclesThatNothingTouchesChangeNothing) {
  Load(CusickScene(), 200, 3);
  if (IsSkipped()) return;
  const RolloutOptions options{.h = 0.05, .steps = 8};
  const auto without = device_->Tangents(inputs_, weights_, options);
  Scene scene = CusickScene();
  scene.contact = Contact{
      .obstacles = {PlaneObstacle{.offset = -0.5}, SphereObstacle{.centre = {0.0, 0.0, 0.6}}}};
  const auto far =
      MakeCudaBackend(std::make_shared<ClothModel>(model_->mesh, scene, MakeLaw(GetParam())), 2);
  const auto with = far->Tangents(inputs_, weights_, options);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(with[i].rollout.end.x, without[i].rollout.end.x);
    EXPECT_EQ(with[i].dx, without[i].dx);
  }
}

// From drapes that lie against the support, whose tables change a little.
TEST_P(CudaContact, DerivativesOfStepsAreEquivalentToReference) {
  LoadSupportedDrapes(200, 3);
  if (IsSkipped()) return;
  for (MaterialField& field : fields_) field = test::Scatter(Soft(1.1), model_->mesh, 0.1, random_);
  ExpectSameStepDerivatives({.h = 2e-3, .steps = 8});
}

TEST_P(CudaContact, DerivativesOfStepsOnMeshesAreEquivalentToReference) {
  for (const Contact& contact : MeshesUnderDrapes()) {
    LoadDrapesOver(contact, 3);
    if (IsSkipped()) return;
    for (MaterialField& field : fields_) field = test::Scatter(field, model_->mesh, 0.01, random_);
    ExpectSameStepDerivatives({.h = 2e-3, .steps = 8});
  }
}

void CudaContact::ExpectSameStepDerivatives(const RolloutOptions& options) {
  const auto found = device_->Tangents(inputs_, weights_, options);
  const auto expected = host_->Tangents(inputs_, weights_, options);
  std::vector<Recording> of_device, of_host;
  (void)device_->Rollouts(inputs_, options, &of_device);
  (void)host_->Rollouts(inputs_, options, &of_host);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_EQ(expected[i].rollout.status, RolloutStatus::kOk) << i;
    ASSERT_EQ(found[i].rollout.status, RolloutStatus::kOk) << i;
    ASSERT_LT(Gap(expected[i].rollout.end.x), 0.95 * model_->scene.contact->range);
    EXPECT_LT((found[i].rollout.end.x - expected[i].rollout.end.x).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT(RelativeError(found[i].dx, expected[i].dx), 1e-7) << i;
    EXPECT_LT(RelativeError(found[i].dv, expected[i].dv), 1e-7) << i;
  }
  for (const int columns : {1, 3}) {
    std::vector<RowMatrix> dL_dx;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      dL_dx.push_back(test::RandomMatrix(model_->num_dofs(), columns, random_));
    const auto back = device_->Adjoints(inputs_, of_device, dL_dx, options);
    const auto back_there = host_->Adjoints(inputs_, of_host, dL_dx, options);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      EXPECT_LT(RelativeError(back[i].x0, back_there[i].x0), 1e-7) << columns;
      EXPECT_LT(RelativeError(back[i].v0, back_there[i].v0), 1e-7) << columns;
      EXPECT_LT(RelativeError(back[i].material.bend, back_there[i].material.bend), 1e-7);
      EXPECT_LT(RelativeError(back[i].material.stretch, back_there[i].material.stretch), 1e-7);
    }
  }
}

TEST_P(CudaContact, EquilibriaAreEquivalentToReference) {
  Load(CusickScene({ContactModel::kSupport}), 300, 4);
  if (IsSkipped()) return;
  Relax();
  ExpectSameEquilibria();
}

// From where another bending stiffness is at rest.
TEST_P(CudaContact, EquilibriaOnMeshesAreEquivalentToReference) {
  for (const Contact& contact : MeshesUnderDrapes()) {
    LoadDrapesOver(contact, 3);
    if (IsSkipped()) return;
    for (MaterialField& field : fields_)
      for (double& b : std::span(field.bend[0].entries(), kBendEntries)) b *= 1.005;
    ExpectSameEquilibria();
  }
}

void CudaContact::ExpectSameEquilibria() {
  const auto found = device_->Equilibria(inputs_, {});
  const auto expected = host_->Equilibria(inputs_, {});
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_EQ(expected[i].status, EquilibriumStatus::kStable) << i;
    EXPECT_EQ(found[i].status, expected[i].status) << i;
    EXPECT_NEAR(found[i].start_energy, expected[i].start_energy,
                1e-12 * std::abs(expected[i].start_energy));
    EXPECT_LT((found[i].x - expected[i].x).cwiseAbs().maxCoeff(), 1e-8) << i;
    EXPECT_GT(Gap(found[i].x), 0.0);
  }
  EXPECT_LT(Gap(found[0].x), 0.9 * model_->scene.contact->range);
}

TEST_P(CudaContact, DerivativesOfEquilibriaAreEquivalentToReference) {
  LoadSupportedDrapes(300, 3);
  if (IsSkipped()) return;
  ExpectSameEquilibriumDerivatives();
}

TEST_P(CudaContact, DerivativesOfEquilibriaOnMeshesAreEquivalentToReference) {
  for (const Contact& contact : MeshesUnderDrapes()) {
    LoadDrapesOver(contact, 3);
    if (IsSkipped()) return;
    ExpectSameEquilibriumDerivatives();
  }
}

void CudaContact::ExpectSameEquilibriumDerivatives() {
  const auto tangents = device_->EquilibriumTangents(inputs_, weights_);
  const auto tangents_there = host_->EquilibriumTangents(inputs_, weights_);
  const auto moves = device_->EquilibriumJvp(inputs_, weights_);
  const auto moves_there = host_->EquilibriumJvp(inputs_, weights_);
  std::vector<RowMatrix> dL_dx;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_GT(tangents_there[i].size(), 0) << i;
    EXPECT_LT(RelativeError(tangents[i], tangents_there[i]), 1e-7) << i;
    EXPECT_LT(RelativeError(moves[i], moves_there[i]), 1e-7) << i;
    dL_dx.push_back(test::RandomMatrix(model_->num_dofs(), 3, random_));
  }
  const auto back = device_->EquilibriumAdjoints(inputs_, dL_dx);
  const auto back_there = host_->EquilibriumAdjoints(inputs_, dL_dx);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_TRUE(back[i] && back_there[i]) << i;
    EXPECT_LT(RelativeError(back[i]->stretch, back_there[i]->stretch), 1e-7) << i;
    EXPECT_LT(RelativeError(back[i]->bend, back_there[i]->bend), 1e-7) << i;
  }
}

}  // namespace
}  // namespace drape
