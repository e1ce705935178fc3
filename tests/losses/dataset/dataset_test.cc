// SPDX-License-Identifier: Apache-2.0
// Tests each irregularity of the published layout [MODEL, M52] on a small tree of files.
#include "losses/dataset/dataset.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "losses/image/segmentation.h"
#include "losses/silhouette/silhouette.h"
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

// Two fabrics of six samples, four captures each.
Dataset TwoFabrics() {
  Dataset dataset;
  for (int fabric : {1, 2})
    for (int sample = 1; sample <= 6; ++sample)
      for (int capture = 1; capture <= 4; ++capture)
        dataset.captures.push_back({fabric, sample, capture, ClothFace::kUp, "image", ""});
  return dataset;
}

std::set<std::pair<int, int>> ListSamples(const std::vector<Capture>& captures) {
  std::set<std::pair<int, int>> samples;
  for (const Capture& c : captures) samples.insert({c.fabric, c.sample});
  return samples;
}

class SplitFile : public FileFixture {};

TEST_F(SplitFile, KeepsSamplesTogetherAndSelectsInEachFabric) {
  const Split split = SplitBySample(TwoFabrics().captures, 2, 5);
  EXPECT_EQ(split.train.size(), 2u * 2 * 4);
  EXPECT_EQ(split.held_out.size(), 2u * 4 * 4);
  const auto train = ListSamples(split.train), held_out = ListSamples(split.held_out);
  EXPECT_EQ(train.size(), 4u);
  EXPECT_EQ(held_out.size(), 8u);
  EXPECT_EQ(std::count_if(train.begin(), train.end(), [](auto s) { return s.first == 1; }), 2);
  for (const auto& sample : train) EXPECT_FALSE(held_out.contains(sample));
}

TEST_F(SplitFile, FollowsFromTheSeedAlone) {
  const auto captures = TwoFabrics().captures;
  EXPECT_EQ(ListSamples(SplitBySample(captures, 3, 5).train),
            ListSamples(SplitBySample(captures, 3, 5).train));
  std::set<std::set<std::pair<int, int>>> selected;
  std::set<std::pair<int, int>> ever;
  for (int seed = 0; seed < 40; ++seed) {
    const auto train = ListSamples(SplitBySample(captures, 1, seed).train);
    selected.insert(train);
    ever.insert(train.begin(), train.end());
  }
  EXPECT_GT(selected.size(), 15u);  // of 36
  EXPECT_EQ(ever.size(), 12u);
  EXPECT_EQ(ListSamples(SplitBySample(captures, 2, 1).train),
            (std::set<std::pair<int, int>>{{1, 1}, {1, 2}, {2, 2}, {2, 3}}));
}

TEST_F(SplitFile, NeedsASampleToHoldOut) {
  EXPECT_INPUT_ERROR(SplitBySample(TwoFabrics().captures, 6, 1),
                     "found 6 training samples, expected fewer than the 6 of fabric 1");
}

TEST_F(SplitFile, IsReadBackAsItWasWritten) {
  const Dataset dataset = TwoFabrics();
  const Split split = SplitBySample(dataset.captures, 2, 123456789012345ull);
  WriteSplit(Path("split.json"), split);
  const Split back = ReadSplit(Path("split.json"), dataset);
  EXPECT_EQ(back.seed, split.seed);
  ASSERT_EQ(back.train.size(), split.train.size());
  for (size_t i = 0; i < split.train.size(); ++i)
    EXPECT_EQ(back.train[i].Name(), split.train[i].Name());
  EXPECT_EQ(ListSamples(back.held_out), ListSamples(split.held_out));
  EXPECT_EQ(back.train[0].image, "image");
}

TEST_F(SplitFile, MistakesAreNamed) {
  const Dataset dataset = TwoFabrics();
  const auto read = [&](const std::string& seed, const std::string& train,
                        const std::string& held_out) {
    return ReadSplit(
        Write("s.json", R"({"format": "drapefit-split", "seed": )" + seed + R"(, "train": )" +
                            train + R"(, "held_out": )" + held_out + "}"),
        dataset);
  };
  EXPECT_EQ(read("1", "[[1,1,1]]", "[[1,2,1]]").train.size(), 1u);
  EXPECT_INPUT_ERROR(read("-1", "[]", "[]"), "key 'seed': found -1");
  EXPECT_INPUT_ERROR(read("1", "[[1,1]]", "[]"), "key 'train[0]'");
  EXPECT_INPUT_ERROR(read("1", "[[3,1,1]]", "[]"), "key 'train[0]': the data set lacks");
  EXPECT_INPUT_ERROR(read("1", "[[1,1,1]]", "[[1,1,2]]"),
                     "the sample of fabric 1, sample 1, capture 2 is on both sides");
  EXPECT_INPUT_ERROR(ReadSplit(Write("t.json", R"({"format": "other"})"), dataset), "format");
}

TEST(PublishedMesh, TheFillerVtIsDropped) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true));
  EXPECT_EQ(mesh.surface.x.size(), 3 * 121);
  EXPECT_EQ(mesh.surface.triangles.size(), 120u);
  ASSERT_TRUE(mesh.cloth.has_value());
  EXPECT_NEAR(mesh.cloth->uv(0, 1), 0.15,
              1e-6);  // with an offset of one it would be 0, as at the centre
  EXPECT_NEAR(mesh.cloth->uv.col(31).y(), 0.15, 1e-6);
}

TEST(PublishedMesh, OtherTopologiesHaveNoCloth) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", false));
  EXPECT_EQ(mesh.surface.triangles.size(), 90u);
  EXPECT_FALSE(mesh.cloth.has_value());
}

TEST(PublishedMesh, ACountOfVtThatFitsNothingIsAnError) {
  const SyntheticDataset tree;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n";
  EXPECT_INPUT_ERROR(
      ReadPublishedMesh(tree.AddFile("a.obj", triangle + "vt 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n")),
      "found 4 vt for 3 v");
  EXPECT_TRUE(
      ReadPublishedMesh(tree.AddFile("b.obj", triangle + "vt 0 0\nvt 1 0\nvt 0 1\n")).cloth);
  EXPECT_INPUT_ERROR(ReadPublishedMesh(tree.AddFile("c.obj", "v 0 0 0\n")), "no faces");
}

TEST(QuarterTurn, IsFoundAgainstTheImage) {
  const SyntheticDataset tree;
  const GrayImage image = ReadSilhouette(tree.AddImage("a.jpg", 85, 5, 0.4)).image;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const auto mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true, 85 / 719.5, 5, 0.4, quarters));
    const auto turn = FindQuarterTurn(mesh.surface, image, Camera());
    ASSERT_TRUE(turn.has_value());
    EXPECT_EQ(turn->quarters, (4 - quarters) % 4);
    EXPECT_LT(turn->rms, 0.5);
    ObjSurface turned = mesh.surface;
    turned.x = TurnedAboutZ(turned.x, turn->quarters * M_PI / 2);
    EXPECT_EQ(FindQuarterTurn(turned, image, Camera())->quarters, 0);
  }
}

TEST(TurnedAboutZ, MirrorsFirst) {
  const Eigen::VectorXd turned = TurnedAboutZ(Eigen::Vector3d(1, 2, 3), M_PI / 2, true);
  EXPECT_NEAR((turned - Eigen::Vector3d(2, 1, 3)).norm(), 0, 1e-15);
}

TEST(Rasterize, ASurfaceEqualsItsMesh) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true));
  EXPECT_EQ(Rasterize(mesh.surface, Camera(), 2).coverage,
            Rasterize(*mesh.cloth, mesh.surface.x, Camera(), 2).coverage);
}

}  // namespace
}  // namespace drape
