// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_input.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "physics/util/errors.h"
#include "tests/losses/temp_folder.h"

namespace drape {
namespace {

class ExpandImagesTest : public testing::Test {
 protected:
  ExpandImagesTest() {
    for (const std::string name : {"b.jpg", "a.png", "c.JPEG", "notes.txt"})
      WriteAll(folder_ / name, {1});
  }
  std::vector<std::string> Paths(const std::vector<std::string>& names) const {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(folder_ / name);
    return paths;
  }
  const TempFolder folder_;
};

TEST_F(ExpandImagesTest, Lists) {
  EXPECT_EQ(ExpandImages((folder_ / "b.jpg") + "," + (folder_ / "a.png")),
            Paths({"b.jpg", "a.png"}));
}
TEST_F(ExpandImagesTest, Folders) {
  EXPECT_EQ(ExpandImages(folder_.path()), Paths({"a.png", "b.jpg", "c.JPEG"}));
}
TEST_F(ExpandImagesTest, Patterns) {
  EXPECT_EQ(ExpandImages(folder_ / "*.[jp]*g"), Paths({"a.png", "b.jpg"}));
}
TEST_F(ExpandImagesTest, NothingIsAnError) {
  std::filesystem::create_directory(folder_ / "none");
  for (const std::string& text : {folder_ / "absent.png", folder_ / "*.gif", folder_ / "none",
                                  (folder_ / "a.png") + "," + (folder_ / "absent.png")}) {
    EXPECT_THROW(ExpandImages(text), InputError) << text;
  }
}

TEST(SearchMeshes, AtMostDoubleUpToTheMesh) {
  FitSpec spec;
  std::vector<std::string> notes;
  EXPECT_EQ(SearchMeshes(spec, {}, &notes), std::vector<std::string>{"disc:600"});
  spec.mesh = "disc:2400";
  EXPECT_EQ(SearchMeshes(spec, {}, &notes).size(), 2u);
  spec.mesh = "disc:4800";
  const std::vector<std::string> meshes = SearchMeshes(spec, {}, &notes);
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_THAT(meshes[1], testing::StartsWith("disc:1"));
  EXPECT_THAT(meshes[2], testing::StartsWith("disc:2"));
  for (const char* mesh : {"disc:600", "disc:800", "disc:300"}) {
    spec.mesh = mesh;
    EXPECT_TRUE(SearchMeshes(spec, {}, &notes).empty()) << mesh;
  }
  EXPECT_TRUE(notes.empty());
  spec.mesh = "disc:2400,radius=0.2";
  EXPECT_TRUE(SearchMeshes(spec, {}, &notes).empty());
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], testing::HasSubstr("another cloth"));
}

}  // namespace
}  // namespace drape
