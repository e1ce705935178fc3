// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition.h"

#include <glog/logging.h>

#include <memory>
#include <utility>

#include "cuda/make_backend.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/text_format.h"
#include "solver/studies/recognition/feature_way.h"
#include "solver/studies/recognition/posterior_way.h"
#include "solver/studies/recognition/prediction_way.h"

namespace drape {
namespace {

// Before its factor is found.
constexpr char kByEnergyScore[] = "energy score of the predicted drapes";
// When the pool is there and when the fits are, as shares of the time.
constexpr double kPoolShare = 0.2, kFitShare = 0.9;

// The part of a run from one share of its time to another.
RunControl PartOfRun(const RunControl& whole, double from, double to) {
  return {whole.cancel,
          [&whole, from, to](double share, const std::string& note) {
            whole.Report(from + (to - from) * share, note);
          },
          whole.log};
}

void AddWay(const std::string& way, std::vector<Eigen::VectorXd> logs, Recognition* result) {
  CHECK_EQ(logs.size(), result->samples.size());
  for (std::size_t i = 0; i < logs.size(); ++i) result->samples[i].by_way[way] = std::move(logs[i]);
}

DrapePool TakePool(const RecognitionJob& job, const RunControl& control) {
  const FitSpec& fit = job.fits.fit;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(job.pool.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  const auto backend = MakeBackend(fit.backend, model, job.fits.threads);
  return ReadOrSimulatePool(job.pool_file, *backend, job.pool, control);
}

void AddPredictionWay(const RecognitionJob& job, const SampleList& list, const DrapePool& pool,
                      const RunControl& control, Recognition* result) {
  std::vector<DrapesOfSample> samples;
  for (const ListedSample& sample : list.samples) {
    std::vector<ObservedCapture> captures;
    for (const ObservedCapture* image : sample.images) captures.push_back(*image);
    samples.push_back({sample.fabric, ListTrainingDrapes(captures)});
  }
  std::vector<Eigen::VectorXd> logs =
      CompareByPredictions(pool, samples, list.num_fabrics(), job.distribution, control);
  result->cancelled = control.cancelled();
  if (result->cancelled) return;
  AddWay(kByEnergyScore, std::move(logs), result);
  AddProduct(kByPredictions, {kByEnergyScore}, &result->samples);
}

// Names of the cells that can be compared: with the posterior those that have one.
std::vector<std::string> FindSamples(const RecognitionJob& job, const RunControl& control,
                                     Recognition* result) {
  std::vector<std::string> names;
  if (!job.ways.posterior) {
    for (const FitCell& cell : job.cells) names.push_back(cell.name);
    return names;
  }
  FitCellRun fits = RunFitCells(job.fits, job.cells, control);
  result->cancelled = fits.cancelled;
  result->failures = std::move(fits.failures);
  return std::move(fits.done);
}

// Each way that was asked for, and then the products of two and three of them.
void ScoreWays(const RecognitionWays& ways, Recognition* result) {
  const auto score = [&](const char* way) {
    result->scores.push_back(
        ScoreWay(result->samples, way, static_cast<int>(result->fabrics.size())));
  };
  const auto multiply = [&](const char* way, const std::vector<std::string>& factors) {
    AddProduct(way, factors, &result->samples);
    score(way);
  };
  if (ways.posterior) score(kByPosterior);
  if (ways.features) score(kByFeatures);
  if (ways.predictions) score(kByPredictions);
  if (ways.posterior && ways.features) multiply("A and features", {kByPosterior, kByFeatures});
  if (ways.posterior && ways.predictions) multiply("A and B", {kByPosterior, kByEnergyScore});
  if (ways.predictions && ways.features) multiply("B and features", {kByEnergyScore, kByFeatures});
  if (ways.posterior && ways.predictions && ways.features)
    multiply("A, B and features", {kByPosterior, kByEnergyScore, kByFeatures});
  if (ways.posterior) {
    score(kByDensity);
    result->scores.back().by_drapes = false;
  }
}

}  // namespace

Recognition Recognise(const RecognitionJob& job, const RunControl& control) {
  const RecognitionWays& ways = job.ways;
  Recognition result;
  DrapePool pool;
  if (ways.predictions) {  // before hours of work: the file may be of another mesh
    pool = TakePool(job, PartOfRun(control, 0.0, kPoolShare));
    result.cancelled = pool.simulated < job.pool.drapes;
    if (result.cancelled) return result;
  }
  const std::vector<std::string> names =
      FindSamples(job, PartOfRun(control, kPoolShare, kFitShare), &result);
  if (result.cancelled) return result;
  const SampleList list = ListSamples(job.cells, names, job.images);
  result.fabrics = list.fabrics;
  for (const ListedSample& sample : list.samples)
    result.samples.push_back({sample.name, sample.fabric, {}});
  if (ways.posterior) {
    PosteriorLogs logs = CompareByPosterior(list, job.fits.out, job.by);
    AddWay(kByPosterior, std::move(logs.by_posterior), &result);
    AddWay(kByDensity, std::move(logs.by_density), &result);
  }
  if (ways.features) AddWay(kByFeatures, CompareByFeatures(list), &result);
  if (ways.predictions) {
    AddPredictionWay(job, list, pool, PartOfRun(control, kFitShare, 1.0), &result);
    if (result.cancelled) return result;
  }
  ScoreWays(ways, &result);
  return result;
}

std::string RecognitionReport(const Recognition& recognition) {
  std::vector<std::string> names;
  for (const int fabric : recognition.fabrics) names.push_back("fabric " + std::to_string(fabric));
  std::string text =
      Format(
          "# Recognition of %d samples of %d fabrics\n\nEach sample is left out with all its "
          "captures.\n\n",
          static_cast<int>(recognition.samples.size()), static_cast<int>(names.size())) +
      RecognitionText(recognition.scores, names);
  if (recognition.failures.empty()) return text;
  text += "\nWithout a result:\n\n";
  for (const FitFailure& failure : recognition.failures)
    text += "- " + failure.name + ": " + MakePrintableLine(failure.reason) + "\n";
  return text;
}

}  // namespace drape
