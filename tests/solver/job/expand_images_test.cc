// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>

#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
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

}  // namespace
}  // namespace drape
