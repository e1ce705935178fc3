// SPDX-License-Identifier: Apache-2.0
// What --accuracy promises, on fabrics that its table was not made on.
#include <gtest/gtest.h>

#include <string>

#include "physics/cloth/start_shape.h"
#include "solver/forward/accuracy_table.h"
#include "solver/studies/bench/work_precision.h"
#include "tools/inputs/built_in_accuracy.h"

namespace drape::test {
namespace {

const std::string kConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs";

// The reference is made as that of configs/studies/bench/table.json.
const ReferenceOptions kReference = {
    .fine = "disc:4800", .coarse = "disc:2400", .relax_mesh = "disc:1200"};

class Accuracy : public testing::TestWithParam<const char*> {};

TEST_P(Accuracy, HoldsOnAFabricThatTheTableHasNotSeen) {
  const AccuracyTable table = ParseAccuracyTable(kBuiltInAccuracy, "built-in");
  ASSERT_EQ(table.made_on.find(GetParam()), std::string::npos);
  const BenchProblem problem{ReadStartShape(kConfigs + "/starts/six_waves.json"), "disc:300"};
  BenchSetting setting;
  setting.material = kConfigs + "/fabrics/" + GetParam() + ".json";
  const BenchReference reference =
      ParseReference(ReferenceText(setting, problem, kReference, BenchWork::kForward, nullptr),
                     kReference, "test");
  for (const char* level : {"fast", "balanced", "exact"}) {
    const AccuracyRow& row = table.Pick(level, "");
    setting.mesh = row.mesh;
    setting.integrator = row.integrator;
    setting.h = row.h;
    setting.relax_time = row.h * row.steps;
    const BenchRecord found =
        RunBenchSetting(BenchWork::kForward, setting, problem, reference, {.repeats = 1}, nullptr);
    EXPECT_EQ(found.status, "ok") << level;
    EXPECT_GT(found[kRadiusMm], 0) << level;
    EXPECT_LE(found[kRadiusMm], row.error_mm) << level << " " << row.mesh;
  }
}

INSTANTIATE_TEST_SUITE_P(Fabrics, Accuracy, testing::Values("cotton_blue", "synthetic_shirt"));

}  // namespace
}  // namespace drape::test
