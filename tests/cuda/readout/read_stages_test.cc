// SPDX-License-Identifier: Apache-2.0
// The stages that kernels run to read outlines and soft silhouettes, run here on the host and held
// to losses/: needs no device.
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "cuda/readout/outline_stages.h"
#include "cuda/readout/silhouette_run.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette_edges.h"
#include "losses/silhouette/soft_silhouette.h"
#include "tests/cuda/kernels/cloth/mesh_on_host.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

// Memory of a workspace, filled with a pattern: no stage may count on zeros.
class HostArena {
 public:
  template <class T>
  T* Take(std::size_t count) {
    pieces_.emplace_back(count * sizeof(T), char{0x55});
    return reinterpret_cast<T*>(pieces_.back().data());
  }

 private:
  std::vector<std::vector<char>> pieces_;
};

// Items in a random order, as threads might come.
template <class Plan, class Slot>
struct HostRunner {
  const Plan& plan;
  Slot& slot;
  std::mt19937 random;

  template <class Stage>
  void Each(Stage stage, int items) {
    std::vector<int> order(items);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    for (const int i : order)
      if (*slot.status == kRead) stage(plan, slot, i);
  }
  void Scan(SlotStarts start, int items, int room) {
    if (*slot.status != kRead) return;
    int* counts = slot.*start.member;
    counts[items] = 0;
    std::exclusive_scan(counts, counts + items + 1, counts, 0);
    if (counts[items] > room) *slot.status = kNoRoom;
  }
};

struct Found {
  Eigen::VectorXd r, dL_dx;  // coverage or radius; ∂loss/∂x
  double loss = 0.0;
  int status = kRead, cuts = 0;
};

struct ReadCase {
  const char* name;
  CameraKind kind;
  DrapeShape shape;
  double half_width;
  double noise = 1e-3;  // [m]
};
void PrintTo(const ReadCase& c, std::ostream* stream) { *stream << c.name; }

class ReadStages : public testing::TestWithParam<ReadCase> {
 protected:
  ReadStages() {
    camera_.kind = GetParam().kind;
    camera_.height = 250;  // not a multiple of a tile, not square
    x_ = Deform(mesh_, GetParam().shape) +
         GetParam().noise * RandomVector(3 * mesh_.num_vertices(), 5);
  }

  Found Silhouette(const SilhouettePlan& plan, const Eigen::VectorXd& target, int seed) const {
    Found found;
    found.dL_dx.setZero(x_.size());
    HostArena arena;
    SilhouetteSlot slot{};
    TakeSilhouette(arena, plan, &slot);
    slot.x = x_.data();
    slot.target = target.data();
    slot.sigma = 0.3;
    slot.camera = camera_.projection();
    slot.half_width = GetParam().half_width;
    slot.loss = &found.loss;
    slot.dL_dx = found.dL_dx.data();
    slot.status = &found.status;
    HostRunner<SilhouettePlan, SilhouetteSlot> run{plan, slot, std::mt19937(seed)};
    RunCoverage(plan, run);
    RunLoss(plan, run);
    if (found.status != kRead) return found;
    found.r = Eigen::Map<const Eigen::VectorXd>(slot.coverage, plan.pixels());
    found.cuts = slot.cut_start[plan.edges()];
    return found;
  }

  Found Outlines(const Eigen::VectorXd& target, int seed, RowMatrix* jacobian) const {
    const OutlinePlan plan{view_.view(), static_cast<int>(target.size())};
    Found found;
    found.dL_dx.setZero(x_.size());
    found.r.setZero(target.size());
    std::vector<Vec2> points(plan.mesh.num_hem);
    std::vector<int> dof(6 * plan.num_angles);
    std::vector<double> value(6 * plan.num_angles);
    OutlineSlot slot{x_.data(),     target.data(),      0.3,          camera_.projection(),
                     points.data(), found.r.data(),     dof.data(),   value.data(),
                     &found.loss,   found.dL_dx.data(), &found.status};
    HostRunner<OutlinePlan, OutlineSlot> run{plan, slot, std::mt19937(seed)};
    RunOutlines(plan, run);
    RunOutlineLoss(plan, run);
    jacobian->setZero(plan.num_angles, x_.size());
    for (std::size_t e = 0; e < dof.size(); ++e) (*jacobian)(e / 6, dof[e]) += value[e];
    return found;
  }

  SilhouettePlan Plan() const {
    SilhouettePlan plan = SilhouettePlan::Of(view_.view(), camera_.width, camera_.height);
    plan.max_cuts *= 16;  // crumpled cloth would be the host's
    return plan;
  }

  const Mesh mesh_ = MakeDisc(6, 60, 0.15);
  const test::MeshOnHost view_{mesh_};
  Camera camera_;
  Eigen::VectorXd x_;
};

TEST_P(ReadStages, SilhouetteIsEquivalentToReference) {
  SoftSilhouette soft;
  ASSERT_TRUE(RenderSoft(mesh_, x_, camera_, {GetParam().half_width}, &soft));
  const Eigen::VectorXd target = 0.5 * (Eigen::VectorXd::Ones(soft.coverage.size()) +
                                        0.3 * RandomVector(soft.coverage.size(), 3));
  const Found found = Silhouette(Plan(), target, 1);
  ASSERT_EQ(found.status, kRead);
  EXPECT_LT((found.r - soft.coverage).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::VectorXd residual = (soft.coverage - target) / 0.3;
  EXPECT_NEAR(found.loss, 0.5 * residual.squaredNorm(), 1e-12 * found.loss);
  Eigen::VectorXd dL_dx = Eigen::VectorXd::Zero(x_.size());
  AdjRenderSoft(soft, x_, camera_, residual / 0.3, &dL_dx);
  EXPECT_LT((found.dL_dx - dL_dx).norm(), 1e-9 * dL_dx.norm());
  Eigen::Matrix2Xd points;
  ASSERT_TRUE(ProjectVertices(x_, camera_, &points));
  EXPECT_EQ(found.cuts, 2 * FindSilhouetteEdges(mesh_, points).crossings.size());
  if (GetParam().shape.twist > 0) {
    EXPECT_GE(found.cuts, 20);
  }
}

TEST_P(ReadStages, OutlineIsEquivalentToReference) {
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(mesh_, x_, camera_, 72, &outline));
  const Eigen::VectorXd target = outline.radius + RandomVector(72, 4);
  RowMatrix jacobian;
  const Found found = Outlines(target, 1, &jacobian);
  ASSERT_EQ(found.status, kRead);
  EXPECT_LT((found.r - outline.radius).norm(), 1e-12 * outline.radius.norm());
  const RowMatrix expected = OutlineJacobian(outline, mesh_.num_vertices());
  EXPECT_LT((jacobian - expected).norm(), 1e-12 * expected.norm());
  const Eigen::VectorXd residual = (outline.radius - target) / 0.3;
  EXPECT_NEAR(found.loss, 0.5 * residual.squaredNorm(), 1e-12 * found.loss);
  const Eigen::VectorXd dL_dx = expected.transpose() * (residual / 0.3);
  EXPECT_LT((found.dL_dx - dL_dx).norm(), 1e-12 * dL_dx.norm());
}

TEST_P(ReadStages, TheOrderOfItemsChangesNoBit) {
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(camera_.width * camera_.height, 0.4);
  const Found one = Silhouette(Plan(), target, 1), other = Silhouette(Plan(), target, 2);
  EXPECT_EQ(one.r, other.r);
  EXPECT_EQ(one.dL_dx, other.dL_dx);
  EXPECT_EQ(one.loss, other.loss);
}

TEST_P(ReadStages, ShapesThatCannotBeReadAreMarked) {
  const Eigen::VectorXd target = Eigen::VectorXd::Zero(camera_.width * camera_.height);
  SilhouettePlan small = Plan();
  small.max_pieces = 3;
  EXPECT_EQ(Silhouette(small, target, 1).status, kNoRoom);
  x_[4] = std::nan("");
  EXPECT_EQ(Silhouette(Plan(), target, 1).status, kUnreadable);
  RowMatrix jacobian;
  const int hem = 3 * mesh_.boundary_loops[0][7];
  x_[hem + 2] = std::nan("");
  EXPECT_EQ(Outlines(target.head(72), 1, &jacobian).status, kUnreadable);
  x_[hem + 2] = 0.0;
  EXPECT_EQ(Outlines(target.head(72), 1, &jacobian).status, kRead);
  x_.array() += 1.0;  // beside the axis: rays without cloth
  EXPECT_EQ(Outlines(target.head(72), 1, &jacobian).status, kUnreadable);
}

constexpr auto kOrtho = CameraKind::kOrthographic;
constexpr auto kPin = CameraKind::kPinhole;
const DrapeShape kPlain = {.folds = 6};
// The hem turns back on itself in the image: folds cover folds, and their edges cross.
const DrapeShape kOverlap = {.folds = 5, .amplitude = 0.2, .twist = 0.5};
INSTANTIATE_TEST_SUITE_P(Shapes, ReadStages,
                         testing::Values(ReadCase{"plain", kOrtho, kPlain, 1.0},
                                         ReadCase{"plain_pinhole", kPin, kPlain, 2.5},
                                         ReadCase{"overlap", kOrtho, kOverlap, 1.0},
                                         ReadCase{"overlap_wide", kOrtho, kOverlap, 2.5},
                                         ReadCase{"overlap_pinhole", kPin, kOverlap, 1.5},
                                         // Edges of the border that several others cross.
                                         ReadCase{"crumpled", kOrtho, kOverlap, 1.0, 1e-2}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace drape
