// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/runner/study.h"

#include <atomic>
#include <mutex>
#include <set>

#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

using nlohmann::json;

// A study of three cells, each of which reads the file "material".
class Studies : public FileFixture {
 protected:
  Studies() : material_(Write("material", "soft")) { MakeStudy(); }

  void MakeStudy() {
    study_ = {.name = "test", .settings = {{"mesh", "disc:100"}}};
    for (const char* name : {"c", "a", "b"})
      study_.cells.push_back(
          CheckedCell(name, {{"axis", name}}, [&] { ReadWholeFile(material_); }));
    study_.run = [this](std::size_t cell, const RunControl&) -> std::optional<json> {
      const std::scoped_lock lock(mutex_);
      ran_.insert(study_.cells[cell].name);
      if (fail_) throw IoError("out", "No space left on device");
      return json{{"text", ReadWholeFile(material_) + study_.cells[cell].name}};
    };
  }

  StudyResult Run(const std::string& share = "", bool processes = false) {
    ran_.clear();
    const StudyOptions options{
        .out = Path("out"), .share = share, .threads = 2, .processes = processes};
    return RunStudy(study_, options, {.cancel = &cancel_});
  }

  std::string material_;
  Study study_;
  bool fail_ = false;
  std::atomic<bool> cancel_ = false;
  std::mutex mutex_;
  std::set<std::string> ran_;
};

TEST_F(Studies, ListCellsInTheirOrderWithoutAFolder) {
  StudyOptions options{.out = Path("out"), .list = true};
  EXPECT_EQ(RunStudy(study_, options, {}).text, "c\na\nb\n");
  options.share = "0/2";
  EXPECT_EQ(RunStudy(study_, options, {}).text, "c\nb\n");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(Studies, SharesAreDisjointAndTogetherEverything) {
  const StudyResult first = Run("0/2");
  EXPECT_EQ(ran_, std::set<std::string>({"b", "c"}));
  EXPECT_FALSE(first.complete);
  EXPECT_EQ(first.text,
            "share 0/2: 2 of 2 cells are complete; the same command without --share gathers all "
            "shares\n");
  Run("1/2");
  EXPECT_EQ(ran_, std::set<std::string>({"a"}));
  const StudyResult all = Run();
  EXPECT_TRUE(ran_.empty());
  EXPECT_TRUE(all.complete);
  EXPECT_EQ(all.results[1]->at("text"), "softa");
}

TEST_F(Studies, NameMistakesOfShares) {
  for (const char* wrong : {"1", "/", "1/", "/2", "2/2", "3/2", "-1/2", "0/0", "1/2/3", "a/b",
                            "0/1000001", "0 /2", "0.5/2"})
    EXPECT_INPUT_ERROR(CheckShare({.share = wrong}),
                       "option 'share': found '" + std::string(wrong) + "', expected i/n");
}

TEST_F(Studies, TakeNoCellOfAnotherFileUnderTheSamePath) {
  Run();
  Write("material", "stiff");
  MakeStudy();
  EXPECT_EQ(Run().results[0]->at("text"), "stiffc");
  EXPECT_EQ(ran_.size(), 3);
}

TEST_F(Studies, TakeCellsOfTheSameFileUnderAnotherPath) {
  Run();
  material_ = Write("copy", "soft");
  MakeStudy();
  Run();
  EXPECT_TRUE(ran_.empty());
}

TEST_F(Studies, NamesAreForAPersonAlone) {
  Run();
  study_.cells[0].name = "d";
  study_.cells[0].names["file"] = "d.json";
  Run();
  EXPECT_TRUE(ran_.empty());
  study_.cells[1].name = "d";
  EXPECT_INPUT_ERROR(Run(), "cell 'd': is there twice");
}

// A run of other inputs in the same folder replaces what a finished cell had beside its result.
TEST_F(Studies, RunAgainWhatIsNoLongerWhole) {
  Run();
  study_.is_whole = [](std::size_t cell, const json& result) {
    return cell > 0 && result.contains("text");
  };
  Run();
  EXPECT_EQ(ran_, std::set<std::string>({"c"}));
}

TEST_F(Studies, TakeNoCellOfOtherSettingsOrInput) {
  Run();
  study_.settings["mesh"] = "disc:200";
  Run();
  EXPECT_EQ(ran_.size(), 3);
  study_.cells[2].input["axis"] = "d";
  Run();
  EXPECT_EQ(ran_, std::set<std::string>({"b"}));
}

TEST_F(Studies, RefuseAFileThatChangesMeanwhile) {
  Write("material", "stiff");
  EXPECT_INPUT_ERROR(Run(), "is not as it was when the study began");
  EXPECT_INPUT_ERROR(Run("", true), "is not as it was when the study began");
}

TEST_F(Studies, DoNotRememberARefusalOfTheSystem) {
  fail_ = true;
  EXPECT_IO_ERROR(Run(), "No space left");
  EXPECT_IO_ERROR(Run("", true), "No space left");
  fail_ = false;
  EXPECT_EQ(Run().results[0]->at("text"), "softc");
  EXPECT_EQ(ran_.size(), 3);
}

TEST_F(Studies, DoNotRememberThatAFileIsGone) {
  std::filesystem::remove(material_);
  study_.run = [](std::size_t, const RunControl&) -> std::optional<json> {
    return json{{"failure", "no such file"}};
  };
  EXPECT_IO_ERROR(Run(), "no such file any more");
  EXPECT_FALSE(std::filesystem::exists(Path("out/cells")));
}

// Files below its folder are its own, unless they are inputs.
TEST_F(Studies, RefuseAnInputInTheirFolderThatChangesMeanwhile) {
  std::filesystem::create_directory(Path("out"));
  material_ = Write("out/material", "soft");
  study_.cells.clear();
  MakeStudy();
  Write("out/material", "stiff");
  EXPECT_INPUT_ERROR(Run(), "is not as it was when the study began");
}

TEST_F(Studies, CountFailedCells) {
  study_.run = [](std::size_t cell, const RunControl&) -> std::optional<json> {
    if (cell == 0) return json{{"failure", "no drape"}};
    return json::object();
  };
  EXPECT_THAT(Run("0/1").text,
              ::testing::HasSubstr("3 of 3 cells are complete, of which 1 failed"));
}

TEST_F(Studies, KeepWhatEndedBeforeTheyWereCancelled) {
  const auto run = study_.run;
  study_.run = [&](std::size_t cell, const RunControl& control) -> std::optional<json> {
    if (cell == 1) cancel_ = true;
    return cell == 1 ? std::nullopt : run(cell, control);
  };
  StudyOptions options{.out = Path("out")};
  const StudyResult stopped = RunStudy(study_, options, {.cancel = &cancel_});
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_FALSE(stopped.complete);
  EXPECT_TRUE(stopped.results[0].has_value());
  EXPECT_FALSE(stopped.results[1].has_value());
  cancel_ = false;
  study_.run = run;
  Run();
  EXPECT_EQ(ran_, std::set<std::string>({"a", "b"}));
}

TEST_F(Studies, MeasureTheMemoryOfProcesses) {
#ifdef __clang__
  GTEST_SKIP() << "the sanitizers that Clang builds with have memory of their own";
#endif
  study_.run = [](std::size_t cell, const RunControl&) -> std::optional<json> {
    const std::vector<char> megabytes(cell == 0 ? 100'000'000 : 1, 'x');
    return json{{"last", megabytes.back()}};
  };
  const StudyResult result = Run("", true);
  EXPECT_NEAR(result.results[0]->at("peak_mb").get<double>(), 100.0, 10.0);
  EXPECT_LT(result.results[1]->at("peak_mb").get<double>(), 10.0);
}

// What several cells share is made in the process of the study, for the cells that run.
TEST_F(Studies, PrepareTheCellsThatRun) {
  std::vector<std::string> shared;
  study_.prepare = [&](std::size_t cell, const RunControl&) {
    shared.push_back("for " + study_.cells[cell].name);
    return true;
  };
  study_.run = [&](std::size_t, const RunControl&) -> std::optional<json> {
    return json{{"last", shared.back()}};
  };
  Run("0/2", true);
  EXPECT_EQ(shared, std::vector<std::string>({"for c", "for b"}));
  const StudyResult result = Run("", true);
  EXPECT_EQ(shared.back(), "for a");
  EXPECT_EQ(shared.size(), 3);
  EXPECT_EQ(result.results[1]->at("last"), "for a");
  study_.settings["mesh"] = "disc:200";
  study_.prepare = [&](std::size_t cell, const RunControl&) {
    cancel_ = cell == 1;
    return !cancel_;
  };
  const StudyResult stopped = Run("", true);
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_TRUE(stopped.results[0].has_value());
  EXPECT_FALSE(stopped.results[1].has_value());
}

// What a cell needs may be a study of its own, with processes as well.
TEST_F(Studies, PrepareByAStudy) {
  Study needed = study_;
  needed.name = "needed";
  needed.cells.resize(1);
  std::string found;
  study_.prepare = [&](std::size_t, const RunControl& control) {
    const StudyResult result =
        RunStudy(needed, {.out = Path("out"), .processes = true}, {.cancel = control.cancel});
    found = result.results[0]->at("text");
    return true;
  };
  study_.run = [&](std::size_t, const RunControl&) -> std::optional<json> {
    return json{{"needed", found}};
  };
  EXPECT_EQ(Run("", true).results[2]->at("needed"), "softc");
}

TEST_F(Studies, RefuseDamagedAndExchangedCells) {
  Run();
  const std::string a = Path("out/cells/" + CellId(study_, 0) + ".json"),
                    b = Path("out/cells/" + CellId(study_, 1) + ".json");
  const std::string whole = Read(a);
  std::filesystem::copy_file(b, a, std::filesystem::copy_options::overwrite_existing);
  EXPECT_INPUT_ERROR(Run(), "expected that of the cell of this name");
  Write("out/cells/" + CellId(study_, 0) + ".json", whole.substr(0, whole.size() / 2));
  EXPECT_INPUT_ERROR(Run(), a);
}

}  // namespace
}  // namespace drape
