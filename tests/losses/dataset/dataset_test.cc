// SPDX-License-Identifier: Apache-2.0
// Tests each irregularity of the published layout [MODEL, M52] on a small tree of files.
#include "losses/dataset/dataset.h"

#include <gmock/gmock.h>

#include "tests/losses/dataset/synthetic_dataset.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

// "fabric.sample.capture face [mesh]" of each capture.
std::vector<std::string> Found(const std::vector<Capture>& captures) {
  std::vector<std::string> found;
  for (const Capture& c : captures) {
    found.push_back(std::to_string(c.fabric) + "." + std::to_string(c.sample) + "." +
                    std::to_string(c.capture) + " " + ClothFaceName(c.face) +
                    (c.mesh.empty() ? "" : " mesh"));
  }
  return found;
}

class DatasetTest : public testing::Test {
 protected:
  // Adds an empty file at data/<name>: ReadDataset looks at names only.
  std::string Add(const std::string& name) const { return tree_.AddFile("data/" + name, ""); }
  Dataset Read() const { return ReadDataset(tree_.path()); }

  const SyntheticDataset tree_ = {};
};

TEST_F(DatasetTest, TheRegularLayout) {
  for (const char* capture : {"1", "2", "3", "4"}) {
    Add(std::string("Fabric 2/silhouettes/Fabric_2_Sample_10_Capture_") + capture + ".jpg");
    Add(std::string("Fabric 2/meshes/Fabric_2_Sample_10_Capture_") + capture + ".obj");
  }
  Add("Fabric 2/silhouettes/Fabric_2_Sample_9_Capture_1.jpg");
  const Dataset dataset = Read();
  EXPECT_THAT(Found(dataset.captures), ElementsAre("2.9.1 up", "2.10.1 up mesh", "2.10.2 up mesh",
                                                   "2.10.3 down mesh", "2.10.4 down mesh"));
  EXPECT_THAT(dataset.skipped, IsEmpty());
  EXPECT_THAT(dataset.notes, IsEmpty());
  EXPECT_EQ(dataset.captures[4].Name(), "fabric 2, sample 10, capture 4");
  EXPECT_THAT(dataset.captures[4].mesh, EndsWith("Fabric_2_Sample_10_Capture_4.obj"));
  EXPECT_EQ(Found(ReadDataset(tree_.path() + "/data").captures), Found(dataset.captures));
  EXPECT_EQ(Found(ReadDataset(tree_.path() + "/").captures), Found(dataset.captures));
}

TEST_F(DatasetTest, NamesInAllTheirForms) {
  Add("Fabric 6/silouettes/Fabric_6_Sample_1_Capture_1.jpg");
  Add("Fabric 6/silouettes/Fabric 6 Sample 1 Obs 2.JPG");
  Add("Fabric 6/silouettes/fabric_6_sample_1_observation_3.jpeg");
  Add("Fabric 6/silouettes/Fabric_6_Sample_1_4.png");
  Add("Fabric_7/Sample 1/silhouettes/Fabric_7_Sample_1_Obs_2.jpg");
  Add("Fabric_7/Sample_1/meshes/Fabric_7_Sample_1_Obs_2_circle_3.obj");
  Add("Fabric 21/silhouettes/Fabric_21_Sample_4.jpg");
  Add("Fabric 21/meshes/Fabric_21_Sample_4.obj");
  Add("Fabric 20/silhouettes/Fabric_20_Sample_1_Capture_10.jpg");
  const Dataset dataset = Read();
  EXPECT_THAT(Found(dataset.captures),
              ElementsAre("6.1.1 up", "6.1.2 up", "6.1.3 down", "6.1.4 down", "7.1.2 up mesh",
                          "20.1.10 unknown", "21.4.1 up mesh"));
  EXPECT_THAT(dataset.skipped, IsEmpty());
}

TEST_F(DatasetTest, TheFoldersFabricWins) {
  Add("Fabric 19/silhouettes/Fabric_20_Sample_1_Capture_1.jpg");
  const Dataset dataset = Read();
  EXPECT_THAT(Found(dataset.captures), ElementsAre("19.1.1 up"));
  ASSERT_EQ(dataset.notes.size(), 1u);
  EXPECT_EQ(dataset.notes[0].text, "named as fabric 20, used as that of its folder, 19");
}

TEST_F(DatasetTest, MeshesOfFabrics11To20CarryTheOtherFacesNumbers) {
  for (const char* fabric : {"10", "11", "20", "21"}) {
    const std::string folder = std::string("Fabric ") + fabric;
    for (const char* capture : {"1", "2", "3", "4"})
      Add(folder + "/silhouettes/Sample_1_Capture_" + capture + ".jpg");
    Add(folder + "/meshes/Sample_1_Capture_1.obj");
    Add(folder + "/meshes/Sample_1_Capture_2.obj");
  }
  Add("Fabric 20/meshes/Sample_1_Capture_4.obj");
  EXPECT_THAT(Found(Read().captures),
              ElementsAre("10.1.1 up mesh", "10.1.2 up mesh", "10.1.3 down", "10.1.4 down",
                          "11.1.1 up", "11.1.2 up", "11.1.3 down mesh", "11.1.4 down mesh",
                          "20.1.1 up", "20.1.2 up mesh", "20.1.3 down mesh", "20.1.4 down mesh",
                          "21.1.1 up mesh", "21.1.2 up mesh", "21.1.3 down", "21.1.4 down"));
}

TEST_F(DatasetTest, WhatIsSkippedHasAReason) {
  Add("Fabric 1/silhouettes/Fabric_1_Sample_1_Capture_1.jpg");
  const std::string double_file = Add("Fabric 1/silhouettes/Fabric_1_Sample_1_Obs_1.jpg");
  const std::string nameless = Add("Fabric 1/silhouettes/scan.jpg");
  const std::string stray = Add("Fabric 1/silhouettes/Thumbs.db");
  const std::string outside = Add("Fabric 1/Fabric_1_Sample_2_Capture_1.jpg");
  const std::string lonely = Add("Fabric 1/meshes/Fabric_1_Sample_5_Capture_1.obj");
  const std::string notes = Add("notes.txt");
  const Dataset dataset = Read();
  EXPECT_THAT(Found(dataset.captures), ElementsAre("1.1.1 up"));
  const auto why = [&](const std::string& path) -> std::string {
    for (const FileNote& note : dataset.skipped)
      if (note.path == path) return note.text;
    return "not skipped";
  };
  EXPECT_EQ(dataset.skipped.size(), 6u);
  EXPECT_THAT(why(double_file), HasSubstr("the same capture as"));
  EXPECT_THAT(why(nameless), HasSubstr("no sample and capture"));
  EXPECT_THAT(why(stray), HasSubstr("neither an image"));
  EXPECT_THAT(why(outside), HasSubstr("neither an image"));
  EXPECT_THAT(why(lonely), HasSubstr("without an image"));
  EXPECT_THAT(why(notes), HasSubstr("not the folder of a fabric"));
}

TEST_F(DatasetTest, TrainingImages) {
  Add("Fabric 1/silhouettes/Sample_1_Capture_1.jpg");
  tree_.AddFile("bnn_image_gt/cotton_white/sample_10_upward_drape_1_Obs_5.jpg", "");
  tree_.AddFile("bnn_image_gt/wool_red/Wool_Red_Sample_1_Downward_Drape_2.jpg", "");
  tree_.AddFile("bnn_image_gt/cotton_white/sample_9_upward_drape_1.jpg", "");
  tree_.AddFile("bnn_image_gt/cotton_white/sample_9_sideways_drape_1.jpg", "");
  for (const std::string below : {"", "/data"}) {
    const Dataset dataset = ReadDataset(tree_.path() + below);
    EXPECT_EQ(dataset.training_images, 3u);
    ASSERT_EQ(dataset.skipped.size(), 1u);
    EXPECT_THAT(dataset.skipped[0].path, HasSubstr("sideways"));
  }
}

TEST_F(DatasetTest, NoFabricIsAnError) {
  EXPECT_INPUT_ERROR(ReadDataset(tree_.path()), "has no fabric, expected data/Fabric N");
  EXPECT_INPUT_ERROR(ReadDataset(tree_.path() + "/nothing"), "is not a folder");
}

TEST_F(DatasetTest, SelectionNamesWhatIsThere) {
  for (const char* fabric : {"1", "2"})
    for (const char* sample : {"1", "2", "3"})
      for (const char* capture : {"1", "3"})
        Add(std::string("Fabric ") + fabric + "/silhouettes/Sample_" + sample + "_Capture_" +
            capture + ".jpg");
  const Dataset dataset = Read();
  EXPECT_EQ(Select(dataset, {}).size(), 12u);
  EXPECT_THAT(Found(Select(dataset, {.fabrics = {2}, .samples = {1, 3}, .captures = {3}})),
              ElementsAre("2.1.3 down", "2.3.3 down"));
  EXPECT_THAT(Found(Select(dataset, {.samples = {2}, .face = ClothFace::kUp})),
              ElementsAre("1.2.1 up", "2.2.1 up"));
  EXPECT_INPUT_ERROR(Select(dataset, {.fabrics = {3}}), "fabric: found 3, expected some of 1-2");
  EXPECT_INPUT_ERROR(Select(dataset, {.samples = {4}}), "samples: found 4, expected some of 1-3");
  EXPECT_INPUT_ERROR(Select(dataset, {.captures = {2}}), "captures: found 2, expected some of 1,3");
  EXPECT_INPUT_ERROR(Select(dataset, {.captures = {1}, .face = ClothFace::kDown}),
                     "no capture of the selection with face down");
}

TEST_F(DatasetTest, UnusableFilesAreLeftOutWithTheReason) {
  const auto image = [](int n) {
    return "data/Fabric 1/silhouettes/Sample_" + std::to_string(n) + ".jpg";
  };
  const auto mesh = [](int n) {
    return "data/Fabric 1/meshes/Sample_" + std::to_string(n) + ".obj";
  };
  for (int n : {1, 2, 3, 4, 7}) tree_.AddImage(image(n));
  tree_.AddFile(image(5), "no JPEG");
  tree_.AddImage(image(6), 125);
  tree_.AddMesh(mesh(1), true);
  tree_.AddMesh(mesh(2), false, 85 / 719.5, 5, 0, 3);
  tree_.AddMesh(mesh(7), true, 85 / 719.5, 6);
  tree_.AddFile(mesh(3), "v 0 0 0\nv 1 0");
  tree_.AddFile(mesh(4), "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1 2 3\n");
  std::vector<FileNote> skipped;
  const auto captures = KeepUsable(Read().captures, &skipped);
  EXPECT_THAT(Found(captures),
              ElementsAre("1.1.1 up mesh", "1.2.1 up mesh", "1.3.1 up", "1.4.1 up", "1.7.1 up"));
  EXPECT_EQ(captures[0].mesh_quarters, 0);
  EXPECT_EQ(captures[1].mesh_quarters, 1);
  ASSERT_EQ(skipped.size(), 5u);
  EXPECT_THAT(skipped[0].text, HasSubstr("neither JPEG nor PNG"));
  EXPECT_THAT(skipped[1].text, HasSubstr("border"));
  EXPECT_THAT(skipped[2].text, HasSubstr(".obj:2"));
  EXPECT_THAT(skipped[3].text, HasSubstr("found 1 vt for 3 v"));
  EXPECT_THAT(skipped[4].text, HasSubstr("px, expected at most 3: it belongs to another capture"));
}

TEST(IndexList, RangesAndNumbers) {
  EXPECT_THAT(ParseIndexList("1,3-5", "x"), ElementsAre(1, 3, 4, 5));
  EXPECT_THAT(ParseIndexList("7,2-3,3", "x"), ElementsAre(2, 3, 7));
  EXPECT_THAT(ParseIndexList("", "x"), IsEmpty());
  EXPECT_EQ(IndexListText({1, 3, 4, 5, 9}), "1,3-5,9");
  EXPECT_EQ(IndexListText({}), "");
  for (const char* bad : {"0", "-1", "a", "1,,2", "1-", "5-3", "1.5", "10000", "1;2", " 1"})
    EXPECT_INPUT_ERROR(ParseIndexList(bad, "samples"), "samples: found '");
}

}  // namespace
}  // namespace drape
