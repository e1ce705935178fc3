// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/samples.h"

#include <gmock/gmock.h>

#include "tests/physics/file_fixture.h"
#include "tools/programs/results/tables/sample_report.h"

namespace drape::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::ordered_json;

class Samples : public FileFixture {
 protected:
  Samples() {
    for (const char* name : {"a.png", "b.png", "c.png"}) Write(name, "");
  }
  SampleTable Table(const std::string& text) const {
    return ReadSamples(Write("samples.csv", text));
  }
  void ExpectError(const std::string& table, const std::string& text) const {
    EXPECT_INPUT_ERROR(Table(table), text);
  }
};

TEST_F(Samples, SpreadsheetsAreRead) {
  const SampleTable table = Table(
      "\xEF\xBB\xBF"
      "fabric;file;mass;Bemerkung;specimen\r\n"
      "felt;a.png;150,5;\"one; \"\"two\"\"\nlines\";1\r\n;;;;\r\nfelt;b.png;150,5;;2\r\n");
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].file, Path("a.png"));
  EXPECT_EQ(table.rows[0].mass, 150.5);
  EXPECT_EQ(table.rows[0].of("Bemerkung"), "one; \"two\"\nlines");
  EXPECT_THAT(table.SpecimenNumbers(), ElementsAre(1, 2));
  EXPECT_EQ(ReadSamples(Path("")).rows.size(), 2U);
  EXPECT_EQ(ReadSamples(Path("samples.csv") + "#felt").rows.size(), 2U);
}

TEST_F(Samples, FaultsAreNamedByLineColumnAndValue) {
  ExpectError("fabric\nfelt\n", "samples.csv:1: no column 'file'");
  ExpectError("file,face,face\n", "samples.csv:1: the column 'face' is there twice");
  ExpectError("file,face\na.png,up\nb.png,upp\n",
              "samples.csv:3: column 'face': found 'upp', expected up, down or nothing");
  ExpectError("file\na.png\nmissing.png\n", "samples.csv:3: column 'file': found 'missing.png'");
  ExpectError("file,mass\na.png,heavy\n", "samples.csv:2: column 'mass': found 'heavy'");
  ExpectError("file,diameter\na.png,30\n", "in cm it would be 0.3 m");
  ExpectError("file\na.png\nb.png\na.png\n",
              "samples.csv:4: column 'file': found 'a.png' of line 2");
  ExpectError("file,warp\na.png,9x\n", "samples.csv:2: column 'warp': found '9x'");
  ExpectError("file\na.png,b\n", "samples.csv:2: found 2 fields, expected at most the 1");
  ExpectError("file\n\"a.png\n", "samples.csv:2: a quotation mark is never closed");
  ExpectError("file,error\na.png,no disc\n", "has no picture");
}

TEST_F(Samples, OneFitIsOfOneFabric) {
  const std::string table = Write("samples.csv", "file,fabric\na.png,felt\nb.png,wool\n");
  FitSpec spec;
  FitData data;
  EXPECT_INPUT_ERROR(AddImages(table, &spec, &data), "has 2 fabrics, expected one: " + table +
                                                         "#felt; drapefit " + table + " fits each");
}

TEST_F(Samples, FoldersAreFabrics) {
  for (const char* fabric : {"felt", "wool"}) std::filesystem::create_directories(Path(fabric));
  Write("felt/1.png", "");
  Write("wool/1.png", "");
  const SampleTable table = ReadSamples(Path(""));
  EXPECT_EQ(table.rows.size(), 5U);
  EXPECT_EQ(table.rows[3].of("fabric"), "felt");
  EXPECT_EQ(table.rows[3].name, "felt_1");
  EXPECT_EQ(table.rows[0].name, "a");
}

MeasuredSample Picture(const std::string& fabric, const std::string& specimen,
                       const std::string& face, double percent, int nodes) {
  return {
      .row = {.file = "p",
              .name = {},
              .cells = {{"file", "p"}, {"fabric", fabric}, {"specimen", specimen}, {"face", face}}},
      .coefficient = percent / 100,
      .nodes = nodes};
}

// Specimens of 40 and 44 % face up, 42 and 46 % face down, two pictures each.
std::vector<MeasuredSample> TwoSpecimens(const std::string& fabric) {
  std::vector<MeasuredSample> pictures;
  for (const double off : {-1.0, 1.0}) {
    pictures.push_back(Picture(fabric, "1", "up", 40 + off, 6));
    pictures.push_back(Picture(fabric, "1", "down", 42 + off, 7));
    pictures.push_back(Picture(fabric, "2", "up", 44 + off, 7));
    pictures.push_back(Picture(fabric, "2", "down", 46 + off, 8));
  }
  return pictures;
}

TEST_F(Samples, MeansAreOfSpecimensAndFaces) {
  const Json groups = SamplesJson(TwoSpecimens("felt")).at("groups");
  ASSERT_EQ(groups.size(), 9U);  // the fabric and two specimens, each up, down and together
  EXPECT_EQ(groups[0]["face"], "up");
  EXPECT_NEAR(groups[0]["dc_percent"], 42, 1e-9);
  const Json& all = groups[2];
  EXPECT_EQ(all["n"], 2);
  EXPECT_EQ(all["of"], "specimens");
  EXPECT_EQ(all["pictures"], 8);
  EXPECT_NEAR(all["dc_percent"], 43, 1e-9);
  EXPECT_NEAR(all["dc_sd_percent"], std::sqrt(8), 1e-9);
  EXPECT_NEAR(all["dc_high_percent"], 43 + 2 * 6.313751514675043, 1e-9);  // t of 1 degree
  EXPECT_EQ(all["nodes"], Json({7}));
  const Json& specimen = groups[5];
  EXPECT_EQ(specimen["specimen"], "1");
  EXPECT_EQ(specimen["of"], "pictures");
  EXPECT_NEAR(specimen["dc_percent"], 41, 1e-9);
  EXPECT_NEAR(specimen["dc_sd_percent"], std::sqrt(2), 1e-9);
}

TEST_F(Samples, WhatIsUnknownIsSaid) {
  std::vector<MeasuredSample> pictures = {Picture("felt", "1", "", 40, 6),
                                          Picture("felt", "1", "", 41, 6)};
  EXPECT_TRUE(SamplesJson(pictures)["groups"][0]["dc_sd_percent"].is_null());
  EXPECT_THAT(SamplesText(SamplesJson(pictures)), HasSubstr("1 specimen    unknown"));
  for (MeasuredSample& each : pictures) each.row.cells["specimen"] = "";
  const Json unnamed = SamplesJson(pictures);
  EXPECT_TRUE(unnamed["groups"][0]["dc_low_percent"].is_null());
  EXPECT_FALSE(unnamed["groups"][0]["dc_sd_percent"].is_null());
  EXPECT_THAT(unnamed["notes"][0], HasSubstr("in the column 'specimen'"));
}

TEST_F(Samples, FabricsAreCompared) {
  std::vector<MeasuredSample> pictures = TwoSpecimens("felt");
  for (MeasuredSample& each : TwoSpecimens("wool")) {
    each.coefficient += 0.4;
    pictures.push_back(each);
  }
  const Json difference = SamplesJson(pictures)["differences"][0];
  EXPECT_EQ(difference["a"], "wool");
  // Variances of 4 each: the root of 8 by t of 2 degrees.
  EXPECT_NEAR(difference["low"], 40 - std::sqrt(8) * 2.919985580355516, 1e-9);
  EXPECT_THAT(difference["text"],
              "the drape coefficient of wool is higher than that of felt by 40.0 "
              "points (90 %: 31.7 … 48.3)");
  pictures.resize(9);
  EXPECT_THAT(SamplesJson(pictures)["differences"][0]["text"],
              HasSubstr("the interval is unknown"));
}

TEST_F(Samples, CsvIsReadAgain) {
  const Json samples = SamplesJson(TwoSpecimens("fe,\"lt"));
  EXPECT_THAT(CsvOfObjects(samples["groups"]),
              HasSubstr("\n\"fe,\"\"lt\",,,,8,43,2.82843,2,specimens,30.3725,55.6275,7\n"));
}

}  // namespace
}  // namespace drape::test
