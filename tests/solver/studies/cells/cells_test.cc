// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>

#include "solver/studies/cells/cell_folder.h"
#include "solver/studies/cells/share.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

TEST(Shares, AreDisjointAndTogetherEverything) {
  for (const std::size_t count : {1u, 2u, 3u, 7u}) {
    std::multiset<std::size_t> seen;
    for (std::size_t i = 0; i < count; ++i) {
      const CellChoice choice{.share = std::to_string(i) + "/" + std::to_string(count)};
      for (std::size_t k = 0; k < 10; ++k)
        if (choice.ParseShare()->Has(k)) seen.insert(k);
    }
    EXPECT_EQ(seen, std::multiset<std::size_t>({0, 1, 2, 3, 4, 5, 6, 7, 8, 9})) << count;
  }
}

TEST(Shares, ListsAreInTheOrderOfTheCells) {
  const std::vector<std::string> cells = {"c", "a", "b"};
  EXPECT_EQ(ListText(cells, std::nullopt), "c\na\nb\n");
  EXPECT_EQ(ListText(cells, Share{0, 2}), "c\nb\n");
  EXPECT_EQ(ListText(cells, Share{5, 6}), "");
}

TEST(Shares, MistakesAreNamed) {
  EXPECT_FALSE(CellChoice().ParseShare().has_value());
  for (const char* wrong : {"1", "/", "1/", "/2", "2/2", "3/2", "-1/2", "0/0", "1/2/3", "a/b",
                            "0/1000001", "0 /2", "0.5/2"})
    EXPECT_INPUT_ERROR(CellChoice{.share = wrong}.ParseShare(),
                       "option 'share': found '" + std::string(wrong) + "', expected i/n");
}

class CellFolders : public FileFixture {};

TEST_F(CellFolders, GiveBackWhatWasWritten) {
  CellFolder cells(Path("out/cells"), "mesh=disc:100");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  EXPECT_FALSE(cells.continues());
  cells.Create();
  cells.Write("a b/\"c\"", "1,2\n");
  const CellFolder again(Path("out/cells"), "mesh=disc:100");
  EXPECT_TRUE(again.continues());
  EXPECT_EQ(again.Read("a b/\"c\""), "1,2\n");
  EXPECT_EQ(again.Read("a b"), std::nullopt);
}

TEST_F(CellFolders, RefuseWhatIsNotTheirs) {
  CellFolder cells(Path("cells"), "mesh=disc:100");
  cells.Create();
  cells.Write("a", "1");
  EXPECT_INPUT_ERROR(CellFolder(Path("cells"), "mesh=disc:200"), "made with other settings");
  const CellFolder again(Path("cells"), "mesh=disc:100");
  std::filesystem::copy_file(again.Path("a"), again.Path("b"));
  EXPECT_INPUT_ERROR(again.Read("b"), "key 'cell': found \"a\", expected \"b\"");
  std::string text = Read(again.Path("a"));
  Write(std::filesystem::relative(again.Path("a"), Path("")).string(),
        text.replace(text.find("\"1\""), 3, "\"2\""));
  EXPECT_INPUT_ERROR(again.Read("a"), "is damaged or was altered");
  Write("file", "");
  CellFolder blocked(Path("file/cells"), "");
  EXPECT_INPUT_ERROR(blocked.Create(), "file/cells: cannot make the folder");
}

}  // namespace
}  // namespace drape
