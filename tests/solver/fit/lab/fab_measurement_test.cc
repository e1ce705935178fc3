// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "solver/fit/lab_measurement.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class FabMeasurementFile : public FileFixture {
 protected:
  // One way of a strip of 8 cm that follows F = k·strain, from strain 0 to `most` or back, with an
  // offset of the force of 0.4 gf.
  static nlohmann::json Way(double k, double most, bool back) {
    nlohmann::json cycle = nlohmann::json::array();
    constexpr int kSamples = 400;
    for (int i = 0; i <= kSamples; ++i) {
      const double strain = most * (back ? kSamples - i : i) / kSamples;
      cycle.push_back(8.0 * (1.0 + strain));
      cycle.push_back(0.4 + (back ? 0.6 : 1.0) * k * strain);
    }
    return cycle;
  }
  static nlohmann::json Strip(double k) {
    return {{"S2",
             {{"freq", 55},
              {"width", 5},
              {"length", 8.2},
              {"samplesTree",
               {Way(k, 0.05, false), Way(k, 0.05, true), Way(k, 0.1, false), Way(k, 0.1, true)}}}}};
  }
  static nlohmann::json File() {
    return {{"schema", "1.1"},
            {"custom", nullptr},
            {"raw_data", {{"L", Strip(9000)}, {"W", Strip(6000)}, {"B", Strip(500)}, {"M", 150}}}};
  }
};

TEST_F(FabMeasurementFile, HasAStripForEachDirection) {
  const auto strips = ReadLabMeasurements(Write("denim.json", File().dump()));
  ASSERT_EQ(strips.size(), 3u);
  const double direction[] = {0.0, 45.0, 90.0}, stiffness[] = {6000.0, 500.0, 9000.0};
  const char* names[] = {"denim_weft", "denim_bias", "denim_warp"};
  for (int i = 0; i < 3; ++i) {
    const LabMeasurement& strip = strips[i];
    EXPECT_EQ(strip.name, names[i]);
    EXPECT_EQ(strip.kind, LabMeasurementKind::kTensile);
    EXPECT_EQ(strip.direction, direction[i]);
    EXPECT_DOUBLE_EQ(strip.length, 0.08);
    EXPECT_DOUBLE_EQ(strip.width, 0.05);
    EXPECT_DOUBLE_EQ(strip.sigma, std::max(1e-3, 0.01 * (strip.points.back().reading - 1.0)));
    ASSERT_EQ(strip.points.size(), 10u);
    for (const LabPoint& point : strip.points)  // of the loading to 10 %, not of the way back
      EXPECT_NEAR(point.set, 9.80665e-3 * stiffness[i] * (point.reading - 1.0),
                  0.01 * strip.points.back().set);
    EXPECT_GT(strip.points.back().reading, 1.09);
  }
}

TEST_F(FabMeasurementFile, IsFoundThroughItsMaterial) {
  Write("raw.json", File().dump());
  const std::string material =
      Write("denim.u3m",
            R"({"schema": "1.1", "material": {"physics": {"devices": {"fab": "raw.json"}}}})");
  EXPECT_EQ(ReadLabMeasurements(material).size(), 3u);
  EXPECT_EQ(ReadLabMeasurements(material)[2].name, "raw_warp");
}

TEST_F(FabMeasurementFile, OtherFilesAreMeasurementsOfOurs) {
  const auto own = ReadLabMeasurements(Write("own.json", R"({"test": "cantilever", "direction": 0,
      "sigma": 1, "points": [{"length": 0.06, "angle": 41.5}]})"));
  ASSERT_EQ(own.size(), 1u);
  EXPECT_EQ(own[0].kind, LabMeasurementKind::kCantilever);
}

TEST_F(FabMeasurementFile, BadFilesAreNamed) {
  const auto expect = [&](const char* pointer, const nlohmann::json& value, const char* text) {
    nlohmann::json file = File();
    file[nlohmann::json::json_pointer(pointer)] = value;
    EXPECT_INPUT_ERROR(ReadLabMeasurements(Write("bad.json", file.dump())), text);
  };
  expect("/raw_data", nlohmann::json::object(), "expected the strips \"W\", \"B\" or \"L\"");
  expect("/raw_data/W/S2/width", 50, "'raw_data.W.S2.width': found 50");
  expect("/raw_data/B/S2/samplesTree", nlohmann::json::array({Way(500, 0.1, true)}),
         "distance and force rise");
  expect("/raw_data/B/S2/samplesTree/0", {8.0, 1.0, 8.1}, "pairs of distance and force");
  expect("/raw_data/B/S2/samplesTree/0/3", "x", "samplesTree[0][3]");
  Write("lost.u3m",
        R"({"schema": "1.1", "material": {"physics": {"devices": {"fab": "no.json"}}}})");
  EXPECT_INPUT_ERROR(ReadLabMeasurements(Path("lost.u3m")), "no.json");
  Write("bare.u3m", R"({"schema": "1.1", "material": {"physics": {}}})");
  EXPECT_INPUT_ERROR(ReadLabMeasurements(Path("bare.u3m")), "devices");
}

}  // namespace
}  // namespace drape
