// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/provenance.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/math/sha256.h"
#include "tests/physics/file_fixture.h"
#include "tools/cli/option_table.h"

namespace drape {
namespace {

using nlohmann::json;
using testing::ElementsAre;

// The examples of FIPS 180-4 (NIST, "Examples with intermediate values", SHA-256), and none.
TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(Sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmno"
                   "ijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu"),
            "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(Sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(MakeUtf8, KeepsTextAndSpellsOtherBytes) {
  EXPECT_EQ(MakeUtf8("a \"b\"\n\u00e4"), "a \"b\"\n\u00e4");
  EXPECT_EQ(MakeUtf8("a\xff\xc3"), "a\\xff\\xc3");
}

class RepetitionTest : public FileFixture {
 protected:
  RepetitionTest() {
    input_ = Write("cloth.obj", "a mesh");
    const json input = {{"path", input_}, {"bytes", 6}, {"sha256", Sha256("a mesh")}};
    summary_ = {{"outcome", "done"},
                {"provenance",
                 {{"program", "t"},
                  {"working_directory", "/somewhere"},
                  {"options",
                   {{"mesh", "in/a.obj"},
                    {"count", 3},
                    {"unset", 0},
                    {"factors", {0.1, 1e-300}},
                    {"out", "old"},
                    {"table", "old.md"},
                    {"again", true}}},
                  {"operands", json::array({"a.png", "b.png"})},
                  {"given", json::array({"count"})},
                  {"inputs", json::array({input})}}}};
  }
  json& Provenance() { return summary_["provenance"]; }
  StoredRun Run() { return ReadStoredRun(JsonInput(Provenance(), "s.json"), "s.json", "t"); }
  std::string AddSummary() const {
    std::filesystem::create_directories(Path("folder"));
    return Write("folder/summary.json", summary_.dump());
  }
  ParseOutcome Parse(std::vector<std::string> words) {
    words.insert(words.begin(), {"t", "--config=" + AddSummary()});
    out_ = md_ = "";
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    return ParseCommandLine(table_, static_cast<int>(arguments.size()), arguments.data(), &run_);
  }

  std::string input_;
  json summary_;
  std::shared_ptr<const StoredRun> run_;
  std::string mesh_ = "disc:5", out_, md_;
  int count_ = 1, unset_ = 0;
  bool again_ = false;
  std::vector<double> factors_ = {1, 2};
  std::vector<std::string> operands_;
  std::set<std::string> given_;
  const OptionTable table_ = {
      .tool = "t",
      .summary = "s",
      .example = "e",
      .notes = "n",
      .options = {{.key = "mesh", .value = &mesh_, .doc = "d", .is_path = true, .words = {"disc:"}},
                  {.key = "count", .value = &count_, .doc = "d"},
                  {.key = "unset", .value = &unset_, .doc = "d", .range = {.least = 1}},
                  {.key = "factors", .value = &factors_, .doc = "d"},
                  {.key = "out",
                   .value = &out_,
                   .doc = "d",
                   .is_path = true,
                   .required = true,
                   .repeated = false},
                  {.key = "table", .value = &md_, .doc = "d", .is_path = true, .repeated = false},
                  {.key = "again", .value = &again_, .doc = "d", .repeated = false}},
      .operands = &operands_,
      .given = &given_};
};

// `unset` is 0 by default, which no user may give; `count` is what the user had given.
TEST_F(RepetitionTest, TakesOptionsAsTheyWere) {
  ASSERT_EQ(Parse({"--out=new", "--table=new.md"}), ParseOutcome::kRun);
  EXPECT_EQ(mesh_, "in/a.obj");  // from the working directory, not from the summary's folder
  EXPECT_EQ(count_, 3);
  EXPECT_THAT(factors_, ElementsAre(0.1, 1e-300));
  EXPECT_THAT(operands_, ElementsAre("a.png", "b.png"));
  EXPECT_THAT(given_, ElementsAre("count", "out", "table"));
  EXPECT_FALSE(again_);
  ASSERT_NE(run_, nullptr);
  EXPECT_FALSE(run_->is_changed);
}

TEST_F(RepetitionTest, NeedsAnOutputFolderOfItsOwn) {
  EXPECT_INPUT_ERROR(Parse({"--table=new.md"}), "option 'out'");
}

TEST_F(RepetitionTest, OtherValuesMakeAnotherRun) {
  const auto is_changed = [&](const std::string& word) {
    EXPECT_EQ(Parse({"--out=new", "--table=new.md", word}), ParseOutcome::kRun);
    return run_->is_changed;
  };
  EXPECT_FALSE(is_changed("--count=3"));
  EXPECT_TRUE(is_changed("--count=4"));
  EXPECT_FALSE(is_changed("--again"));
  EXPECT_TRUE(is_changed("c.png"));
  EXPECT_THAT(operands_, ElementsAre("c.png"));
}

TEST_F(RepetitionTest, OtherFilesAreRefused) {
  CheckInputs(Run());
  Write("cloth.obj", "A mesh");
  EXPECT_INPUT_ERROR(CheckInputs(Run()), "cloth.obj: is an input of the run of s.json");
  std::filesystem::remove(input_);
  EXPECT_INPUT_ERROR(CheckInputs(Run()),
                     "cloth.obj: no such file: it is an input of the run of s.json");
  Provenance()["inputs"][0]["path"] = "cloth.obj";
  EXPECT_INPUT_ERROR(CheckInputs(Run()), "is an input of the run of s.json in /somewhere");
}

TEST_F(RepetitionTest, SummariesOfOtherRunsAreRefused) {
  const json good = summary_;
  const auto with = [&](const char* pointer, const json& value) {
    summary_ = good;
    summary_[json::json_pointer(pointer)] = value;
    Parse({"--out=new", "--table=new.md"});
  };
  EXPECT_INPUT_ERROR(with("/provenance/program", "drape_x"), "found \"drape_x\", expected \"t\"");
  EXPECT_INPUT_ERROR(with("/provenance", 3), "expected an object");
  EXPECT_INPUT_ERROR(with("/provenance/options/new", 3), "unknown key 'provenance.options.new'");
  EXPECT_INPUT_ERROR(with("/provenance/options/count", "3"),
                     "key 'provenance.options.count': found \"3\", expected a number");
  EXPECT_INPUT_ERROR(with("/provenance/inputs/0/bytes", -1), "bytes");
  summary_ = good;
  Provenance().erase("options");
  EXPECT_INPUT_ERROR(Parse({"--out=new"}), "is of a part of a run of t");
}

}  // namespace
}  // namespace drape
