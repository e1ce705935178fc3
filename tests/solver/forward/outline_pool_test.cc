// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/outline_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/material/laws/law_kind.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

Eigen::VectorXd Waves(int folds, double phase) {
  Eigen::VectorXd radius(kPoolAngles);
  for (int i = 0; i < kPoolAngles; ++i)
    radius[i] = 0.12 + 0.01 * std::cos(folds * 2 * M_PI * i / kPoolAngles - phase) +
                0.004 * std::cos(2 * M_PI * i / kPoolAngles - 0.4);
  return radius;
}

OutlinePool SmallPool() {
  OutlinePool pool;
  pool.mesh = "disc:100";
  pool.setting = "smooth law";
  pool.seed = 7;
  for (int i = 0; i < 5; ++i) {
    pool.numbers.push_back(MakePooledSpecimen({}, pool.seed, i).numbers);
    pool.radius.push_back(Waves(5 + i, 0.3 * i));
  }
  return pool;
}

TEST(OutlinePool, IsUnpackedAsItWasPacked) {
  const OutlinePool pool = SmallPool(), read = UnpackPool(PackPool(pool), "pool");
  EXPECT_EQ(read.mesh, pool.mesh);
  EXPECT_EQ(read.setting, pool.setting);
  EXPECT_EQ(read.seed, pool.seed);
  EXPECT_EQ(read.discs, DrapeDiscs());
  ASSERT_EQ(read.num_drapes(), 5);
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT((read.radius[i] - pool.radius[i]).cwiseAbs().maxCoeff(), 0.501 * kPackedRadius);
    for (int k = 0; k < kSpecimenNumbers; ++k) {
      const NumberRange& range = NumberRanges()[k];
      EXPECT_NEAR(read.numbers[i][k], pool.numbers[i][k], (range.high - range.low) / 65535);
    }
  }
}

TEST(OutlinePool, RefusesDamagedBytes) {
  std::string bytes = PackPool(SmallPool());
  EXPECT_THROW(UnpackPool("", "pool"), InputError);
  EXPECT_THROW(UnpackPool("{\"format\": \"other\"}\n", "pool"), InputError);
  EXPECT_THROW(UnpackPool(bytes.substr(0, bytes.size() - 9), "pool"), InputError);
  bytes[bytes.size() - 20] = static_cast<char>(bytes[bytes.size() - 20] ^ 1);
  EXPECT_THROW(UnpackPool(bytes, "pool"), InputError);
}

TEST(OutlinePool, FindsATurnedMirroredDrape) {
  const OutlinePool pool = SmallPool();
  constexpr int kTurn = 9;  // of 5°
  Eigen::VectorXd seen(kPoolAngles);
  for (int i = 0; i < kPoolAngles; ++i)
    seen[i] = pool.radius[3][(kTurn - i + kPoolAngles) % kPoolAngles];
  const std::vector<PooledMatch> nearest = FindNearest(pool, seen, 2);
  ASSERT_EQ(nearest.size(), 2u);
  EXPECT_EQ(nearest[0].drape, 3);
  EXPECT_LT(nearest[0].distance, 1e-9);
  EXPECT_GT(nearest[1].distance, 1e-3);
  EXPECT_LT((nearest[0].numbers - TurnedNumbers(pool.numbers[3], kTurn * M_PI / 36))
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

// The search leaves out what cannot be near; here all drapes are compared.
TEST(OutlinePool, FindsTheNearestOfAll) {
  const OutlinePool* pool = FindBuiltInPool(DrapeDiscs());
  ASSERT_NE(pool, nullptr);
  for (const int drape : {17, 4321}) {
    const Eigen::VectorXd seen = (pool->radius[drape] + 0.2 * Waves(7, 0.3)).reverse() / 1.18;
    std::vector<std::pair<double, int>> all;
    for (int i = 0; i < pool->num_drapes(); ++i)
      all.emplace_back(MatchOutlines(seen, pool->radius[i], OutlineFreedom::kRotationAndMirror).rms,
                       i);
    std::sort(all.begin(), all.end());
    const std::vector<PooledMatch> nearest = FindNearest(*pool, seen, 51);
    ASSERT_EQ(nearest.size(), 51u);
    for (std::size_t k = 0; k < nearest.size(); ++k)
      EXPECT_EQ(std::pair(nearest[k].distance, nearest[k].drape), all[k]) << drape << " " << k;
  }
}

TEST(OutlinePool, TurnsTheDirectionsOfACloth) {
  SpecimenNumbers numbers = SpecimenNumbers::Zero();
  numbers[kLogBendingLength] = -4.0;
  numbers[kBendAnisotropy] = 1.2;
  numbers[kBiasBend] = 0.3;
  numbers[kStretchAnisotropy] = 0.5;
  // A quarter turn swaps warp and weft, half a turn changes nothing.
  SpecimenNumbers swapped = numbers;
  swapped[kBendAnisotropy] = -1.2;
  swapped[kStretchAnisotropy] = -0.5;
  EXPECT_LT((TurnedNumbers(numbers, M_PI / 2) - swapped).norm(), 1e-12);
  EXPECT_LT((TurnedNumbers(numbers, M_PI) - numbers).norm(), 1e-12);
  // An eighth makes both the old 45°, whose rigidity is e^0.3 of the mean; 45° is the old mean.
  const SpecimenNumbers eighth = TurnedNumbers(numbers, M_PI / 4);
  EXPECT_NEAR(eighth[kBendAnisotropy], 0.0, 1e-12);
  EXPECT_NEAR(3 * (eighth[kLogBendingLength] + 4.0), 0.3, 1e-12);
  EXPECT_NEAR(eighth[kBiasBend], -0.3, 1e-12);
}

// Drapes that a pool does not have lie in nine of ten of its intervals.
TEST(OutlinePool, IntervalsOfBendingLengthsHold) {
  const OutlinePool* whole = FindBuiltInPool(DrapeDiscs());
  ASSERT_NE(whole, nullptr);
  constexpr int kOneOf = 120;
  OutlinePool pool = *whole;
  pool.numbers.clear();
  pool.radius.clear();
  for (int i = 0; i < whole->num_drapes(); ++i)
    if (i % kOneOf != 0) {
      pool.numbers.push_back(whole->numbers[i]);
      pool.radius.push_back(whole->radius[i]);
    }
  int tried = 0, held = 0;
  double log_width = 0.0;
  for (int i = 0; i < whole->num_drapes(); i += kOneOf) {
    const PooledLength found = EstimateBendingLength(pool, whole->radius[i]);
    const double length = std::exp(whole->numbers[i][kLogBendingLength]);
    EXPECT_LE(found.low, found.median);
    EXPECT_LE(found.median, found.high);
    ++tried;
    held += (found.reaches_least || found.low <= length) &&
            (found.reaches_most || length <= found.high);
    log_width += std::log(found.high / found.low);
  }
  EXPECT_NEAR(double(held) / tried, 0.9, 0.06) << tried;
  EXPECT_LT(std::exp(0.5 * log_width / tried), 1.35);
}

// The first drape of the shipped pool, simulated again as large as it was and smaller.
TEST(OutlinePool, HasTheDrapesOfTheSimulatorAtEachSize) {
  const OutlinePool* pool = FindBuiltInPool(DrapeDiscs());
  ASSERT_NE(pool, nullptr);
  EXPECT_GT(pool->num_drapes(), 15000);
  std::optional<PooledSpecimen> specimen;
  for (int i = 0; i < 100 && !specimen; ++i) {
    const PooledSpecimen each = MakePooledSpecimen({}, pool->seed, i);
    if ((each.numbers - pool->numbers[0]).cwiseAbs().maxCoeff() < 1e-4) specimen = each;
  }
  ASSERT_TRUE(specimen);
  Eigen::VectorXd whole;  // the drape at the pool's size [m]
  for (const double scale : {1.0, 0.5}) {
    const DrapeDiscs discs{.specimen = scale * DrapeDiscs().specimen,
                           .support = scale * DrapeDiscs().support};
    const OutlinePool* of_size = FindBuiltInPool(discs);
    ASSERT_NE(of_size, nullptr);
    EXPECT_EQ(of_size->discs, discs);
    Scene scene = CusickScene({}, discs.support);
    scene.handles->stiffness *= scale;  // gives way in proportion to the size
    const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(pool->mesh, {}, discs),
                                                          scene, MakeLaw(LawKind::kSmooth));
    StartShape shape = specimen->start;
    for (StartShape::Mode& mode : shape.modes) mode.amplitude_m *= scale;
    const State start = {ApplyStartShape(model->mesh, discs.support, shape),
                         Eigen::VectorXd::Zero(model->num_dofs())};
    SettleOptions settle = PoolOptions().settle;
    settle.steps.h *= std::sqrt(scale);  // falls are alike in time over the root of the size
    const SettledDrape drape =
        std::move(Settle(*MakeCpuBackend(model, 1), SpecimenMaterial(of_size->numbers[0]),
                         {&start, 1}, settle)
                      .front());
    ASSERT_TRUE(drape.IsUsable(SolveMode::kStatic));
    const DrapeShape seen = ComputeDrapeShape(ObserveSurface(
        {drape.rest.x, ListTriangles(model->mesh)}, CameraAbove(discs), discs, "drape"));
    // The picture of a small drape has fewer pixels.
    EXPECT_LT((seen.radius - of_size->radius[0]).cwiseAbs().maxCoeff(), scale < 1.0 ? 5e-4 : 1e-4);
    if (scale == 1.0) whole = drape.rest.x;
    EXPECT_LT((drape.rest.x / scale - whole).cwiseAbs().maxCoeff(), 1e-5) << scale;
  }
}

TEST(OutlinePool, ServesAllDiscsOfItsRatio) {
  for (const auto& [specimen, support] :
       {std::pair(0.12, 0.09), std::pair(0.18, 0.09), std::pair(0.127, 0.0635)}) {
    const OutlinePool* pool = FindBuiltInPool({.specimen = specimen, .support = support});
    ASSERT_NE(pool, nullptr) << specimen;
    EXPECT_GT(pool->num_drapes(), 14000);
    double largest = 0.0;
    for (const Eigen::VectorXd& radius : pool->radius)
      largest = std::max(largest, radius.maxCoeff());
    EXPECT_NEAR(largest, specimen, 0.01 * specimen);
  }
  EXPECT_EQ(FindBuiltInPool({.specimen = 0.14, .support = 0.09}), nullptr);
}

// An interval that ends where the drapes of the pool end is open there, at each size.
TEST(OutlinePool, KnowsTheEndsOfItsRange) {
  for (const double scale : {1.0, 0.5}) {
    const OutlinePool* pool = FindBuiltInPool({.specimen = scale * 0.15, .support = scale * 0.09});
    ASSERT_NE(pool, nullptr);
    int softest = 0;
    for (int i = 0; i < pool->num_drapes(); ++i)
      if (pool->numbers[i][kLogBendingLength] < pool->numbers[softest][kLogBendingLength])
        softest = i;
    const PooledLength found = EstimateBendingLength(*pool, pool->radius[softest]);
    EXPECT_TRUE(found.reaches_least) << scale;
    EXPECT_FALSE(found.reaches_most) << scale;
  }
}

}  // namespace
}  // namespace drape
