// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/metrics/distribution_metrics.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/posterior/space/material_space.h"
#include "solver/studies/recognition/prediction_way.h"
#include "solver/studies/recognition/sample_model.h"

namespace drape {
namespace {

using Logs = std::vector<Eigen::VectorXd>;  // of all fabrics, for each sample

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

// The features of a sample's images, means over the captures of each face; shape [2·kNumFeatures].
// A capture of unknown face counts for both.
NormalDistribution FeaturesOfSample(const ListedSample& sample) {
  constexpr double kNotSeen = 1e6;  // variance of a feature of a face without a capture
  constexpr double kExact = 1e-8;   // variance of a measured feature
  NormalDistribution seen{Eigen::VectorXd::Zero(2 * kNumFeatures),
                          kExact * Eigen::MatrixXd::Identity(2 * kNumFeatures, 2 * kNumFeatures)};
  for (int face = 0; face < 2; ++face) {
    auto mean = seen.mean.segment(face * kNumFeatures, kNumFeatures);
    double count = 0.0;
    for (const ObservedCapture* image : sample.images) {
      if (image->capture.face == (face == 0 ? ClothFace::kDown : ClothFace::kUp)) continue;
      mean += ComputeFeatures(image->drape.shape).cwiseQuotient(kFeatureScales);
      ++count;
    }
    mean /= std::max(1.0, count);
    if (count == 0)
      seen.covariance.diagonal().segment(face * kNumFeatures, kNumFeatures).setConstant(kNotSeen);
  }
  return seen;
}

// Compares the features of each sample with those of the others [METHODS, P62].
Logs CompareByFeatures(const SampleList& list) {
  std::vector<SeenSample> seen;
  for (const ListedSample& sample : list.samples)
    seen.push_back({sample.fabric, FeaturesOfSample(sample)});
  return CompareWithOthers(seen, list.num_fabrics(), Eigen::VectorXd::Ones(2 * kNumFeatures));
}

FabricBeliefs ReadBeliefs(const SampleList& list, const RecognitionJob& job) {
  std::vector<std::string> folders;
  for (const ListedSample& sample : list.samples)
    folders.push_back(job.fits.out + "/" + sample.name);
  return ReadFabricBeliefs(folders, job.by);
}

// Compares each sample by its posterior, in the directions that all samples determine, with the
// posteriors of the others [METHODS, P62].
Logs CompareByPosterior(const SampleList& list, const FabricBeliefs& beliefs,
                        const std::string& folder) {
  constexpr double kScatter = 0.1;  // of samples of a fabric, in logarithms
  const int size = beliefs.frame.size();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const FabricBelief& belief : beliefs.fabrics)
    mean += beliefs.frame.ToPriorUnits(belief.theta).covariance / double(beliefs.fabrics.size());
  const DeterminedDirections leading = FindDetermined(mean, kMostLeading);
  if (leading.ratios.size() == 0)
    throw InputError(folder,
                     "the fits determine no direction, expected some with less than half of the "
                     "prior's deviation");
  std::vector<SeenSample> seen;
  for (std::size_t i = 0; i < list.samples.size(); ++i)
    seen.push_back(
        {list.samples[i].fabric, Evidence(beliefs.frame, beliefs.fabrics[i], leading.axes)});
  return CompareWithOthers(
      seen, list.num_fabrics(),
      Eigen::VectorXd::Constant(leading.ratios.size(), kScatter / beliefs.frame.LogUnit()));
}

// Compares the densities of fabrics, as if each sample were weighed.
Logs CompareByDensity(const SampleList& list, const FabricBeliefs& beliefs) {
  constexpr double kWeighing = 0.03;  // standard deviation of ln density
  Eigen::ArrayXd density(list.num_fabrics());
  for (std::size_t i = 0; i < list.samples.size(); ++i)
    density[list.samples[i].fabric] = beliefs.fabrics[i].density;
  Logs logs;
  for (const ListedSample& sample : list.samples) {
    const Eigen::ArrayXd off = (density / density[sample.fabric]).log() / kWeighing;
    logs.push_back(-0.5 * off.square().matrix());
  }
  return logs;
}

// Empty when cancelled.
Logs CompareByLearning(const SampleList& list, const DrapePool& pool,
                       const DistributionFitOptions& options, const RunControl& control) {
  std::vector<DrapesOfSample> samples;
  for (const ListedSample& sample : list.samples) {
    std::vector<ObservedCapture> captures;
    for (const ObservedCapture* image : sample.images) captures.push_back(*image);
    samples.push_back({sample.fabric, ListTrainingDrapes(captures)});
  }
  return CompareByPredictions(pool, samples, list.num_fabrics(), options, control);
}

DrapePool TakePool(const RecognitionJob& job, const RunControl& control) {
  const FitSpec& fit = job.fits.fit;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(job.pool.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  const auto backend = MakeBackend(fit.backend, model, job.fits.study.threads);
  return ReadOrSimulatePool(job.pool_file, *backend, job.pool, control);
}

nlohmann::json FailuresJson(const std::vector<FitFailure>& failures) {
  nlohmann::json list = nlohmann::json::array();
  for (const FitFailure& failure : failures)
    list.push_back({{"name", failure.name}, {"reason", MakePrintableLine(failure.reason)}});
  return list;
}

nlohmann::json RecognitionJson(const SampleList& list, const std::map<std::string, Logs>& ways) {
  nlohmann::json json = {{"fabrics", list.fabrics}, {"samples", nlohmann::json::array()}};
  for (std::size_t i = 0; i < list.samples.size(); ++i) {
    nlohmann::json by_way = nlohmann::json::object();
    for (const auto& [way, logs] : ways)
      by_way[way] = std::vector<double>(logs[i].begin(), logs[i].end());
    json["samples"].push_back(
        {{"name", list.samples[i].name}, {"fabric", list.samples[i].fabric}, {"by_way", by_way}});
  }
  return json;
}

}  // namespace

SampleList ListSamples(const std::vector<FitCell>& cells, const std::vector<std::string>& names,
                       const std::vector<ObservedCapture>& images) {
  std::map<int, std::vector<const FitCell*>> by_fabric;
  for (const FitCell& cell : cells)
    if (std::find(names.begin(), names.end(), cell.name) != names.end())
      by_fabric[cell.captures[0].fabric].push_back(&cell);
  std::erase_if(by_fabric, [](const auto& each) { return each.second.size() < 2; });
  if (by_fabric.size() < 2)
    throw InputError("option 'data'", Format("found %d fabric(s) with two samples or more to "
                                             "recognise, expected at least two",
                                             static_cast<int>(by_fabric.size())));
  SampleList list;
  for (const auto& [fabric, cells_of_fabric] : by_fabric) {
    for (const FitCell* cell : cells_of_fabric) {
      list.samples.push_back({cell->name, list.num_fabrics()});
      for (const ObservedCapture& image : images)
        if (image.capture.fabric == fabric && image.capture.sample == cell->captures[0].sample)
          list.samples.back().images.push_back(&image);
    }
    list.fabrics.push_back(fabric);
  }
  return list;
}

std::optional<nlohmann::json> Recognise(const RecognitionJob& job, const RunControl& control) {
  DrapePool pool;
  if (job.ways.predictions) {  // before hours of work: the file may be of another mesh
    pool = TakePool(job, PartOfRun(control, 0.0, kPoolShare));
    if (pool.simulated < job.pool.drapes) return {};
  }
  FitCellRun fits;
  if (job.ways.posterior) {
    fits = RunFitCells(job.fits, job.cells, PartOfRun(control, kPoolShare, kFitShare));
    if (fits.study.cancelled) return {};
  } else {
    for (const FitCell& cell : job.cells) fits.done.push_back(cell.name);
  }
  const SampleList list = ListSamples(job.cells, fits.done, job.images);
  std::map<std::string, Logs> ways;
  if (job.ways.posterior) {
    const FabricBeliefs beliefs = ReadBeliefs(list, job);
    ways["posterior"] = CompareByPosterior(list, beliefs, job.fits.out);
    ways["density"] = CompareByDensity(list, beliefs);
  }
  if (job.ways.features) ways["features"] = CompareByFeatures(list);
  if (job.ways.predictions) {
    ways["predictions"] =
        CompareByLearning(list, pool, job.distribution, PartOfRun(control, kFitShare, 1.0));
    if (control.cancelled()) return {};
  }
  nlohmann::json json = RecognitionJson(list, ways);
  json["failures"] = FailuresJson(fits.failures);
  return json;
}

}  // namespace drape
