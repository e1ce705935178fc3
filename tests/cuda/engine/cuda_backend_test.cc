// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/cuda_backend.h"

#include <tuple>

#include "physics/cloth/assembly/dynamics.h"
#include "physics/util/errors.h"
#include "tests/cuda/engine/gpu_fixture.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/summed_tangents.h"

namespace drape {
namespace {

using test::RelativeError;

// Batches of a law and a size, with shared tables and tables of each element mixed.
class CudaBackendTest : public testing::TestWithParam<std::tuple<const char*, int, int>> {
 protected:
  void SetUp() override {
    DRAPE_NEEDS_GPU();
    device_ = MakeCudaBackend(model_, 1);
    const int count = std::get<2>(GetParam());
    for (int i = 0; i < count; ++i) {
      fields_.push_back(test::TestMaterial(1.0 + 0.3 * i));
      if (i % 2 == 1) fields_.back() = test::Scatter(fields_.back(), model_->mesh, 0.3, random_);
      starts_.push_back(test::NoisyStart(*model_, 1e-3, random_));
      starts_.back().v = 1e-2 * test::RandomMatrix(model_->num_dofs(), 1, random_);
    }
    for (int i = 0; i < count; ++i) {
      inputs_.push_back({&fields_[i], &starts_[i]});
      weights_.push_back(&fields_[i]);
    }
  }

  static void ExpectEqual(const std::vector<AdjointResult>& found,
                          const std::vector<AdjointResult>& expected) {
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(found[i].status, RolloutStatus::kOk);
      EXPECT_LT(RelativeError(found[i].material.stretch, expected[i].material.stretch), 1e-8) << i;
      EXPECT_LT(RelativeError(found[i].material.bend, expected[i].material.bend), 1e-8) << i;
      EXPECT_LT(RelativeError(found[i].x0, expected[i].x0), 1e-8) << i;
      EXPECT_LT(RelativeError(found[i].v0, expected[i].v0), 1e-8) << i;
      ASSERT_EQ(found[i].dynamics.rows(), expected[i].dynamics.rows()) << i;
      for (int k = 0; k < found[i].dynamics.rows(); ++k)  // the units differ
        EXPECT_LT(RelativeError(found[i].dynamics.row(k), expected[i].dynamics.row(k)), 1e-8)
            << i << ' ' << k;
    }
  }

  std::mt19937_64 random_{11};
  std::shared_ptr<const ClothModel> model_ =
      test::SmallDisc(std::get<0>(GetParam()), std::get<1>(GetParam()));
  std::unique_ptr<Backend> device_, host_ = MakeCpuBackend(model_, 2);
  std::vector<MaterialField> fields_;
  std::vector<State> starts_;
  std::vector<RolloutInput> inputs_;
  std::vector<const MaterialField*> weights_;
  RolloutOptions options_{.h = 0.05, .steps = 12};
};

TEST_P(CudaBackendTest, RolloutsAreEquivalentToReference) {
  const auto found = device_->Rollouts(inputs_, options_, nullptr);
  const auto expected = host_->Rollouts(inputs_, options_, nullptr);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(found[i].status, expected[i].status);
    EXPECT_EQ(found[i].steps, expected[i].steps);
    EXPECT_LT((found[i].end.x - expected[i].end.x).cwiseAbs().maxCoeff(), 1e-10) << i;
    EXPECT_LT(RelativeError(found[i].end.v, expected[i].end.v), 1e-8) << i;
  }
}

TEST_P(CudaBackendTest, RunsAreBitwiseEqual) {
  const auto a = device_->Rollouts(inputs_, options_, nullptr);
  const auto b = device_->Rollouts(inputs_, options_, nullptr);
  for (std::size_t i = 0; i < inputs_.size(); ++i) EXPECT_EQ(a[i].end.x, b[i].end.x);
}

TEST_P(CudaBackendTest, TangentsAreEquivalentToReference) {
  const auto found = device_->Tangents(inputs_, weights_, options_);
  const auto expected = host_->Tangents(inputs_, weights_, options_);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_LT((found[i].rollout.end.x - expected[i].rollout.end.x).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT(RelativeError(found[i].dx, expected[i].dx), 1e-8) << i;
    EXPECT_LT(RelativeError(found[i].dv, expected[i].dv), 1e-8) << i;
  }
}

TEST_P(CudaBackendTest, AdjointsAreEquivalentToReference) {
  for (const int columns : {1, 3, 8}) {
    std::vector<RowMatrix> dL_dx;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      dL_dx.push_back(test::RandomMatrix(model_->num_dofs(), columns, random_));
    std::vector<Recording> of_device, of_host;
    (void)device_->Rollouts(inputs_, options_, &of_device);
    (void)host_->Rollouts(inputs_, options_, &of_host);
    const auto expected = host_->Adjoints(inputs_, of_host, dL_dx, options_);
    // From its own recordings, factors included, and with one of the host among them, without.
    ExpectEqual(device_->Adjoints(inputs_, of_device, dL_dx, options_), expected);
    of_device.back() = of_host.back();
    ExpectEqual(device_->Adjoints(inputs_, of_device, dL_dx, options_), expected);
  }
}

// Frames of a batch whose materials are damped, each in another way or not at all; every second one
// is in wind.
class CudaFramesTest : public CudaBackendTest {
 protected:
  void SetUp() override {
    CudaBackendTest::SetUp();
    if (IsSkipped()) return;
    options_.frames = {0, 1, 5, 12};
    for (std::size_t i = 0; i < fields_.size(); ++i)
      if (i % 3 != 1) fields_[i].dynamics = {.mass_damping = 0.5, .stiffness_damping = 1e-3 * i};
    for (std::size_t i = 0; i < fields_.size(); i += 2) {
      fields_[i].dynamics.air_drag = 0.6;
      fields_[i].dynamics.wind = {1.0, -0.5, 2.0};
    }
  }
  // Seeds of rollout i, which lacks some.
  AdjointOptions Seeds(std::size_t i, int columns) {
    AdjointOptions more;
    more.dynamics = i % 2 == 0;
    if (i == 2) return more;
    const int n = model_->num_dofs();
    for (std::size_t k = 0; k < options_.frames.size(); ++k)
      more.frames.push_back(
          {test::RandomMatrix(n, columns, random_), test::RandomMatrix(n, columns, random_)});
    more.frames[1].x = {};
    if (i % 2 == 0) more.frames[3].v = {};
    return more;
  }
};

TEST_P(CudaFramesTest, StatesAreEquivalentToReferenceAndChangeNoBit) {
  for (const bool record : {false, true}) {
    std::vector<Recording> recordings;
    const auto found = device_->Rollouts(inputs_, options_, record ? &recordings : nullptr);
    const auto expected = host_->Rollouts(inputs_, options_, nullptr);
    RolloutOptions without = options_;
    without.frames.clear();
    const auto end = device_->Rollouts(inputs_, without, nullptr);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      EXPECT_EQ(found[i].end.x, end[i].end.x) << i;
      ASSERT_EQ(found[i].frames.size(), options_.frames.size()) << i;
      EXPECT_EQ(found[i].frames.back().x, found[i].end.x) << i;
      EXPECT_EQ(found[i].frames.back().v, found[i].end.v) << i;
      for (std::size_t k = 0; k < options_.frames.size(); ++k) {
        const State &at = found[i].frames[k], &there = expected[i].frames[k];
        EXPECT_LT((at.x - there.x).cwiseAbs().maxCoeff(), 1e-10) << i << ' ' << k;
        EXPECT_LT(RelativeError(at.v, there.v), 1e-8) << i << ' ' << k;
      }
    }
  }
}

TEST_P(CudaFramesTest, TangentsAreEquivalentToReference) {
  const auto kept = device_->Tangents(inputs_, weights_, options_);
  const auto expected = host_->Tangents(inputs_, weights_, options_);
  // The last rollout reads its tangents at once.
  std::vector<FrameTangent> read;
  const TangentOptions reader = {
      .on_frame = [&](int k, const State& state, const TangentView& dx, const TangentView& dv) {
        EXPECT_EQ(k, static_cast<int>(read.size()));
        EXPECT_EQ(state.x, kept.back().rollout.frames[k].x);
        read.push_back({dx, dv});
      }};
  inputs_.back().tangent = &reader;
  const auto found = device_->Tangents(inputs_, weights_, options_);
  EXPECT_TRUE(found.back().frames.empty());
  ASSERT_EQ(read.size(), options_.frames.size());
  for (std::size_t k = 0; k < read.size(); ++k) EXPECT_EQ(read[k].dx, kept.back().frames[k].dx);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_LT(RelativeError(kept[i].dx, expected[i].dx), 1e-8) << i;
    ASSERT_EQ(kept[i].frames.size(), options_.frames.size()) << i;
    for (std::size_t k = 0; k < read.size(); ++k) {
      EXPECT_LT(RelativeError(kept[i].frames[k].dx, expected[i].frames[k].dx), 1e-8) << i << k;
      EXPECT_LT(RelativeError(kept[i].frames[k].dv, expected[i].frames[k].dv), 1e-8) << i << k;
    }
  }
}

TEST_P(CudaFramesTest, AdjointsAreEquivalentToReference) {
  for (const int columns : {1, 3}) {
    std::vector<AdjointOptions> seeds;
    std::vector<RowMatrix> dL_dx;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      seeds.push_back(Seeds(i, columns));
      dL_dx.push_back(test::RandomMatrix(model_->num_dofs(), columns, random_));
    }
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      inputs_[i].adjoint = i == 3 ? nullptr : &seeds[i];
    std::vector<Recording> of_device, of_host;
    (void)device_->Rollouts(inputs_, options_, &of_device);
    (void)host_->Rollouts(inputs_, options_, &of_host);
    const auto expected = host_->Adjoints(inputs_, of_host, dL_dx, options_);
    ExpectEqual(device_->Adjoints(inputs_, of_device, dL_dx, options_), expected);
    ExpectEqual(device_->Adjoints(inputs_, of_host, dL_dx, options_), expected);
  }
}

// Columns by the numbers of DynamicsEntry and by the start: a rollout wants none, some or all. A
// column is the same whatever others the batch wants.
TEST_P(CudaFramesTest, FurtherColumnsAreEquivalentToReference) {
  const auto alone = device_->Tangents(inputs_, weights_, options_);
  const int n = model_->num_dofs();
  const std::vector<TangentOptions> more = {
      {.dynamics = true,
       .start_dx = test::RandomMatrix(n, 2, random_),
       .start_dv = test::RandomMatrix(n, 2, random_)},
      {.start_dv = Eigen::Matrix3d::Identity().replicate(n / 3, 1)},
      {.dynamics = true},
      {}};
  for (std::size_t i = 0; i < inputs_.size(); ++i) inputs_[i].tangent = &more[i % more.size()];
  const auto found = device_->Tangents(inputs_, weights_, options_);
  const auto expected = host_->Tangents(inputs_, weights_, options_);
  const auto expect_equal = [](const RowMatrix& a, const RowMatrix& b) {
    ASSERT_EQ(a.cols(), b.cols());
    for (int k = 0; k < a.cols(); ++k) EXPECT_LT(RelativeError(a.col(k), b.col(k)), 1e-7) << k;
  };
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(found[i].dx.leftCols<kMaterialEntries>(), alone[i].dx) << i;
    expect_equal(found[i].dx, expected[i].dx);
    expect_equal(found[i].dv, expected[i].dv);
    for (std::size_t k = 0; k < options_.frames.size(); ++k)
      expect_equal(found[i].frames[k].dv, expected[i].frames[k].dv);
  }
}

// What kernels have not is refused before anything runs.
TEST_P(CudaFramesTest, RefusesAirWithoutStretch) {
  Scene scene = model_->scene;
  scene.stretch = false;
  const auto model = std::make_shared<ClothModel>(model_->mesh, scene, model_->law);
  const auto device = MakeCudaBackend(model, 1);
  const auto expect_refused = [](const auto& act) {
    try {
      act();
      ADD_FAILURE() << "expected to refuse air";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("in a scene without stretch"));
    }
  };
  expect_refused([&] { (void)device->Rollouts(inputs_, options_, nullptr); });
  for (MaterialField& field : fields_) field.dynamics.air_drag = 0.0;
  const TangentOptions columns{.dynamics = true};
  inputs_[0].tangent = &columns;
  expect_refused([&] { (void)device->Tangents(inputs_, weights_, options_); });
}

INSTANTIATE_TEST_SUITE_P(Batches, CudaFramesTest,
                         testing::Values(std::tuple("smooth", 150, 1), std::tuple("smooth", 300, 5),
                                         std::tuple("smooth", 100, 70),
                                         std::tuple("reference", 150, 4)));

// From relaxed shapes: the same decisions, the same drape.
class CudaStaticsTest : public CudaBackendTest {
 protected:
  void SetUp() override {
    CudaBackendTest::SetUp();
    if (IsSkipped()) return;
    for (State& start : starts_) start.v.setZero();
    const auto relaxed = host_->Rollouts(inputs_, {.h = 0.1, .steps = 40}, nullptr);
    for (std::size_t i = 0; i < inputs_.size(); ++i) starts_[i] = relaxed[i].end;
  }
};

TEST_P(CudaStaticsTest, EquilibriaAndTheirDerivativesAreEquivalentToReference) {
  const auto found = device_->Equilibria(inputs_, {});
  const auto expected = host_->Equilibria(inputs_, {});
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    EXPECT_EQ(found[i].status, expected[i].status) << i;
    EXPECT_EQ(found[i].iterations, expected[i].iterations) << i;
    EXPECT_EQ(found[i].factorisations, expected[i].factorisations) << i;
    EXPECT_NEAR(found[i].start_energy, expected[i].start_energy,
                1e-12 * std::abs(expected[i].start_energy));
    EXPECT_LT((found[i].x - expected[i].x).cwiseAbs().maxCoeff(), 1e-8) << i;
    starts_[i].x = expected[i].x;
  }
  const TangentOptions dynamics{.dynamics = true};
  inputs_[0].tangent = &dynamics;
  const auto tangents = device_->EquilibriumTangents(inputs_, weights_);
  const auto of_host = host_->EquilibriumTangents(inputs_, weights_);
  inputs_[0].tangent = nullptr;
  std::vector<RowMatrix> dL_dx;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (of_host[i].size() == 0) {
      EXPECT_EQ(tangents[i].size(), 0) << i;
    } else {
      EXPECT_LT(RelativeError(tangents[i], of_host[i]), 1e-7) << i;
      const auto by_density = [](const RowMatrix& of) {
        return of.col(kMaterialEntries + kByDensity);
      };
      if (i == 0) {
        EXPECT_LT(RelativeError(by_density(tangents[i]), by_density(of_host[i])), 1e-7);
      }
    }
    dL_dx.push_back(test::RandomMatrix(model_->num_dofs(), 3, random_));
  }
  std::vector<MaterialField> changes;
  std::vector<const MaterialField*> directions;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    changes.push_back(test::Scatter(fields_[i], model_->mesh, 0.4, random_));
  for (const MaterialField& change : changes) directions.push_back(&change);
  const auto moves = device_->EquilibriumJvp(inputs_, directions);
  const auto summed = test::SumEquilibriumTangents(*device_, inputs_, directions);
  const auto moves_of_host = host_->EquilibriumJvp(inputs_, directions);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_EQ(moves[i].size(), of_host[i].size() == 0 ? 0 : model_->num_dofs()) << i;
    if (moves[i].size() == 0) continue;
    EXPECT_LT(RelativeError(moves[i], summed[i]), 1e-8) << i;  // columns are solved to 1e-9
    EXPECT_LT(RelativeError(moves[i], moves_of_host[i]), 1e-7) << i;
  }
  const auto adjoints = device_->EquilibriumAdjoints(inputs_, dL_dx);
  const auto adjoints_of_host = host_->EquilibriumAdjoints(inputs_, dL_dx);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    ASSERT_EQ(adjoints[i].has_value(), adjoints_of_host[i].has_value()) << i;
    if (!adjoints[i]) continue;
    EXPECT_LT(RelativeError(adjoints[i]->stretch, adjoints_of_host[i]->stretch), 1e-7) << i;
    EXPECT_LT(RelativeError(adjoints[i]->bend, adjoints_of_host[i]->bend), 1e-7) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Batches, CudaStaticsTest,
                         testing::Values(std::tuple("smooth", 150, 1), std::tuple("smooth", 300, 5),
                                         std::tuple("smooth", 100, 20),
                                         std::tuple("reference", 150, 3)));

TEST_P(CudaBackendTest, FailureStaysAlone) {
  const auto good = device_->Rollouts(inputs_, options_, nullptr);
  starts_[0].x[0] = std::numeric_limits<double>::quiet_NaN();
  const auto mixed = device_->Rollouts(inputs_, options_, nullptr);
  EXPECT_NE(mixed[0].status, RolloutStatus::kOk);
  for (std::size_t i = 1; i < inputs_.size(); ++i) EXPECT_EQ(mixed[i].end.x, good[i].end.x);
}

INSTANTIATE_TEST_SUITE_P(Batches, CudaBackendTest,
                         testing::Values(std::tuple("smooth", 150, 1), std::tuple("smooth", 300, 5),
                                         std::tuple("smooth", 1200, 3),
                                         std::tuple("smooth", 100, 70),
                                         std::tuple("reference", 150, 3),
                                         std::tuple("reference", 300, 1)));

}  // namespace
}  // namespace drape
