// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/lab_measurement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/physics/file_fixture.h"
#include "tests/solver/fit/observed/write_lab_measurement.h"

namespace drape {
namespace {

class LabMeasurementFile : public FileFixture {
 protected:
  static constexpr const char* kCantilever =
      R"({"test": "cantilever", "direction": 45, "sigma": 0.5,
          "points": [{"length": 0.06, "angle": 41.5}, {"length": 0.05, "angle": 30}]})";
  static constexpr const char* kTensile =
      R"({"test": "tensile", "direction": 90, "length": 0.2, "width": 0.05, "sigma": 0.002,
          "points": [{"force": 5.0, "stretch": 1.02}]})";

  // The text with one part replaced.
  std::string With(std::string text, const std::string& part, const std::string& other) const {
    EXPECT_NE(text.find(part), std::string::npos) << part;
    return Write("bad.json", text.replace(text.find(part), part.size(), other));
  }
};

TEST_F(LabMeasurementFile, IsReadWithPointsByRisingLength) {
  const LabMeasurement test = ReadLabMeasurements(Write("bias.json", kCantilever)).front();
  EXPECT_EQ(test.name, "bias");
  EXPECT_EQ(test.kind, LabMeasurementKind::kCantilever);
  EXPECT_EQ(test.direction, 45.0);
  EXPECT_EQ(test.sigma, 0.5);
  ASSERT_EQ(test.points.size(), 2u);
  EXPECT_EQ(test.points[0].set, 0.05);
  EXPECT_EQ(test.points[0].reading, 30.0);
  EXPECT_EQ(test.points[1].set, 0.06);
}

TEST_F(LabMeasurementFile, IsWrittenAsItIsRead) {
  const LabMeasurement warp = ReadLabMeasurements(Write("warp.json", kTensile)).front();
  EXPECT_EQ(warp.length, 0.2);
  EXPECT_EQ(warp.width, 0.05);
  test::WriteLabMeasurement(Path("copy.json"), warp);
  const LabMeasurement copy = ReadLabMeasurements(Path("copy.json")).front();
  EXPECT_EQ(copy.kind, LabMeasurementKind::kTensile);
  EXPECT_EQ(copy.direction, 90.0);
  EXPECT_EQ(copy.width, 0.05);
  EXPECT_EQ(copy.sigma, 0.002);
  ASSERT_EQ(copy.points.size(), 1u);
  EXPECT_EQ(copy.points[0].set, 5.0);
  EXPECT_EQ(copy.points[0].reading, 1.02);
}

TEST_F(LabMeasurementFile, BadValuesAreNamed) {
  const auto expect = [&](const std::string& path, const std::string& text) {
    EXPECT_INPUT_ERROR(ReadLabMeasurements(path), text);
  };
  expect(With(kCantilever, "sigma", "sigmas"), "unknown key 'sigmas'");
  expect(With(kCantilever, "cantilever", "shear"),
         "found 'shear', expected one of cantilever, tensile");
  expect(With(kCantilever, "0.06", "-0.06"), "bad.json: key 'points[0].length': found -0.06");
  expect(With(kCantilever, "41.5", "90"), "'points[0].angle': found 90, expected a number > 0.0");
  expect(With(kCantilever, "0.5,", "0,"), "key 'sigma'");
  expect(With(kCantilever, R"("sigma": 0.5,)", ""), "'sigma' is missing");
  expect(With(kCantilever, "angle", "stretch"), "unknown key 'points[0].stretch'");
  expect(With(kTensile, "0.2,", "-0.2,"), "key 'length': found -0.2");
  expect(With(kTensile, R"([{"force": 5.0, "stretch": 1.02}])", "[]"), "at least one point");
  expect(With(kTensile, R"("width": 0.05,)", ""), "'width' is missing");
  expect(With(kTensile, "5.0", "0"), "'points[0].force': found 0, expected a number > 0.0");
}

TEST_F(LabMeasurementFile, OtherUnitsAreNamed) {
  const auto expect = [&](const std::string& path, const std::string& text) {
    EXPECT_INPUT_ERROR(ReadLabMeasurements(path), text);
  };
  expect(With(kCantilever, "0.06", "6"),
         "bad.json: key 'points': largest length: found 6 m, expected about 0.005 … 0.5 m; in cm "
         "it would be 0.06");
  const std::string angles = With(kCantilever, "41.5", "0.724");
  expect(With(Read(angles), "30}", "0.5236}"),
         "largest angle: found 0.724 deg, expected about 2 … 90 deg; in rad it would be 41.48 deg");
  expect(With(kCantilever, "45,", "0.7854,"),
         "'direction': found 0.7854 deg, expected about 2 … 360 deg; in rad it would be 45 deg");
  expect(With(kTensile, "0.2,", "8,"), "key 'length': found 8 m");
  expect(With(kTensile, "0.05,", "5,"), "key 'width': found 5 m");
  expect(With(kTensile, "5.0", "510"),
         "key 'points': largest force: found 510 N, expected about 0.002 … 100 N; in gf it would "
         "be 5.001, in mN it would be 0.51 N");
}

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
  EXPECT_EQ(ReadLabMeasurements(material)[2].density, 0.15);
}

TEST_F(FabMeasurementFile, StatesTheMass) {
  const auto density = [&](const nlohmann::json& mass, const std::string& weight) {
    nlohmann::json file = File();
    file["raw_data"]["M"] = mass;
    Write("raw.json", file.dump());
    return ReadLabMeasurements(Write("a.u3m", R"({"schema": "1.1", "material": {"physics": {)" +
                                                  weight + R"("devices": {"fab": "raw.json"}}}})"))
        .front()
        .density;
  };
  EXPECT_EQ(density(300, ""), 0.3);
  EXPECT_EQ(density(nullptr, ""), 0.0);
  EXPECT_EQ(density(300, R"("weight": null, )"), 0.3);
  testing::internal::CaptureStderr();
  EXPECT_EQ(density(300, R"("weight": 120, )"), 0.12);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("weight is 120 g/m2"));
  EXPECT_INPUT_ERROR(density(0.3, ""),
                     "raw.json: key 'raw_data.M': found 0.3 g/m2, expected about "
                     "10 … 1500 g/m2; in kg/m2 it would be 300 g/m2");
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
  for (const std::string missing : {"no.json", ""}) {
    const std::string lost =
        Write("lost.u3m", R"({"schema": "1.1", "material": {"physics": {"devices": {"fab": ")" +
                              missing + "\"}}}}");
    EXPECT_INPUT_ERROR(ReadLabMeasurements(lost), "lost.u3m: key 'material.physics.devices.fab'");
  }
  Write("bare.u3m", R"({"schema": "1.1", "material": {"physics": {}}})");
  EXPECT_INPUT_ERROR(ReadLabMeasurements(Path("bare.u3m")), "devices");
}

}  // namespace
}  // namespace drape
