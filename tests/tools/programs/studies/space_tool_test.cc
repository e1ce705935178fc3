// SPDX-License-Identifier: Apache-2.0
// drape_space as a user runs it.
#include <future>

#include "cuda/engine/cuda_backend.h"
#include "physics/material/material_io.h"
#include "solver/posterior/posterior_io.h"
#include "tests/solver/prediction/generative/fake_pool.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kSpace = std::string(DRAPE_BIN_DIR) + "/drape_space";
const std::string kSpaceWool =
    std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json";

class SpaceTool : public ToolFixture {
 protected:
  // Fabrics that differ by all stretch and by all bend entries.
  std::string AddPosterior(const std::string& name, double stretch, double bend,
                           double prior = 1.0) const {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kScales;
    posterior.specimens = 1;
    posterior.base = ReadMaterial(kSpaceWool).field;
    posterior.prior_sd = Eigen::Vector4d(prior, prior, 0.1, 0.1);
    posterior.mean = Eigen::Vector4d(stretch, bend, 0, 0);
    posterior.covariance = 0.01 * Eigen::Matrix4d::Identity();
    std::filesystem::create_directories(Path(name));
    WritePosterior(Path(name), posterior, "test");
    return Path(name);
  }
  ProcessResult Run(const std::string& posteriors,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {kSpace, "--posteriors=" + posteriors,
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

TEST_F(SpaceTool, WritesDistancesPopulationAndPictures) {
  const std::string folders =
      AddPosterior("linen", 0.0, 0.0) + "," + AddPosterior("denim", 0.1, 0.5) + "," +
      AddPosterior("silk", -0.2, -0.9) + "," + AddPosterior("twill", 0.7, 0.1);
  const std::string added = AddPosterior("found", 0.08, 0.52);
  const ProcessResult result = Run(folders, {"--new=" + added});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("4 fabrics by drape; the data determine 2 of 2"));
  EXPECT_THAT(result.out, testing::HasSubstr("denim"));
  const Json space = ReadJson(Path("out/space.json"));
  EXPECT_EQ(space["fabrics"].size(), 4u);
  EXPECT_EQ(space["log_bending_lengths"].size(), 5u);
  ASSERT_EQ(space["new"].size(), 1u);
  EXPECT_GT(space["new"][0]["probability_of_fabrics"][1].get<double>(), 0.5);
  // Two levels of six pairs, and the header.
  const std::string csv = Read(Path("out/distances.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  for (const char* picture : {"heat_map.png", "map.png", "textile_map.png"})
    EXPECT_GT(Read(Path(std::string("out/") + picture)).size(), 5000u) << picture;
}

TEST_F(SpaceTool, MistakesAreOneLine) {
  const std::string one = AddPosterior("one", 0, 0), two = AddPosterior("two", 1, 1);
  ExpectOneLineError(Run(one), "at least two fabrics");
  ExpectOneLineError(Run(one + "," + Path("none")), "none");
  ExpectOneLineError(Run(one + "," + AddPosterior("narrow", 0, 0, 0.5)), "prior_sd 0.5");
  ExpectOneLineError(Run(one + "," + two, {"--data=" + Path("")}), "found both");
  ExpectOneLineError(Run(one + "," + two, {"--recognise"}), "recognise");
  ExpectOneLineError(Run(one + "," + two, {"--list"}), "option 'list': found true without 'data'");
  ExpectOneLineError(Run(one + "," + two, {"--share=0/2"}), "option 'share': found '0/2' without");
  ExpectOneLineError(Run(one + "," + two, {"--share=2/2"}), "option 'share': found '2/2'");
  ExpectOneLineError(Run(one + "," + two, {"--new=" + Path("none.json")}), "none.json");
  ExpectOneLineError(RunProcess({kSpace, "--out=" + Path("out")}), "found neither");
  ExpectOneLineError(RunProcess({kSpace, "--data=" + Path(""), "--out=" + Path("out")}), Path(""));
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

// Recognition of two samples of each of two made-up fabrics, by quick fits.
class SpaceShares : public ToolFixture {
 protected:
  SpaceShares() {
    for (const int fabric : {2, 3})
      for (const int sample : {1, 2})
        AddDisc("set/data/Fabric " + std::to_string(fabric) + "/silhouettes/Sample_" +
                    std::to_string(sample) + "_Capture_1.png",
                0.04 + 0.03 * fabric + 0.001 * sample);
  }
  ProcessResult Run(const std::vector<std::string>& more, ProcessLimits limits = {}) const {
    limits.charts = charts_;
    std::vector<std::string> command = {kSpace,
                                        "--data=" + Path("set"),
                                        "--recognise",
                                        "--fabric=" + kSpaceWool,
                                        "--ways=posterior,features",
                                        "--mesh=disc:120",
                                        "--search_mesh=disc:120",
                                        "--coarse_mesh=disc:100",
                                        "--initial_stretch=1",
                                        "--initial_bend=1",
                                        "--initial_lifts=1",
                                        "--candidates_per_round=1",
                                        "--iterations=2",
                                        "--num_parameters=2",
                                        "--posterior_samples=2",
                                        "--posterior_rank=1",
                                        "--posterior_iterations=1",
                                        "--elbo_samples=25",
                                        "--sigma_px=2",
                                        "--threads=1",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
  // The files of fits that hold no times.
  std::map<std::string, std::string> Results(const std::string& folder) const {
    std::map<std::string, std::string> results;
    for (const auto& [path, content] : Snapshot(Path(folder + "/samples")))
      if (!path.ends_with("summary.json") && !path.ends_with("fit.log"))
        results[path.substr(Path(folder).size())] = content;
    return results;
  }

  bool charts_ = false;
};

// The files are those of one run, to the last byte.
TEST_F(SpaceShares, GatherToTheSameRecognition) {
  const ProcessResult whole = Run({"--out=" + Path("whole")});
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_EQ(Run({"--list", "--share=1/3"}).out, "fabric_2/sample_2\n");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessLimits killed = {.interrupt_when = Path("out/samples/fabric_2/sample_2/fit.log"),
                                .interrupt_signal = SIGKILL};
  EXPECT_EQ(Run({"--share=1/3"}, killed).exit_code, 128 + SIGKILL);
  EXPECT_THAT(Run({"--share=0/3"}).out, testing::HasSubstr("share 0/3: 2 of 2 cells are complete"));
  auto third = std::async(std::launch::async, [&] { return Run({"--share=2/3"}).exit_code; });
  EXPECT_EQ(Run({"--share=1/3"}).exit_code, 0);
  EXPECT_EQ(third.get(), 0);
  EXPECT_FALSE(std::filesystem::exists(Path("out/recognition.md")));
  const ProcessResult gathered = Run({});
  ASSERT_EQ(gathered.exit_code, 0) << gathered.err;
  EXPECT_EQ(gathered.out, whole.out);
  EXPECT_EQ(Results("out"), Results("whole"));
  EXPECT_EQ(Read(Path("out/recognition.md")), Read(Path("whole/recognition.md")));
}

// From a pool that is there.
TEST_F(SpaceShares, PredictionsNeedNoFit) {
  DrapePool pool = FakePool(1000);
  pool.mesh = "disc:120";
  pool.setting = "smooth law, contact none, 100 steps of 0.1 s";
  WritePool(Path("pool.json"), pool);
  const std::vector<std::string> options = {"--ways=predictions,features",
                                            "--pool=" + Path("pool.json"), "--pool_drapes=1000"};
  const auto run = [&](const std::string& more) {
    std::vector<std::string> all = options;
    all.push_back(more);
    return Run(all);
  };
  charts_ = true;  // without them, the output says so
  const ProcessResult result = run("--pool_mesh=disc:120");
  charts_ = false;
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("| predicted drapes (B) | 4 | 1.000 |"));
  EXPECT_THAT(result.out, testing::HasSubstr("| B and features | 4 | 1.000 |"));
  EXPECT_THAT(result.out, testing::Not(testing::HasSubstr("posterior")));
  EXPECT_EQ(Read(Path("out/recognition.md")), result.out);
  EXPECT_FALSE(std::filesystem::exists(Path("out/samples")));
  ExpectOneLineError(run("--pool_mesh=disc:150"),
                     "found a pool of mesh disc:120, expected disc:150");
  ExpectOneLineError(run("--share=0/2"), "option 'ways': found no 'posterior'");
  ExpectOneLineError(run("--ways=features,telepathy"), "option 'ways': found 'features,telepathy'");
  const ProcessResult all = Run(
      {"--ways=posterior,predictions,features", options[1], options[2], "--pool_mesh=disc:120"});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  for (const char* way : {"posterior (A)", "A and B", "A and features", "A, B and features"})
    EXPECT_THAT(all.out, testing::HasSubstr(std::string("| ") + way + " | 4 |"));
}

TEST_F(SpaceShares, HaveFabricsOfTheirOwnAndNoTables) {
  const std::string fabrics = "--recognise=false";
  EXPECT_EQ(Run({fabrics, "--list"}).out, "fabric_2\nfabric_3\n");
  const ProcessResult share = Run({fabrics, "--share=1/2"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, testing::HasSubstr("share 1/2: 1 of 1 cells are complete"));
  EXPECT_TRUE(std::filesystem::exists(Path("out/fabrics/fabric_3/posterior.json")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/fabrics/fabric_2")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/space.json")));
  const auto fit = Snapshot(Path("out/fabrics/fabric_3"));
  const ProcessResult gathered = Run({fabrics});
  ASSERT_EQ(gathered.exit_code, 0) << gathered.err;
  EXPECT_EQ(Snapshot(Path("out/fabrics/fabric_3")), fit);
  EXPECT_TRUE(std::filesystem::exists(Path("out/space.json")));
}

// Not as a failure of each fit, which would be kept.
TEST_F(SpaceShares, ABackendThatIsNotThereIsRefusedBeforeAnyFit) {
  if (const CudaSurvey survey = SurveyCuda(); !survey.usable)
    ExpectOneLineError(Run({"--backend=cuda", "--contact=support"}), survey.text);
  ExpectOneLineError(Run({"--backend=gpu"}), "option 'backend': found 'gpu'");
  EXPECT_FALSE(std::filesystem::exists(Path("out/samples")));
}

}  // namespace
}  // namespace drape::test
