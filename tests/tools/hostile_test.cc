// SPDX-License-Identifier: Apache-2.0
// The real programs with names, files and surroundings that are meant to do harm.
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";
const std::string kWool = kConfigs + "fabrics/synthetic_wool.json";
const std::string kWaves = kConfigs + "starts/six_waves.json";

// Control bytes that a terminal acts on.
bool HasControls(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
  });
}

// Runs the programs in a folder of their own, from where a command in a name would write to it.
class Hostile : public ToolFixture {
 protected:
  ProcessResult Run(const std::string& program, const std::vector<std::string>& options,
                    ProcessLimits limits = {}) const {
    std::vector<std::string> command = {std::string(DRAPE_BIN_DIR) + "/drape_" + program};
    command.insert(command.end(), options.begin(), options.end());
    limits.folder = Path("");
    return RunProcess(command, limits);
  }

  std::string Copy(const std::string& file, const std::string& name) const {
    std::filesystem::copy(file, Path(name));
    return name;
  }

  // One drape, for its silhouette.
  std::string AddSilhouette(const std::string& name) const {
    EXPECT_EQ(Run("simulate", {"--mesh=disc:100", "--material=" + kWool, "--start=" + kWaves,
                               "--steps=40", "--time_step=0.1", "--out=drape"})
                  .exit_code,
              0);
    return Copy(Path("drape/silhouette.png"), name);
  }

  static std::vector<std::string> FitOptions(const std::string& image) {
    return {"--images=" + image,
            "--material=" + kWool,
            "--mesh=disc:100",
            "--coarse_mesh=disc:100",
            "--candidates_per_round=1",
            "--iterations=1",
            "--initial_stretch=1",
            "--initial_bend=1",
            "--initial_lifts=1",
            "--initial_steps=10",
            "--recheck_steps=5",
            "--num_parameters=2",
            "--threads=1",
            "--out=fit"};
  }
};

// A name that gnuplot or a shell would run as a command, were it to reach one as it is.
const char* const kPlanted[] = {"a`touch PWNED_backtick`b", "q\n!touch PWNED_newline\n",
                                "'.system('touch PWNED_quote').'",
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
             {"--work=forward", "--start=" + kWaves, "--material=" + materials,
              "--mesh=disc:100,disc:150", "--solve=hybrid", "--time_step=0.2", "--relax_time=10",
              "--branch_mm=100", "--reference=disc:200,disc:300", "--reference_relax_mesh=disc:100",
              "--run_seconds=0", "--repeats=1", "--out=bench"});
  EXPECT_GT(Read(Path("bench/growth.png")).size(), 1000u);
  EXPECT_GT(Read(Path("bench/growth.svg")).size(), 1000u);
}

TEST_F(PlantedNames, RunNoCommandInOtherStudies) {
  for (const std::string& name : names_) {
    RunPlanted("gradients",
               {"--mesh=disc:100", "--material=" + name, "--horizons=1", "--time_steps=0.1",
                "--sweep_horizon=1", "--fold_starts=0", "--out=gradients"});
    RunPlanted("stability",
               {"--mesh=disc:100", "--material=" + name, "--start=" + Copy(kWaves, name + "2"),
                "--maps=step time_step=0.1/0.5 stretch=1/2", "--damping_time_step=0.1",
                "--duration=1", "--out=stability"});
  }
  RunPlanted("equilibria", {"--mesh=disc:100", "--material=" + names_[0], "--samples=1",
                            "--steps=40", "--time_step=0.1", "--out=equilibria"});
}

TEST_F(PlantedNames, RunNoCommandInFits) {
  const std::string silhouette = AddSilhouette("plain.png");
  for (const std::string& name : names_) {
    std::vector<std::string> options = FitOptions(Copy(Path(silhouette), name + ".png"));
    for (const std::string& more :
         {"--material=" + name, std::string("--model=heterogeneous"),
          std::string("--field_modes=2"), std::string("--field_iterations=1"),
          std::string("--field_restarts=0")})
      options.push_back(more);
    RunPlanted("fit", options);
    EXPECT_GT(Read(Path("fit/field_bend.png")).size(), 1000u);
    std::filesystem::remove_all(Path("fit"));
  }
  RunPlanted("compare_optimisers",
             {"--twins=" + names_[0] + "," + names_[1], "--material=" + names_[2],
              "--twin_mesh=disc:120", "--mesh=disc:100", "--coarse_mesh=disc:100",
              "--num_parameters=2", "--methods=lm", "--budget=4", "--out=optimisers"});
}

TEST_F(PlantedNames, RunNoCommandInAComparison) {
  std::vector<std::string> options = FitOptions("");
  options.erase(options.begin(), options.begin() + 2);
  for (const std::string& more :
       {"--data=" + AddData(), std::string("--fabrics=3"), std::string("--models=homogeneous"),
        std::string("--seeds=1"), std::string("--train=2"), std::string("--train_captures=1"),
        std::string("--face=up"), std::string("--draws=4"), std::string("--calibrate=false"),
        "--materials=" + names_[3]})
    options.push_back(more);
  RunPlanted("compare", options);
}

}  // namespace
}  // namespace drape::test
