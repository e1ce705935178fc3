// SPDX-License-Identifier: Apache-2.0
// The loader on the published files [Gong 2024], which are read in place. The figures are of
// fabrics 1–5; a folder may hold more.
#include <gmock/gmock.h>

#include <filesystem>

#include "losses/dataset/dataset.h"

namespace drape {
namespace {

const std::vector<int> kFabrics = {1, 2, 3, 4, 5};

class CusickDataset : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(root_)) GTEST_SKIP() << "no public data set at " << root_;
  }
  const std::string root_ = DRAPE_SHARED_DIR "/cusick";
};

TEST_F(CusickDataset, HoldsFiveFabricsOfTwelveSamplesInFourCaptures) {
  const Dataset dataset = ReadDataset(root_);
  EXPECT_EQ(Select(dataset, {.fabrics = kFabrics}).size(), 5u * 12 * 4);
  EXPECT_EQ(dataset.training_images, 60u);
  for (const auto& notes : {dataset.skipped, dataset.notes}) {
    for (const FileNote& note : notes)
      EXPECT_THAT(note.path, testing::Not(testing::ContainsRegex("Fabric [1-5]/"))) << note.text;
  }
}

// Four meshes of fabric 2 are turned; that of fabric 3, sample 2, capture 1 belongs to capture 3.
TEST_F(CusickDataset, MeshesFitTheirImagesAfterAQuarterTurn) {
  std::vector<FileNote> skipped;
  const auto captures = KeepUsable(Select(ReadDataset(root_), {.fabrics = kFabrics}), &skipped);
  EXPECT_EQ(captures.size(), 240u);
  ASSERT_EQ(skipped.size(), 1u);
  EXPECT_THAT(skipped[0].path, testing::EndsWith("Fabric_3_Sample_2_Capture_1.obj"));
  EXPECT_THAT(skipped[0].text, testing::HasSubstr("belongs to another capture"));
  std::vector<std::string> turned;
  int meshes = 0;
  for (const Capture& capture : captures) {
    meshes += !capture.mesh.empty();
    if (capture.mesh_quarters == 0) continue;
    EXPECT_EQ(capture.mesh_quarters, 1) << capture.Name();
    turned.push_back(capture.Name());
  }
  EXPECT_EQ(meshes, 39);
  EXPECT_THAT(turned, testing::ElementsAre(
                          "fabric 2, sample 1, capture 1", "fabric 2, sample 1, capture 2",
                          "fabric 2, sample 2, capture 3", "fabric 2, sample 2, capture 4"));
}

TEST_F(CusickDataset, MeshesShareTheCloth) {
  const auto captures = Select(ReadDataset(root_), {.fabrics = {1, 4}, .samples = {1}});
  const Mesh first = *ReadPublishedMesh(captures[0].mesh).cloth;
  EXPECT_EQ(first.num_vertices(), 2699);
  EXPECT_NEAR(first.uv.colwise().norm().maxCoeff(), 0.15, 1e-9);
  for (const Capture& capture : captures)
    EXPECT_EQ(ReadPublishedMesh(capture.mesh).cloth->uv, first.uv) << capture.mesh;
}

}  // namespace
}  // namespace drape
