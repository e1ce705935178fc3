// SPDX-License-Identifier: Apache-2.0
// The real programs with names, files and folders that are meant to do harm.
#include "tests/tools/hostile_fixture.h"
#include "tools/cli/output_folder.h"

namespace drape::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// A name that a shell or matplotlib would take for more than text, were it to reach one as it is.
const char* const kPlanted[] = {"a`touch PWNED_backtick`b q\n!touch PWNED_newline\n",
                                "'.system('touch PWNED_quote').'"
                                "\".system(\"touch PWNED_double\").\"@x^{2}_%s%d\\"};

class PlantedNames : public Hostile {
 protected:
  PlantedNames() {
    Write(".gnuplot", "!touch PWNED_home\n");
    for (const char* name : kPlanted) names_.push_back(Copy(kWool, std::string(name) + ".json"));
  }

  void RunPlanted(const std::string& program, const std::vector<std::string>& options) {
    const ProcessResult result =
        Run(program, options,
            {.environment = {{"HOME", Path("")}, {"LC_ALL", "de_DE.UTF-8"}, {"GNUTERM", "x11"}}});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, Not(HasSubstr("no pictures"))) << result.out;
    EXPECT_FALSE(HasControls(result.out + result.err)) << result.out << result.err;
    for (const auto& entry : std::filesystem::directory_iterator(Path("")))
      EXPECT_THAT(entry.path().filename().string(), Not(testing::StartsWith("PWNED")));
  }

  std::vector<std::string> names_;
};

TEST_F(PlantedNames, RunNoCommandInABenchmark) {
  std::string materials;
  for (const std::string& name : names_) materials += (materials.empty() ? "" : ",") + name;
  RunPlanted("bench",
             {"--work=forward", "--start=" + kWaves, "--fabric=" + materials,
              "--mesh=disc:100,disc:150", "--solve=hybrid", "--time_step=0.2", "--relax_time=10",
              "--branch_mm=100", "--reference=disc:200,disc:300", "--reference_relax_mesh=disc:100",
              "--run_seconds=0", "--repeats=1", "--out=bench"});
  EXPECT_GT(Read(Path("bench/growth.png")).size(), 1000u);
  EXPECT_GT(Read(Path("bench/growth.svg")).size(), 1000u);
}

TEST_F(PlantedNames, RunNoCommandInOtherStudies) {
  for (const std::string& name : names_) {
    RunPlanted("gradients", {"--mesh=disc:100", "--fabric=" + name, "--horizons=1",
                             "--time_steps=0.1", "--fold_starts=0", "--out=gradients"});
    RunPlanted("stability",
               {"--mesh=disc:100", "--fabric=" + name, "--start=" + Copy(kWaves, name + "2"),
                "--maps=step time_step=0.1/0.5 stretch=1/2", "--damping_time_step=0.1",
                "--duration=1", "--out=stability"});
  }
  RunPlanted("equilibria", {"--mesh=disc:100", "--fabric=" + names_[0], "--samples=1", "--steps=40",
                            "--time_step=0.1", "--out=equilibria"});
}

TEST_F(PlantedNames, RunNoCommandInFits) {
  const std::string silhouette = AddSilhouette("plain.png");
  for (const std::string& name : names_) {
    std::vector<std::string> options = FitOptions(Copy(Path(silhouette), name + ".png"));
    for (const std::string& more :
         {"--fabric=" + name, std::string("--model=heterogeneous"), std::string("--field_modes=2"),
          std::string("--field_iterations=1"), std::string("--field_restarts=0")})
      options.push_back(more);
    RunPlanted("fit", options);
    EXPECT_GT(Read(Path("fit/fields.json")).size(), 1000u);
    std::filesystem::remove_all(Path("fit"));
  }
  RunPlanted("compare_optimisers",
             {"--twins=" + names_[0] + "," + names_[1], "--fabric=" + Copy(kWool, "3" + names_[1]),
              "--twin_mesh=disc:120", "--mesh=disc:100", "--coarse_mesh=disc:100",
              "--num_parameters=2", "--methods=lm", "--budget=4", "--out=optimisers"});
}

TEST_F(PlantedNames, RunNoCommandInAGarment) {
  for (const std::string& name : names_)
    RunPlanted("garment", {"--garment=" + Copy(kConfigs + "garments/circle_skirt.json", name + "2"),
                           "--body=mannequin:stand", "--fabric=" + name, "--edge=0.08",
                           "--seconds=0.04", "--out=garment"});
}

TEST_F(PlantedNames, RunNoCommandInAComparison) {
  std::vector<std::string> options = FitOptions("");
  options.erase(options.begin(), options.begin() + 2);
  for (const std::string& more :
       {"--data=" + AddData(), std::string("--data_fabric=3"), std::string("--models=homogeneous"),
        std::string("--seeds=1"), std::string("--train=2"), std::string("--train_captures=1"),
        std::string("--face=up"), std::string("--draws=4"), std::string("--calibrate=false"),
        "--fabric=" + names_[1]})
    options.push_back(more);
  RunPlanted("compare", options);
}

TEST_F(HostileFiles, ShowNothingThatATerminalActsOn) {
  Write("red.obj", "v 0 0 0\n\x1b[31mred\x07 1 2 3\n");
  ExpectRefused(Drape({"--mesh=red.obj"}), "\\x1b[31mred\\x07");
  ExpectRefused(Drape({"--fabric=\x1b]0;title\x07.json"}), "\\x1b]0;title\\x07.json: no such file");
  Write("long.obj", "v 0 0 0\n" + std::string(1 << 20, 'k') + " 1 2 3\n");
  ExpectRefused(Drape({"--mesh=long.obj"}), "long.obj: the file has no faces");
  ExpectRefused(Drape({"--fabric=" + std::string(5000, 'p')}), "pp…pp");
  WriteFabric("key.json", std::string(5000, 'n'), 1);
  ExpectRefused(Drape({"--fabric=key.json"}), "unknown key");
  const ProcessResult named = Drape({"--fabric=" + WriteFabric("name.json", "name", "a\x1b[2Jb")});
  EXPECT_EQ(named.exit_code, 0) << named.err;
  EXPECT_FALSE(HasControls(named.out + named.err));
}

TEST_F(HostileFiles, AreFoundBeforeTheWork) {
  Write("nul.json", Read(kWool) + std::string("\0 [", 3));
  ExpectRefused(Drape({"--fabric=nul.json"}), "nul.json: found a NUL");
  ExpectRefused(Drape({"--fabric=" + Copy(kWool, "m\xff.json")}), "'m\\xff.json', expected UTF-8");
  const std::string silhouette = AddSilhouette("s.png");
  ExpectRefused(Run("metrics", {Copy(Path(silhouette), "\xff.png")}), "expected UTF-8");
  std::filesystem::create_directory(Path("images"));
  Copy(Path(silhouette), "images/im\xff.png");
  ExpectRefused(Run("fit", FitOptions("images")), "im\\xff.png', expected a name in UTF-8");
  const std::string name(250, 'L');
  ExpectRefused(Run("fit", FitOptions(Copy(Path(silhouette), name.substr(4) + ".png"))),
                "found a name of 246 bytes, expected at most 244");
  std::vector<std::string> options = FitOptions(silhouette);
  options.push_back("--specimens=1");
  ExpectRefused(Run("fit", options), "specimens: found some with model homogeneous");
  EXPECT_FALSE(std::filesystem::exists(Path("fit")));
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

// Names of which files of the results are made are too long for these, not for the inputs.
TEST_F(HostileFiles, OfLongNamesAreFoundBeforeTheWork) {
  const std::string longer(245, 'L'), silhouette = AddSilhouette("s.png");
  const auto bench = [&](const std::vector<std::string>& more) {
    std::vector<std::string> options = {"--start=" + kWaves, "--mesh=disc:100",
                                        "--coarse_mesh=disc:100", "--solve=static", "--out=out"};
    options.insert(options.end(), more.begin(), more.end());
    return Run("bench", options);
  };
  const std::string fit = "--work=fit", wool = "--fabric=" + kWool;
  ExpectRefused(bench({fit, wool, "--images=" + Copy(Path(silhouette), longer + ".png")}),
                "found a name of 245 bytes, expected at most 244");
  ExpectRefused(bench({fit, wool, "--ground_truth=" + kWool, "--mesh=none.obj"}), "none.obj");
  const auto optimisers = [&](const std::vector<std::string>& more) {
    std::vector<std::string> options = {wool,
                                        "--image_fabrics=" + kWool,
                                        "--mesh=disc:100",
                                        "--coarse_mesh=disc:100",
                                        "--twin_mesh=disc:100",
                                        "--out=out"};
    options.insert(options.end(), more.begin(), more.end());
    return Run("compare_optimisers", options);
  };
  ExpectRefused(optimisers({"--twins=" + Copy(kWool, std::string(250, 'M') + ".json")}),
                "expected at most 255");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(HostileFiles, MayHaveHashesAndCommasInTheirPaths) {
  for (const char* folder : {"d#1", "a,b"}) std::filesystem::create_directory(Path(folder));
  Copy(kWool, "d#1/m.json");
  Copy(kWool, "a,b/m#2.json");
  for (const char* material : {"d#1/m.json", "a,b/m#2.json", "d#1/m.json#synthetic_wool"})
    EXPECT_EQ(Drape({std::string("--fabric=") + material}).exit_code, 0) << material;
  ExpectRefused(Drape({"--fabric=d#1/m.json#silk"}), "d#1/m.json: has no fabric 'silk'");
  Copy(Path(AddSilhouette("s.png")), "a,b/s,1.png");
  for (const char* images : {"a,b", "a,b/s,1.png", "s.png,a,b/s,1.png"}) {
    const ProcessResult fit = Run("fit", FitOptions(images));
    EXPECT_EQ(fit.exit_code, 0) << images << fit.err;
  }
}

TEST_F(HostileFiles, GiveNoNumberThatIsNotFinite) {
  const std::string start = R"({"format": "drapefit-start-shape", "version": 1, "modes": [)";
  Write("far.json", start + R"({"k": 3, "amplitude_m": 1e308, "phase": 0}]})");
  ExpectRefused(Drape({"--start=far.json"}), "'modes[0].amplitude_m': found 1e+308");
  ExpectRefused(Drape({"--fabric=" + WriteFabric("heavy.json", "density", 1e308)}),
                "'density': found 1e+308, expected");
  ExpectRefused(Drape({"--camera_scale=1e-300"}), "camera_scale");
  ExpectRefused(Drape({"--image_width_mm=1e300"}), "image_width_mm");
  ExpectRefused(Drape({"--mesh=strip:0.2x1e-300x40"}), "length or width out of range");
  ExpectRefused(Drape({"--mesh=disc:300,radius=1e300"}), "radius 1e+300 m");
  for (const char* option : {"--sigma_px=1e-300", "--prior_sigma=1e-300"}) {
    std::vector<std::string> options = FitOptions("none.png");
    options.push_back(option);
    ExpectRefused(Run("fit", options), " … 10000");
  }
  const Json numbers(100, Json({0, 0, 0}));
  Write("point.json", Json({{"x", numbers}, {"v", numbers}}).dump());
  for (const char* solve : {"dynamic", "static"}) {
    const ProcessResult result =
        Drape({"--start=point.json", std::string("--solve=") + solve, "--dump_steps="});
    const std::string all = result.out + result.err;
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 3)) << result.err;
    for (const char* number : {"nan", "inf "}) EXPECT_THAT(all, Not(HasSubstr(number)));
  }
}

class HostileFolders : public HostileFiles {};

TEST_F(HostileFolders, HoldInputsThatResultsWouldReplace) {
  const std::string silhouette = AddSilhouette("s.png");
  std::filesystem::create_directory(Path("own"));
  Copy(kWool, "own/summary.json");
  Copy(kWool, "own/material.json");
  Copy(Path(silhouette), "own/silhouette.png");
  const auto before = Snapshot(Path(""));
  const std::string input = " is an input of this run";
  ExpectRefused(Drape({"--fabric=own/summary.json", "--out=own"}), "own/summary.json:" + input);
  ExpectRefused(Drape({"--image=own/silhouette.png", "--out=./own"}), "silhouette.png:" + input);
  std::vector<std::string> fit = FitOptions(silhouette);
  for (const char* more : {"--fabric=own/material.json", "--out=own"}) fit.push_back(more);
  ExpectRefused(Run("fit", fit), "own/material.json:" + input);
  for (const char* option : {"--overlay=", "--csv=", "--out="})
    ExpectRefused(Run("metrics", {silhouette, option + silhouette}), "s.png:" + input);
  ExpectRefused(Run("metrics", {silhouette, "--out=drape/summary.json"}),
                "drape/summary.json: is of another program");
  ExpectRefused(Run("report", {"drape", "--out=s.png"}), "s.png: is no page");
  EXPECT_EQ(Snapshot(Path("")), before);
}

TEST_F(HostileFolders, HoldFilesOfOthersWithOurNames) {
  const std::string silhouette = AddSilhouette("s.png");
  std::filesystem::create_directories(Path("fit/.drapefit_notes"));
  Write("fit/.drapefit_notes/thesis.txt", "theirs");
  Write("fit/checkpoint.json", R"({"epoch": 3})");
  ExpectRefused(Run("fit", FitOptions(silhouette)), "checkpoint.json: is no file of the format");
  EXPECT_EQ(Read(Path("fit/checkpoint.json")), R"({"epoch": 3})");
  EXPECT_EQ(Read(Path("fit/.drapefit_notes/thesis.txt")), "theirs");
}

TEST_F(HostileFolders, AreOfOneProgramAtATime) {
  ASSERT_EQ(Drape({}).exit_code, 0);
  const auto before = Snapshot(Path("out"));
  const OutputFolder other(Path("out"));
  const ProcessResult second = Drape({"--steps=3"});
  ExpectRefused(second, "out: another program is writing to this folder");
  for (const auto& [path, content] : before) EXPECT_EQ(Read(path), content) << path;
}

TEST_F(HostileFolders, HoldLinksAndFoldersInPlaceOfResults) {
  const std::string silhouette = AddSilhouette("s.png");
  std::filesystem::create_directory(Path("fit"));
  Write("victim", "theirs");
  std::filesystem::create_symlink(Path("victim"), Path("fit/fit.log"));
  ExpectRefused(Run("fit", FitOptions(silhouette)), "fit.log: is a link");
  std::filesystem::remove(Path("fit/fit.log"));
  std::filesystem::create_directory(Path("fit/fit.log"));
  ExpectRefused(Run("fit", FitOptions(silhouette)), "fit.log: is a folder");
  EXPECT_EQ(Read(Path("victim")), "theirs");
  ASSERT_EQ(Drape({}).exit_code, 0);
  std::filesystem::remove(Path("out/silhouette.png"));
  std::filesystem::create_directory(Path("out/silhouette.png"));
  const auto before = Snapshot(Path("out"));
  ExpectRefused(Drape({"--steps=3"}), "silhouette.png: is a folder, expected");
  EXPECT_EQ(Snapshot(Path("out")), before);
}

TEST_F(HostileFolders, StayAsTheyWereWhereOneFileCannotBeReplaced) {
  const std::string silhouette = AddSilhouette("s.png");
  std::filesystem::create_directory(Path("fit"));
  Write("fit/fit.log", "earlier");
  for (const char* name : {"summary.json", "material.json", "checkpoint.json", "fit_s.png"}) {
    const std::string folder = std::string("fit/") + name;
    std::filesystem::create_directory(Path(folder));
    const auto before = Snapshot(Path("fit"));
    ExpectRefused(Run("fit", FitOptions(silhouette)), folder + ": is a folder");
    EXPECT_EQ(Snapshot(Path("fit")), before);
    std::filesystem::remove(Path(folder));
  }
  // The first file is looked for before the work, a file of the script when all runs have ended.
  for (const char* name : {"bench.json", "runs.csv"}) {
    const std::string folder = std::string("bench/") + name;
    std::filesystem::create_directories(Path(folder));
    const ProcessResult result =
        Run("bench",
            {"--work=forward", "--fabric=" + kWool, "--start=" + kWaves, "--mesh=disc:100",
             "--time_step=0.2", "--reference=disc:120,disc:150", "--reference_relax_mesh=disc:100",
             "--coarse_mesh=disc:100", "--run_seconds=0", "--repeats=1", "--out=bench"});
    ExpectRefused(result, folder + ": ");
    EXPECT_THAT(result.err, HasSubstr("a folder"));
    std::filesystem::remove(Path(folder));
    EXPECT_FALSE(std::filesystem::exists(Path("bench/bench.json")));
    EXPECT_FALSE(std::filesystem::exists(Path("bench/report.md")));
  }
}

}  // namespace
}  // namespace drape::test
