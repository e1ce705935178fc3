// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/accuracy_table.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "physics/util/errors.h"

namespace drape {
namespace {

using testing::HasSubstr;

constexpr char kTable[] = R"({"format": "drapefit-accuracy", "version": 2, "made_on": "two fabrics",
  "max_residual": 1e-06, "max_drift_mm": 1.0, "fast_mm": 24, "balanced_mm": 8.485, "exact_mm": 3,
  "rows": [
    {"mesh": "disc:300", "solve": "hybrid", "time_step": 0.1, "steps": 100, "error_mm": 24,
     "residual": 16e-10, "drift_mm": 16e-3, "cost": 0.0625},
    {"mesh": "disc:600", "solve": "dynamic", "time_step": 0.1, "steps": 100, "error_mm": 9,
     "residual": 6e-10, "drift_mm": 6e-3, "cost": 0.25},
    {"mesh": "disc:1200", "solve": "hybrid", "time_step": 0.1, "steps": 100, "error_mm": 3,
     "residual": 2e-10, "drift_mm": 2e-3, "cost": 1}]})";

AccuracyTable MadeUpTable() { return ParseAccuracyTable(kTable, "t"); }

template <class Work>
std::string ComputeError(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(AccuracyTable, PicksTheCheapestThatHolds) {
  const AccuracyTable table = MadeUpTable();
  EXPECT_EQ(table.Pick("fast", "").mesh, "disc:300");
  EXPECT_EQ(table.Pick("10mm", "").mesh, "disc:600");
  EXPECT_EQ(table.Pick("10mm", "hybrid").mesh, "disc:1200");
  EXPECT_EQ(table.Pick("exact", "").mesh, "disc:1200");
  EXPECT_EQ(table.Pick("balanced", "hybrid").mesh, "disc:1200");
}

TEST(AccuracyTable, RefusesWhatItHasNot) {
  const AccuracyTable table = MadeUpTable();
  EXPECT_EQ(ComputeError([&] { table.Pick("0.5mm", ""); }),
            "option 'accuracy': found 0.5mm, expected at least 3mm: the table has nothing more "
            "exact");
  for (const char* text : {"good", "2", "-1mm", "mm", "2 mm", "nanmm"})
    EXPECT_THAT(ComputeError([&] { table.Pick(text, ""); }), HasSubstr("such as 0.5mm")) << text;
  EXPECT_THAT(ComputeError([] { ParseAccuracyTable("{\"format\": \"x\"}", "t"); }),
              HasSubstr("t: key"));
  AccuracyTable at_rest = table;
  std::erase_if(at_rest.rows, [](const auto& row) { return row.integrator == "dynamic"; });
  EXPECT_EQ(ComputeError([&] { at_rest.Pick("fast", "dynamic"); }),
            "option 'accuracy': found solve = dynamic, expected hybrid: the table has no dynamic "
            "setting whose drapes are at rest");
}

// A table goes through the same ranges as the options that it sets.
TEST(AccuracyTable, RefusesNumbersOutOfRange) {
  const auto text = nlohmann::json::parse(kTable);
  const auto error = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json changed = text;
    (changed.contains(key) ? changed : changed["rows"][1])[key] = value;
    return ComputeError([&] { ParseAccuracyTable(changed.dump(), "t.json"); });
  };
  EXPECT_EQ(error("steps", 2000000000),
            "t.json: key 'rows[1].steps': found 2000000000, expected a whole number from 1 to "
            "1000000");
  EXPECT_EQ(error("time_step", 1e9),
            "t.json: key 'rows[1].time_step': found 1000000000.0, expected a number from 0.0001 "
            "to 10");
  EXPECT_EQ(error("residual", 0.01),
            "t.json: key 'rows[1].residual': found 0.01, expected a number from 0 to 1e-06");
  EXPECT_EQ(error("drift_mm", 2),
            "t.json: key 'rows[1].drift_mm': found 2, expected a number from 0 to 1");
  EXPECT_EQ(error("mesh", "disc:99999999"),
            "t.json: key 'rows[1].mesh': found \"disc:99999999\", expected disc:N with N from 100 "
            "to 1000000");
  for (const char* mesh : {"disc:", "disc", "disc:600,radius=9", "../mesh.obj", ""})
    EXPECT_THAT(error("mesh", mesh), HasSubstr("'rows[1].mesh'")) << mesh;
  EXPECT_THAT(error("error_mm", 0), HasSubstr("'rows[1].error_mm'"));
  EXPECT_THAT(error("cost", -1), HasSubstr("'rows[1].cost'"));
  EXPECT_THAT(error("fast_mm", 1e300), HasSubstr("'fast_mm'"));
  EXPECT_THAT(error("max_residual", 1), HasSubstr("'max_residual'"));
  EXPECT_THAT(error("version", 1), HasSubstr("found 1, expected 2, a table of drapes at rest"));
}

}  // namespace
}  // namespace drape
