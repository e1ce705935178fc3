// SPDX-License-Identifier: Apache-2.0
// Frames of a rollout: states, tangents and adjoints at several steps of one pass.
#include <gmock/gmock.h>

#include <vector>

#include "physics/simulation/backend.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

const std::vector<int> kFrames = {0, 3, 7, 10};

// A cloth that moves, with damping and air, so that nothing is zero by chance.
struct MovingCloth {
  explicit MovingCloth(const std::string& law)
      : random(29), model(test::SmallDisc(law)), solver(model), material(test::TestMaterial()) {
    material.dynamics = {0.4, 2e-3, 0.6, {0.3, -0.8, 0.5}};
    start = test::NoisyStart(*model, 1e-3, random);
    start.v = 0.05 * test::RandomMatrix(model->num_dofs(), 1, random);
    options.steps = kFrames.back();
    options.frames = kFrames;
  }
  RolloutOptions To(int frame) const { return {.h = options.h, .steps = frame}; }

  std::mt19937_64 random;
  std::shared_ptr<const ClothModel> model;
  StepSolver solver;
  MaterialField material;
  State start;
  RolloutOptions options;
};

class FramesTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Laws, FramesTest, testing::Values("reference", "smooth"),
                         [](const auto& info) { return info.param; });

TEST_P(FramesTest, StatesAreTheEndsOfShorterRolloutsBitForBit) {
  MovingCloth s(GetParam());
  Recording recording;
  const RolloutResult all = Rollout(s.solver, s.material, s.start, s.options, &recording);
  ASSERT_EQ(all.frames.size(), kFrames.size());
  for (std::size_t k = 0; k < kFrames.size(); ++k) {
    const State end = Rollout(s.solver, s.material, s.start, s.To(kFrames[k])).end;
    EXPECT_EQ(all.frames[k].x, end.x) << kFrames[k];
    EXPECT_EQ(all.frames[k].v, end.v) << kFrames[k];
  }
  EXPECT_EQ(all.end.x, recording.x.back());
}

TEST_P(FramesTest, TangentsAreThoseOfShorterRolloutsBitForBit) {
  MovingCloth s(GetParam());
  const TangentResult all =
      RolloutTangent(s.solver, s.material, s.material, s.start, s.options, {.dynamics = true});
  int seen = 0;
  const TangentResult reduced = RolloutTangent(
      s.solver, s.material, s.material, s.start, s.options,
      {.dynamics = true,
       .on_frame = [&](int k, const State& state, const TangentView& dx, const TangentView& dv) {
         EXPECT_EQ(k, seen++);
         EXPECT_EQ(state.x, all.rollout.frames[k].x);
         EXPECT_EQ(dx, all.frames[k].dx);
         EXPECT_EQ(dv, all.frames[k].dv);
       }});
  EXPECT_EQ(seen, static_cast<int>(kFrames.size()));
  EXPECT_TRUE(reduced.frames.empty());
  EXPECT_EQ(reduced.dx, all.dx);
  ASSERT_EQ(all.frames.size(), kFrames.size());
  for (std::size_t k = 0; k < kFrames.size(); ++k) {
    const TangentResult one = RolloutTangent(s.solver, s.material, s.material, s.start,
                                             s.To(kFrames[k]), {.dynamics = true});
    EXPECT_EQ(all.frames[k].dx, one.dx) << kFrames[k];
    EXPECT_EQ(all.frames[k].dv, one.dv) << kFrames[k];
  }
  EXPECT_EQ(all.dx, all.frames.back().dx);
}

// Seeds by x and v at all frames: one pass gives the sum of the passes from each frame, and what
// the tangents at the frames give.
TEST_P(FramesTest, AdjointAddsTheSeedsOfAllFrames) {
  MovingCloth s(GetParam());
  const int n = s.model->num_dofs();
  for (const int m : {1, 3}) {
    for (const std::size_t memory : {std::size_t{0}, std::size_t{1} << 40}) {
      s.options.factor_memory = memory;
      AdjointOptions more{.dynamics = true};
      for (std::size_t k = 0; k < kFrames.size(); ++k)
        more.frames.push_back(
            {test::RandomMatrix(n, m, s.random), test::RandomMatrix(n, m, s.random)});
      more.frames[1].v = {};  // not seen
      const RowMatrix at_end = test::RandomMatrix(n, m, s.random);
      const TangentResult tangent =
          RolloutTangent(s.solver, s.material, s.material, s.start, s.options, {.dynamics = true});
      RowMatrix expected = tangent.dx.transpose() * at_end;
      for (std::size_t k = 0; k < kFrames.size(); ++k) {
        expected += tangent.frames[k].dx.transpose() * more.frames[k].x;
        if (k != 1) expected += tangent.frames[k].dv.transpose() * more.frames[k].v;
      }
      Recording recording;
      (void)Rollout(s.solver, s.material, s.start, s.options, &recording);
      const AdjointResult found =
          RolloutAdjoint(s.solver, s.material, s.options, recording, at_end, more);
      ASSERT_EQ(found.status, RolloutStatus::kOk);
      RowMatrix by_adjoint(expected.rows(), m);
      by_adjoint << found.material.Contract(s.material), found.dynamics;
      // Row by row, since the numbers have different units.
      for (int row = 0; row < expected.rows(); ++row)
        EXPECT_LT((by_adjoint - expected).row(row).norm(),
                  1e-10 * expected.row(row).norm() + 1e-14 * expected.norm())
            << row;
    }
  }
}

// A tangent by the start has the seeds of frame 0 too.
TEST_P(FramesTest, JvpAgreesWithAdjointAtTheFrames) {
  MovingCloth s(GetParam());
  const int n = s.model->num_dofs();
  const State moved = {test::RandomMatrix(n, 1, s.random), test::RandomMatrix(n, 1, s.random)};
  const std::vector<double> numbers = {0.03, 0.2, 4e-4, 0.1, -0.4, 0.2, 0.3};
  const MaterialField change = test::TestMaterial(0.7);
  const JvpResult jvp =
      RolloutJvp(s.solver, s.material, change, s.start, moved, s.options, numbers);
  ASSERT_EQ(jvp.frames.size(), kFrames.size());
  EXPECT_EQ(jvp.frames[0].x, moved.x);
  EXPECT_EQ(jvp.frames.back().v, jvp.change.v);
  AdjointOptions more{.dynamics = true};
  double expected = 0.0;
  for (const State& at : jvp.frames) {
    more.frames.push_back({test::RandomMatrix(n, 1, s.random), test::RandomMatrix(n, 1, s.random)});
    expected += more.frames.back().x.col(0).dot(at.x) + more.frames.back().v.col(0).dot(at.v);
  }
  Recording recording;
  (void)Rollout(s.solver, s.material, s.start, s.options, &recording);
  const AdjointResult found =
      RolloutAdjoint(s.solver, s.material, s.options, recording, RowMatrix::Zero(n, 1), more);
  const double by_numbers =
      found.dynamics.col(0).dot(Eigen::Map<const Eigen::VectorXd>(numbers.data(), 7));
  const double parts[] = {found.material.Contract(change).sum(), found.x0.col(0).dot(moved.x),
                          found.v0.col(0).dot(moved.v), by_numbers};
  double sum = 0.0, size = 0.0;
  for (const double part : parts) {
    EXPECT_NE(part, 0.0);
    sum += part;
    size += std::abs(part);
  }
  EXPECT_NEAR(sum, expected, 1e-10 * size);
}

TEST_P(FramesTest, BackendTakesThemForEachRollout) {
  MovingCloth s(GetParam());
  const int n = s.model->num_dofs();
  const auto backend = MakeCpuBackend(s.model, 2);
  const TangentOptions tangent{.dynamics = true};
  AdjointOptions adjoint;
  for (std::size_t k = 0; k < kFrames.size(); ++k)
    adjoint.frames.push_back({test::RandomMatrix(n, 1, s.random), {}});
  const std::vector<RolloutInput> batch = {{&s.material, &s.start, &tangent, &adjoint},
                                           {&s.material, &s.start}};
  const std::vector<const MaterialField*> weights(2, &s.material);
  const std::vector<RowMatrix> seeds(2, test::RandomMatrix(n, 1, s.random));
  std::vector<Recording> recordings;
  const auto rollouts = backend->Rollouts(batch, s.options, &recordings);
  const auto tangents = backend->Tangents(batch, weights, s.options);
  const auto adjoints = backend->Adjoints(batch, recordings, seeds, s.options);
  EXPECT_EQ(rollouts[1].frames.size(), kFrames.size());
  EXPECT_EQ(tangents[0].dx.cols(), kMaterialEntries + kDynamicsEntries);
  EXPECT_EQ(tangents[1].dx.cols(), kMaterialEntries);
  EXPECT_EQ(tangents[0].frames[2].dx.leftCols(kMaterialEntries), tangents[1].frames[2].dx);
  const AdjointResult expected =
      RolloutAdjoint(s.solver, s.material, s.options, recordings[0], seeds[0], adjoint);
  EXPECT_EQ(adjoints[0].x0, expected.x0);
  EXPECT_NE(adjoints[0].x0, adjoints[1].x0);
}

TEST(FramesDeathTest, AscendAndLieInTheRollout) {
  for (const std::vector<int>& wrong :
       {std::vector{3, 2}, std::vector{4, 4}, std::vector{6}, std::vector{-1}}) {
    const RolloutOptions options{.steps = 5, .frames = wrong};
    EXPECT_DEATH(options.Check(), "RolloutOptions::frames");
  }
}

}  // namespace
}  // namespace drape
