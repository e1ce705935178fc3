// SPDX-License-Identifier: Apache-2.0
// drape_photo with the files that people send.
#include <gmock/gmock.h>

#include "losses/camera/camera.h"
#include "tests/losses/image/encode.h"
#include "tests/losses/photo/rendered/photo_file.h"
#include "tests/losses/photo/rendered/photo_trial.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kPhoto = std::string(DRAPE_BIN_DIR) + "/drape_photo";

const RgbImage& Picture() {
  static const RgbImage picture = RenderPhoto(SmallScene(), {{&Wool().mesh, Wool().x}});
  return picture;
}

std::string Text(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

class PhotoTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::string& photo, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {kPhoto, photo, "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
  void ExpectMeasured(const ProcessResult& result) const {
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NEAR(100 * ReadJson(Path("out/summary.json"))["dc"].get<double>(),
                100 * Wool().coefficient, 0.7);
  }
};

TEST_F(PhotoTool, WritesWhatAFitReads) {
  WritePhotoFile(SmallScene(), Picture(), Path("a.jpg"));
  ExpectMeasured(Run(Path("a.jpg")));
  const Camera camera = ReadCamera(Path("out/camera.json"));
  const GrayImage silhouette = ReadImage(Path("out/silhouette.png"));
  EXPECT_EQ(silhouette.width, camera.width);
  EXPECT_EQ(silhouette.height, camera.height);
  EXPECT_NEAR(camera.eye_height, SmallScene().eye.z(), 0.01);
  const Json summary = ReadJson(Path("out/summary.json"));
  const Json photograph = ReadJson(Path("out/camera.json"))["photograph"];
  for (const char* key : {"dc", "dc_sd", "warnings"}) EXPECT_EQ(photograph[key], summary[key]);
  EXPECT_THAT(summary["bending_length"], HasSubstr("bending length c, overall "));
  EXPECT_EQ(ReadWarp(Path("out/camera.json")), "unknown");
  ExpectMeasured(Run(Path("a.jpg"), {"--warp=12"}));
  EXPECT_EQ(ReadWarp(Path("out/camera.json")), "12");
  ExpectOneLineError(Run(Path("a.jpg"), {"--warp=9x"}), "option 'warp': found '9x'");
  EXPECT_TRUE(std::filesystem::exists(Path("out/overlay.png")));
}

TEST_F(PhotoTool, ReadsGreyJpegAnd16BitPng) {
  const RgbImage& picture = Picture();
  const auto grey = EncodeJpeg(GreyLevels(picture), picture.width, picture.height, 1);
  ExpectMeasured(Run(Write("grey.jpg", Text(grey)), {"--focal_35mm=38"}));
  std::vector<uint16_t> deep;  // libpng takes 16 bits as linear light
  for (const uint8_t value : picture.rgb) {
    const double stored = value / 255.0;
    const double light =
        stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4);
    deep.push_back(static_cast<uint16_t>(std::lround(65535 * light)));
  }
  const auto png = EncodePng(deep.data(), picture.width, picture.height, PNG_FORMAT_LINEAR_RGB);
  ExpectMeasured(Run(Write("deep.png", Text(png)), {"--focal_35mm=38"}));
}

TEST_F(PhotoTool, RefusesOtherFilesInOneLine) {
  const RgbImage& picture = Picture();
  const std::string whole = Text(PhotoFile(SmallScene(), picture));
  const auto cmyk = EncodeJpeg(std::vector<uint8_t>(size_t(4) * 64 * 48, 90), 64, 48, 4);
  const struct {
    const char *name, *reason;
    std::string content;
  } files[] = {{"half.jpg", "truncated or damaged JPEG", whole.substr(0, whole.size() / 2)},
               {"cmyk.jpg", "4 channels, expected 1 (grey) or 3 (colour)", Text(cmyk)},
               {"moving.gif", "neither JPEG nor PNG", "GIF89a\x10\x10"},
               {"apple.jpg", "neither JPEG nor PNG",
                std::string("\0\0\0\x18"
                            "ftypheic",
                            12)},
               {"web.jpg", "neither JPEG nor PNG", std::string("RIFF\0\0\0\0WEBP", 12)},
               {"page.png", "neither JPEG nor PNG", "%PDF-1.7\n"},
               {"empty.jpg", "is empty", ""}};
  for (const auto& file : files)
    ExpectOneLineError(Run(Write(file.name, file.content)), file.reason);
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

// A result that was there is kept, and the next one takes its place.
TEST_F(PhotoTool, ARefusalKeepsWhatWasThere) {
  WritePhotoFile(SmallScene(), Picture(), Path("a.jpg"));
  ExpectMeasured(Run(Path("a.jpg")));
  const std::string before = Read(Path("out/summary.json"));
  PhotoScene bare = SmallScene();
  bare.has_disc = false;
  WritePhotoFile(bare, RenderPhoto(bare, {{&Wool().mesh, Wool().x}}), Path("b.jpg"));
  ExpectOneLineError(Run(Path("b.jpg")), "no disc: ");
  EXPECT_EQ(Read(Path("out/summary.json")), before);
  EXPECT_GT(ReadImage(Path("out/refused.png")).width, 0);
  ExpectMeasured(Run(Path("a.jpg")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/refused.png")));
}

// Each photograph of a table has a folder, and a refused one a row with the reason. The same
// command runs only what has changed.
TEST_F(PhotoTool, SumsUpSamples) {
  WritePhotoFile(SmallScene(), Picture(), Path("a.jpg"));
  WritePhotoFile(SmallScene(), Picture(), Path("b.jpg"));
  Write("c.jpg", "no picture");
  const std::string table =
      Write("samples.csv",
            "file,fabric,specimen,Remark\na.jpg,wool,1,\"x, y\"\nb.jpg,wool,2,\n"
            "c.jpg,felt,1,\n");
  const ProcessResult result = Run(table);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("2 specimens"));
  EXPECT_THAT(result.out, HasSubstr("note: not measured: " + Path("c.jpg")));
  const Json samples = ReadJson(Path("out/summary.json"))["samples"];
  EXPECT_NEAR(samples["groups"][0]["dc_percent"], 100 * Wool().coefficient, 0.7);
  EXPECT_NEAR(samples["groups"][0]["dc_sd_percent"], 0.0, 1e-9);
  EXPECT_THAT(samples["pictures"][2]["error"], HasSubstr("neither JPEG nor PNG"));
  EXPECT_GT(ReadJson(Path("out/a/summary.json"))["specimen_in_overlay_px"][2], 300);
  EXPECT_GT(ReadCamera(Path("out/b/camera.json")).eye_height, 0.9);
  EXPECT_THAT(Read(Path("out/statistics.csv")), HasSubstr("\nwool,,,,2,"));
  const std::string measured = Read(Path("out/samples.csv"));
  EXPECT_THAT(measured, HasSubstr("file,fabric,specimen,Remark,picture,dc_percent,"));
  EXPECT_THAT(measured, HasSubstr("\na/a.png,wool,1,\"x, y\"," + Path("a.jpg")));
  ExpectOneLineError(
      RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_fit",
                  "--images=" + Path("out/samples.csv") + "#silk", "--out=" + Path("fit")}),
      "has no picture, expected at least one of the fabric 'silk'");
  const auto before = std::filesystem::last_write_time(Path("out/a/a.png"));
  std::filesystem::remove(Path("out/b/b.png"));
  EXPECT_EQ(Run(table).out, result.out);
  EXPECT_EQ(std::filesystem::last_write_time(Path("out/a/a.png")), before);
  EXPECT_TRUE(std::filesystem::exists(Path("out/b/b.png")));
  ExpectOneLineError(Run(Write("none.csv", "file\nc.jpg\n")), "no photograph can be measured; ");
}

// A column with the name of an option sets it for its row.
TEST_F(PhotoTool, TakesOptionsFromColumns) {
  WritePhotoFile(SmallScene(), Picture(), Path("a.jpg"));
  WritePhotoFile(SmallScene(), Picture(), Path("b.jpg"));
  const std::string table = Write("samples.csv",
                                  "file;focal_35mm;ground_points\na.jpg;;\n"
                                  "b.jpg;30;\"20,20,30,30\"\n");
  ASSERT_EQ(Run(table).exit_code, 0);
  const double a = ReadCamera(Path("out/a/camera.json")).eye_height;
  EXPECT_NEAR(ReadCamera(Path("out/b/camera.json")).eye_height / a, 30 / SmallScene().focal_35mm,
              0.02);
  ExpectOneLineError(Run(Write("bad.csv", "file;threshold\na.jpg;2\n")), "column 'threshold'");
}

}  // namespace
}  // namespace drape::test
