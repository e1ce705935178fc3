// SPDX-License-Identifier: Apache-2.0
// What --accuracy promises, on drapes that its table was not made on: of another fabric, or from
// another start (configs/studies/bench/table.json).
#include "tools/inputs/accuracy_option.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "physics/cloth/state.h"
#include "solver/forward/accuracy_table.h"
#include "solver/studies/bench/work_precision.h"

namespace drape::test {
namespace {

const std::string kConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs";

// The reference is made as that of configs/studies/bench/table.json.
const ReferenceOptions kReference = {
    .fine = "disc:4800", .coarse = "disc:2400", .relax_mesh = "disc:1200"};

struct HeldOut {
  const char *fabric, *start;
};
void PrintTo(const HeldOut& drape, std::ostream* out) {
  *out << drape.fabric << " " << drape.start;
}

class Accuracy : public testing::TestWithParam<HeldOut> {};

TEST_P(Accuracy, HoldsOnADrapeThatTheTableHasNotSeen) {
  const AccuracyTable table = ParseAccuracyTable(kBuiltInAccuracy, "built-in");
  const BenchProblem problem{ReadStartShape(kConfigs + "/starts/" + GetParam().start + ".json"),
                             "disc:300"};
  BenchSetting setting;
  setting.material = kConfigs + "/fabrics/" + GetParam().fabric + ".json";
  const BenchReference reference =
      ReadReference(FindReference(setting, problem, kReference, BenchWork::kForward, nullptr),
                    kReference, "test");
  for (const char* level : {"fast", "balanced", "exact"}) {
    const AccuracyRow& row = table.Pick(level, "");
    setting.mesh = row.mesh;
    setting.integrator = row.integrator;
    setting.h = row.h;
    setting.relax_time = row.h * row.steps;
    const nlohmann::json found =
        RunBenchSetting(BenchWork::kForward, setting, problem, reference, {.repeats = 1}, nullptr);
    EXPECT_EQ(found.at("status"), "ok") << level;
    const double error_mm = found.at("radius_mm");
    EXPECT_GT(error_mm, 0) << level;
    EXPECT_LE(error_mm, row.error_mm) << level << " " << row.mesh;
  }
}

INSTANTIATE_TEST_SUITE_P(Drapes, Accuracy,
                         testing::Values(HeldOut{"cotton_blue", "six_waves"},
                                         HeldOut{"wool_red", "four_waves"}));

}  // namespace
}  // namespace drape::test
