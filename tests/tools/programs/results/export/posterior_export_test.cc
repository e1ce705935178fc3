// SPDX-License-Identifier: Apache-2.0
// What drape_export writes for statisticians, as they read it.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <cmath>
#include <sstream>

#include "physics/material/material_io.h"
#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/variational_fit.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kExportSamples = std::string(DRAPE_BIN_DIR) + "/drape_export";

const std::string kPackage = std::string(DRAPE_SOURCE_DIR) + "/tools/python/drapefit";

class StatisticsTest : public ToolFixture {
 protected:
  ProcessResult Export(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {kExportSamples};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

// Two factors on stretch and on bend, and a specimen.
StoredPosterior Scales() {
  StoredPosterior posterior;
  posterior.fabric = ParameterTying::kScales;
  posterior.specimens = 1;
  posterior.base = ReadMaterial(kFabric).field;
  posterior.prior_sd = Eigen::VectorXd::Constant(4, 0.5);
  posterior.mean = Eigen::VectorXd::LinSpaced(4, -0.3, 0.3);
  posterior.covariance = Eigen::MatrixXd::Constant(4, 4, 0.01);
  posterior.covariance.diagonal() = Eigen::VectorXd::LinSpaced(4, 0.02, 0.08);
  return posterior;
}

std::string PythonWith(const std::string& modules) {
  for (const std::string python : {"/usr/bin/python3", "python3"})
    if (RunProcess({"/bin/sh", "-c", python + " -c 'import " + modules + "'"}).exit_code == 0)
      return python;
  return "";
}

// As a statistician opens it: the file against posterior.json and against the table.
constexpr char kReadPosterior[] = R"py(
import csv, json, sys
import numpy as np
sys.path.insert(0, sys.argv[3])
import inference
folder, out = sys.argv[1:3]
stored = json.load(open(folder + "/posterior.json"))
opened = inference.inference_data(folder, out + "/draws.csv", folder + "/prediction")
assert list(opened) == ["posterior", "prior", "constant_data", "observed_data", "predictions"]
posterior = opened["posterior"]
assert posterior.log_factor.dims == ("chain", "draw", "parameter"), posterior.log_factor.dims
assert posterior.log_factor.shape == (4, 1000, 4)
assert list(posterior.parameter.values) == stored["names"], posterior.parameter.values
assert posterior.shear.attrs["units"] == "N/m" and posterior.bend_weft.attrs["units"] == "N m"
for group in opened.values():
    for name in group.data_vars:
        assert "units" in group[name].attrs, name
        for dim in group[name].dims:
            assert dim in group.coords, dim
flat = posterior.log_factor.values.reshape(-1, 4)
sd = np.sqrt(np.diag(stored["covariance"]))
assert np.all(abs(flat.mean(0) - stored["mean"]) < 4 * sd / 4000**0.5), flat.mean(0)
assert np.all(abs(np.cov(flat.T) / stored["covariance"] - 1) < 0.25), np.cov(flat.T)
prior = opened["prior"].log_factor.values.reshape(-1, 4)
assert np.all(abs(prior.std(0) / stored["prior_sd"] - 1) < 0.05), prior.std(0)
constant = opened["constant_data"]
assert np.array_equal(constant.posterior_covariance.values, stored["covariance"])
assert np.array_equal(constant.posterior_mean.values, stored["mean"])
assert list(opened["observed_data"].image.values) == ["front"]
assert opened["observed_data"].drape_coefficient.values[0] == 0.41
assert opened["predictions"].nodes.values.tolist() == [[7.0, 6.0]]
rows = list(csv.DictReader(open(out + "/draws.csv")))
assert len(rows) == 4000 and rows[1000][".chain"] == "2" and rows[1000][".iteration"] == "1"
for i in (0, 1234, 3999):
    assert float(rows[i]["log_factor[bend]"]) == flat[i][1]
    assert float(rows[i]["bend_weft"]) == posterior.bend_weft.values.reshape(-1)[i]
    assert int(rows[i][".draw"]) == i + 1
print("EQUAL")
)py";

TEST_F(StatisticsTest, StatisticiansOpenThePosterior) {
  const std::string python = PythonWith("xarray");
  if (python.empty()) GTEST_SKIP() << "needs python3-xarray";
  WritePosterior(Path(""), Scales(), "test");
  Write("summary.json", R"({"posterior": {}, "images": [
      {"name": "front", "metrics": {"dc_image": 0.41, "folds_image": 6}}]})");
  std::filesystem::create_directories(Path("prediction"));
  Write("prediction/summary.json",
        R"({"drapes": [{"dc": 0.4, "folds": 7}, {"status": "lost"}, {"dc": 0.5, "folds": 6}]})");
  const std::vector<std::string> command = {
      "--fabric=" + Path(""), "--to=csv",         "--draws=4000",        "--chains=4",
      "--starts=0",           "--linear_at=rest", "--out=" + Path("out")};
  const ProcessResult result = Export(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Write("read.py", kReadPosterior);
  const ProcessResult read = RunProcess({"/bin/sh", "-c",
                                         python + " '" + Path("read.py") + "' '" + Path("") +
                                             "' '" + Path("out") + "' '" + kPackage + "'"});
  EXPECT_EQ(read.out, "EQUAL\n") << read.err;
}

// Samples of Scales() of two images, as a fit leaves them, and outlines that depend on their bend.
StoredSamples SamplesOfScales(int count) {
  constexpr int kAngles = 12;
  const StoredPosterior posterior = Scales();
  const int n = posterior.size();
  StoredSamples stored;
  stored.drawn = count + 3;
  for (const char* name : {"front", "back"})
    stored.images.push_back(
        {name, 1e-3 * (1.0 + stored.images.size()), Eigen::VectorXd::Constant(kAngles, 0.12)});
  const Eigen::MatrixXd standard = IndependentSamples(n, count, 5);
  const Eigen::LLT<Eigen::MatrixXd> root(posterior.covariance);
  for (int s = 0; s < count; ++s) {
    const Eigen::VectorXd u = posterior.mean + root.matrixL() * standard.col(s);
    Eigen::MatrixXd radius(kAngles, 2);
    for (int k = 0; k < kAngles; ++k)
      for (int i = 0; i < 2; ++i) radius(k, i) = 0.12 + 2e-3 * u[1] * std::cos(k + i) + 1e-4 * k;
    stored.samples.push_back({u, -0.5 * u.cwiseQuotient(posterior.prior_sd).squaredNorm(),
                              -0.5 * standard.col(s).squaredNorm(), radius});
  }
  return stored;
}

// The rules of InferenceData, and the log-likelihood by its formula.
constexpr char kReadLikelihood[] = R"py(
import csv, json, sys
import numpy as np
sys.path.insert(0, sys.argv[3])
import inference
folder, out = sys.argv[1:3]
stored = json.load(open(folder + "/samples.json"))
groups = inference.inference_data(folder, out + "/draws.csv")
assert set(groups) == {"posterior", "prior", "posterior_predictive", "log_likelihood",
                       "sample_stats", "observed_data", "constant_data"}
for name, group in groups.items():
    sampled = name not in ("observed_data", "constant_data")
    assert group.attrs["inference_library"] == "drapefit"
    for variable in group.data_vars:
        assert "units" in group[variable].attrs, (name, variable)
        dims = group[variable].dims
        assert all(dim in group.coords for dim in dims), (name, variable)
        assert (dims[:2] == ("chain", "draw")) == sampled, (name, variable, dims)
posterior = groups["posterior"]
for name in ("posterior_predictive", "log_likelihood", "sample_stats"):
    for dim in ("chain", "draw"):
        assert np.array_equal(groups[name][dim], posterior[dim]), (name, dim)
assert posterior.sizes["chain"] == 4 and posterior.sizes["draw"] == 50, posterior.sizes
observed, likelihood = groups["observed_data"].outline, groups["log_likelihood"].outline
sigma = groups["constant_data"].sigma
assert observed.dims == ("image", "angle") and list(observed.image.values) == ["front", "back"]
assert likelihood.dims[2:] == observed.dims and observed.attrs["units"] == "m"
assert observed.angle.attrs["units"] == "degree" and observed.angle.values[1] == 30.0
assert np.array_equal(observed.values, [i["radius_m"] for i in stored["images"]])
assert list(sigma.values) == [i["sigma_m"] for i in stored["images"]]
drawn = posterior.drape_outline.values.reshape(200, 2, 12)
assert np.array_equal(drawn, [s["radius_m"] for s in stored["samples"][:200]])
factors = posterior.log_factor.values.reshape(200, 4)
assert np.array_equal(factors, [s["log_factors"] for s in stored["samples"][:200]])
again = (-0.5 * ((posterior.drape_outline - observed) / sigma) ** 2
         - np.log(sigma * np.sqrt(2 * np.pi)))
assert np.allclose(again.transpose(*likelihood.dims).values, likelihood.values, rtol=0, atol=1e-11)
stats = groups["sample_stats"]
prior = np.reshape([s["log_prior"] for s in stored["samples"][:200]], (4, 50))
assert np.allclose(stats.lp.values, likelihood.sum(("image", "angle")).values + prior, atol=1e-9)
seen = (groups["posterior_predictive"].outline - posterior.drape_outline) / sigma
assert abs(float(seen.mean())) < 5 / seen.size ** 0.5 and abs(float(seen.std()) - 1) < 0.05
rows = list(csv.DictReader(open(out + "/draws.csv")))
flat = likelihood.values.reshape(200, 24)
for i in (0, 77, 199):
    assert [float(rows[i]["log_lik[%d]" % (k + 1)]) for k in range(24)] == list(flat[i])
    assert float(rows[i]["lp__"]) == stats.lp.values.reshape(-1)[i]
print("EQUAL")
)py";

TEST_F(StatisticsTest, LogLikelihoodIsThatOfTheOutlines) {
  const std::string python = PythonWith("xarray");
  if (python.empty()) GTEST_SKIP() << "needs python3-xarray";
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), SamplesOfScales(203));
  const ProcessResult result = Export({"--fabric=" + Path(""), "--to=csv", "--chains=4",
                                       "--starts=0", "--linear_at=rest", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Write("read.py", kReadLikelihood);
  const ProcessResult read = RunProcess({"/bin/sh", "-c",
                                         python + " '" + Path("read.py") + "' '" + Path("") +
                                             "' '" + Path("out") + "' '" + kPackage + "'"});
  EXPECT_EQ(read.out, "EQUAL\n") << read.err;
}

// As an R user takes the table to leave-one-out cross-validation.
TEST_F(StatisticsTest, RsLooHasOurParetoShapes) {
  if (RunProcess({"/bin/sh", "-c", "Rscript -e 'library(loo)'"}).exit_code != 0)
    GTEST_SKIP() << "needs Rscript and R's loo (r-cran-loo)";
  const StoredSamples samples = SamplesOfScales(400);
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), samples);
  ASSERT_EQ(Export({"--fabric=" + Path(""), "--to=csv", "--starts=0", "--linear_at=rest",
                    "--out=" + Path("out")})
                .exit_code,
            0);
  Write("loo.R", R"r(
suppressPackageStartupMessages(library(loo))
draws <- read.csv(commandArgs(TRUE)[1], check.names = FALSE)
ll <- as.matrix(draws[, grep("^log_lik", names(draws))])
shape <- function(weights)
  suppressWarnings(psis(weights, r_eff = 1))$diagnostics$pareto_k
shapes <- apply(-ll, 2, shape)
approximate <- suppressWarnings(
  loo_approximate_posterior(ll, log_p = draws[["lp__"]], log_g = draws[["lp_approx__"]]))
cat(sprintf("%.12g\n", c(shape(draws[["lp__"]] - draws[["lp_approx__"]]), shapes,
                         approximate$estimates["elpd_loo", "Estimate"])))
)r");
  const ProcessResult r = RunProcess(
      {"/bin/sh", "-c", "Rscript '" + Path("loo.R") + "' '" + Path("out/draws.csv") + "'"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  std::istringstream numbers(r.out);
  const auto next = [&] {
    double number = std::nan("");
    numbers >> number;
    return number;
  };
  Eigen::MatrixXd likelihood(24, 400);
  Eigen::VectorXd weights(400);
  for (int s = 0; s < 400; ++s) {
    const StoredSamples::Sample& sample = samples.samples[s];
    likelihood.col(s) = samples.LogLikelihood(sample).reshaped();
    weights[s] = likelihood.col(s).sum() + sample.log_prior - sample.log_density;
  }
  EXPECT_NEAR(next(), ParetoShape(weights), 1e-9);
  for (int k = 0; k < 24; ++k)
    EXPECT_NEAR(next(), ParetoShape(-likelihood.row(k).transpose()), 1e-9) << "radius " << k;
  EXPECT_TRUE(std::isfinite(next())) << r.out;
}

TEST_F(StatisticsTest, SamplesBelongToTheirFit) {
  const std::string out = "--out=" + Path("out");
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), SamplesOfScales(3));
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", "--chains=4", out}),
                     "has 3 samples");
  Write("summary.json", R"({"posterior": {}, "images": [
      {"name": "other", "metrics": {"dc_image": 0.41, "folds_image": 6}}]})");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}),
                     "has other images than summary.json");
  Write("samples.json", "{\"format\": \"drapefit-samples\"}");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}),
                     "samples.json: key 'version'");
  EXPECT_EQ(Export({"--fabric=" + Path(""), "--to=csv", "--draws=10", "--starts=0",
                    "--linear_at=rest", out})
                .exit_code,
            0);
}

TEST_F(StatisticsTest, APosteriorIsNeededForItsFiles) {
  const std::string out = "--out=" + Path("out");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=csv", out}), "has no posterior");
  WritePosterior(Path(""), Scales(), "test");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", "--draws=7", "--chains=2", out}),
                     "multiple");
  StoredPosterior elements;
  elements.kind = PosteriorKind::kElements;
  elements.base = ReadMaterial(kFabric).field;
  elements.mean = Eigen::VectorXd::Zero(39);
  elements.prior_sd = elements.element_sd = Eigen::VectorXd::Ones(39);
  WritePosterior(Path(""), elements, "test");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}), "kind bdp");
}

}  // namespace
}  // namespace drape::test
