// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab_measurement.h"

#include "tests/physics/file_fixture.h"
#include "tests/solver/fit/lab/write_lab_measurement.h"

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

}  // namespace
}  // namespace drape
