// SPDX-License-Identifier: Apache-2.0
// A run is repeated from its summary alone, to the same bytes.
#include "tests/tools/hostile_fixture.h"

namespace drape::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RepeatTest : public Hostile {
 protected:
  using Files = std::map<std::string, std::string>;

  RepeatTest() {
    Copy(kWool, "wool.json");
    Copy(kWaves, "waves.json");
  }

  // The same but for what belongs to one run: its provenance and the seconds that it took.
  static Json WithoutRun(const Json& value) {
    if (!value.is_structured()) return value;
    Json kept = value.is_object() ? Json::object() : Json::array();
    for (const auto& [key, item] : value.items()) {
      if (value.is_array())
        kept.push_back(WithoutRun(item));
      else if (key != "provenance" && key != "seconds")
        kept[key] = WithoutRun(item);
    }
    return kept;
  }

  // All files below a folder, but logs, as README of the tools says that they are compared.
  Files ResultsIn(const std::string& folder) const {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(Path(folder))) {
      const std::string name = fs::relative(entry.path(), Path(folder));
      if (!entry.is_regular_file() || name.ends_with(".log")) continue;
      files[name] = Read(entry.path());
      if (name.ends_with(".json")) files[name] = WithoutRun(Json::parse(files[name])).dump();
    }
    return files;
  }

  void ExpectSameFiles(const std::string& a, const std::string& b) const {
    const Files of_a = ResultsIn(a), of_b = ResultsIn(b);
    for (const auto& [name, content] : of_a) {
      ASSERT_TRUE(of_b.contains(name)) << name;
      EXPECT_TRUE(of_b.at(name) == content) << name;
    }
    EXPECT_EQ(of_a.size(), of_b.size());
  }

  void ExpectRepeats(const std::string& program, const std::vector<std::string>& options) const {
    std::vector<std::string> first = options;
    first.push_back("--out=old");
    ASSERT_EQ(Run(program, first).exit_code, 0);
    const ProcessResult again = Run(program, {"--config=old/summary.json", "--out=new"});
    ASSERT_EQ(again.exit_code, 0) << again.err;
    if (kSlowdown == 1.0) {  // slower, it prints its progress
      EXPECT_EQ(again.err, "");
    }
    ExpectSameFiles("old", "new");
    const Json old = Provenance("old/summary.json"), repeated = Provenance("new/summary.json");
    Json options_of_old = old.at("options"), options_of_new = repeated.at("options");
    options_of_old.erase("out");
    options_of_new.erase("out");
    EXPECT_EQ(options_of_old, options_of_new);
    EXPECT_EQ(old.at("inputs"), repeated.at("inputs"));
    EXPECT_EQ(old.at("build"), repeated.at("build"));
  }

  Json Provenance(const std::string& file) const { return ReadJson(Path(file)).at("provenance"); }

  static std::vector<std::string> ListPaths(const Json& files) {
    std::vector<std::string> paths;
    for (const Json& file : files) paths.push_back(file.at("path"));
    return paths;
  }

  // Two steps of a small drape in "old".
  void Simulate() const {
    ASSERT_EQ(Run("simulate", {"--mesh=disc:100", "--fabric=wool.json", "--start=waves.json",
                               "--steps=2", "--time_step=0.1", "--out=old"})
                  .exit_code,
              0);
  }
  ProcessResult Repeat(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options = {"--config=old/summary.json", "--out=new"};
    options.insert(options.end(), more.begin(), more.end());
    return Run("simulate", options);
  }
};

TEST_F(RepeatTest, Simulate) {
  ExpectRepeats("simulate", {"--mesh=disc:100", "--fabric=wool.json", "--start=waves.json",
                             "--steps=3", "--solve=hybrid", "--dump_steps=1,2"});
}

TEST_F(RepeatTest, Fit) {
  std::vector<std::string> options = FitOptions(AddSilhouette("drape.png"));
  options.pop_back();  // --out
  options.push_back("--model=bayes");
  options.push_back("--posterior_iterations=1");
  options.push_back("--posterior_samples=2");
  ExpectRepeats("fit", options);
  EXPECT_THAT(ListPaths(Provenance("old/summary.json")["inputs"]),
              testing::ElementsAre(kWool, "drape.png"));
}

TEST_F(RepeatTest, Predict) {
  ExpectRepeats("predict",
                {"--mesh=disc:100", "--fabric=wool.json", "--draws=4", "--steps=20", "--seed=7"});
}

TEST_F(RepeatTest, Equilibria) {
  ExpectRepeats("equilibria",
                {"--mesh=disc:100", "--fabric=wool.json", "--samples=2", "--steps=20"});
}

// Its results are files that options name.
TEST_F(RepeatTest, Metrics) {
  AddSilhouette("drape.png");
  ASSERT_EQ(Run("metrics", {"drape.png", "--centre=outline", "--out=old.json", "--csv=old.csv",
                            "--overlay=old.png"})
                .exit_code,
            0);
  const ProcessResult again =
      Run("metrics", {"--config=old.json", "--out=new.json", "--csv=new.csv", "--overlay=new.png"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(Read(Path("old.csv")), Read(Path("new.csv")));
  EXPECT_TRUE(Read(Path("old.png")) == Read(Path("new.png")));
  EXPECT_EQ(WithoutRun(ReadJson(Path("old.json"))), WithoutRun(ReadJson(Path("new.json"))));
  EXPECT_EQ(Provenance("new.json").at("operands"), Json::array({"drape.png"}));
}

// A repetition has all that another one needs, and a config need not be there any more.
TEST_F(RepeatTest, ARepetitionIsRepeated) {
  fs::create_directories(Path("in"));
  Write("in/config.json", R"({"mesh": "disc:100", "fabric": "../wool.json", "steps": 2})");
  ASSERT_EQ(Run("simulate", {"--config=in/config.json", "--out=first"}).exit_code, 0);
  EXPECT_THAT(ListPaths(Provenance("first/summary.json")["configs"]),
              testing::ElementsAre("in/config.json"));
  fs::remove(Path("in/config.json"));
  ASSERT_EQ(Run("simulate", {"--config=first/summary.json", "--out=old"}).exit_code, 0);
  ASSERT_EQ(Repeat().exit_code, 0);
  ExpectSameFiles("first", "new");
}

TEST_F(RepeatTest, OtherInputsAreRefusedBeforeAnythingIsWritten) {
  Simulate();
  const std::string waves = Read(Path("waves.json"));
  Write("waves.json", waves + " ");
  ExpectRefused(Repeat(), "waves.json: is an input of the run of old/summary.json");
  fs::remove(Path("waves.json"));
  ExpectRefused(Repeat(),
                "waves.json: no such file: it is an input of the run of old/summary.json");
  EXPECT_FALSE(fs::exists(Path("new")));
  Write("waves.json", waves);
  EXPECT_EQ(Repeat().exit_code, 0);
}

TEST_F(RepeatTest, AFileMoreInAFolderIsRefused) {
  fs::create_directories(Path("in"));
  AddSilhouette("in/a.png");
  AddSilhouette("in/b.png");
  ASSERT_EQ(Run("metrics", {"in", "--out=old.json"}).exit_code, 0);
  fs::copy(Path("in/a.png"), Path("in/c.png"));
  ExpectRefused(Run("metrics", {"--config=old.json", "--out=new.json"}),
                "in/c.png: was read, and the run of old.json did not read it");
  EXPECT_FALSE(fs::exists(Path("new.json")));
}

TEST_F(RepeatTest, AnotherFolderIsNamed) {
  Simulate();
  fs::create_directories(Path("other"));
  ProcessLimits limits;
  limits.folder = Path("other");
  const std::vector<std::string> command = {std::string(DRAPE_BIN_DIR) + "/drape_simulate",
                                            "--config=../old/summary.json", "--out=new"};
  ExpectRefused(RunProcess(command, limits), "is an input of the run of ../old/summary.json in " +
                                                 fs::path(Path("")).parent_path().string() + ", ");
  fs::copy(Path("wool.json"), Path("other/wool.json"));
  fs::copy(Path("waves.json"), Path("other/waves.json"));
  ASSERT_EQ(RunProcess(command, limits).exit_code, 0);
  ExpectSameFiles("old", "other/new");
}

TEST_F(RepeatTest, OptionsOfTheCommandLineMakeAnotherRun) {
  Simulate();
  Copy(kConfigs + "fabrics/synthetic_felt.json", "felt.json");
  ASSERT_EQ(Repeat({"--fabric=felt.json"}).exit_code, 0);
  EXPECT_THAT(ListPaths(Provenance("new/summary.json")["inputs"]),
              testing::ElementsAre("felt.json", "waves.json"));
  Write("waves.json", Read(Path("waves.json")) + " ");
  EXPECT_EQ(Repeat({"--fabric=felt.json"}).exit_code, 0);
  ExpectRefused(Repeat(), "waves.json: is an input of the run");
}

// Results beside inputs are inputs only where an option names them.
TEST_F(RepeatTest, InputsMayLieInTheOutputFolder) {
  ASSERT_EQ(
      Run("simulate", {"--mesh=disc:100", "--fabric=wool.json", "--steps=2", "--out=."}).exit_code,
      0);
  EXPECT_THAT(ListPaths(Provenance("summary.json")["inputs"]), testing::ElementsAre("wool.json"));
  const ProcessResult again = Run("simulate", {"--config=summary.json", "--out=new"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(Read(Path("drape.obj")), Read(Path("new/drape.obj")));
}

// What --accuracy has chosen is recorded.
TEST_F(RepeatTest, ChoicesAreRecorded) {
  ExpectRepeats("simulate", {"--accuracy=fast", "--fabric=wool.json"});
  const Json summary = ReadJson(Path("old/summary.json"));
  EXPECT_EQ(summary["provenance"]["options"]["mesh"], summary["mesh"]["name"]);
}

TEST_F(RepeatTest, AnotherBuildIsSaid) {
  Simulate();
  Json summary = ReadJson(Path("old/summary.json"));
  summary["provenance"]["build"]["commit"] = "0000000";
  Write("old/summary.json", summary.dump());
  const ProcessResult again = Repeat();
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, HasSubstr("note: old/summary.json is of another build"));
}

TEST_F(RepeatTest, CommandLinesMayHoldAnything) {
  const std::string name = "a \"b\" 'c'\n$(touch planted) \u00e4.json";
  fs::copy(Path("wool.json"), Path(name));
  const std::vector<std::string> options = {"--mesh=disc:100", "--fabric=" + name, "--steps=2",
                                            "--out=old"};
  ASSERT_EQ(Run("simulate", options).exit_code, 0);
  const Json run = Provenance("old/summary.json");
  EXPECT_EQ(run.at("command").at(2), "--fabric=" + name);
  ASSERT_EQ(Repeat().exit_code, 0);
  ExpectSameFiles("old", "new");
}

TEST_F(RepeatTest, AResumedRun) {
  const std::string image = AddSilhouette("drape.png");
  std::vector<std::string> options = FitOptions(image);
  ASSERT_EQ(Run("fit", options).exit_code, 0);
  options.push_back("--resume");
  ASSERT_EQ(Run("fit", options).exit_code, 0);
  ASSERT_EQ(Run("fit", {"--config=fit/summary.json", "--out=new"}).exit_code, 0);
  ExpectSameFiles("fit", "new");
}

}  // namespace
}  // namespace drape::test
