// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/metrics/metrics.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "physics/util/text_format.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_job.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

FitData MakeData(const FitCellJob& job, const FitCell& cell) {
  FitData data;
  data.material = job.material;
  UseCaptures(cell.captures, &data);
  return data;
}

// The SHA-256 of the results in a fit's folder, without its summary, which has times; empty where a
// file is missing. Another study in the same folder may have replaced them.
std::string SumOfFit(const std::string& folder) {
  for (const char* name : {"/summary.json", "/posterior.json", "/base.json"})
    if (!fs::exists(folder + name)) return "";
  return Sha256(ReadOwnFile(folder + "/posterior.json") + ReadOwnFile(folder + "/base.json"));
}

json Failure(const std::string& reason) { return {{"failure", reason}}; }

std::optional<json> FitOne(const FitCellJob& job, const FitCell& cell, const RunControl& control) {
  const std::string folder = job.study.out + "/" + cell.name;
  FitSpec spec = job.fit;
  spec.threads = 1;
  const FolderFit fit = FitIntoFolder(spec, MakeData(job, cell), folder, job.provenance, control);
  if (fit.cancelled || control.cancelled()) return {};
  if (!fit.failure.empty()) return Failure(fit.failure);
  if (!fit.has_posterior) return Failure("the posterior could not be fitted");
  return json{{"folder", cell.name}, {"sha256", SumOfFit(folder)}};
}

// A cell with the files that the fit reads, up to the one that it refuses.
StudyCell MakeStudyCell(const FitCellJob& job, const FitCell& cell) {
  json input = {{"cell", cell.name}};
  for (const Capture& capture : cell.captures) input["captures"].push_back(capture.Name());
  return CheckedCell(cell.name, input, [&] {
    try {
      ReadFitInput(job.fit, MakeData(job, cell));
    } catch (const InputError&) {
    }
  });
}

// A distribution to be learned: of a fabric, or of it without one of its samples.
struct Learning {
  int fabric = 0;
  int without = -1;  // of the samples; −1: all count

  bool LearnsFrom(const std::vector<DrapesOfSample>& samples, int i) const {
    return samples[i].fabric == fabric && i != without;
  }
  // The samples that are compared with it.
  bool Predicts(const std::vector<DrapesOfSample>& samples, int i) const {
    return without >= 0 ? i == without : samples[i].fabric != fabric;
  }
};

std::vector<Learning> ListLearning(const std::vector<DrapesOfSample>& samples, int fabrics) {
  std::vector<Learning> list;
  for (int f = 0; f < fabrics; ++f) list.push_back({f});
  for (int i = 0; i < int(samples.size()); ++i) list.push_back({samples[i].fabric, i});
  return list;
}

// Mean over the captures of each face, summed over the faces. scores: of each drape.
double SumOverFaces(const std::vector<TrainingDrape>& drapes, const Eigen::VectorXd& scores) {
  Eigen::Array2d sum = Eigen::Array2d::Zero(), count = Eigen::Array2d::Zero();
  for (std::size_t j = 0; j < drapes.size(); ++j) {
    const int face = SpecimenDistribution::FaceIndex(drapes[j].face);
    sum[face] += scores[Eigen::Index(j)];
    ++count[face];
  }
  return (sum / count.max(1.0)).sum();
}

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

json ToJson(const NormalDistribution& seen) {
  json rows = json::array();
  for (const auto& row : seen.covariance.rowwise()) rows.push_back(row);
  return {{"mean", seen.mean}, {"covariance", rows}};
}

// Adds what the posterior of each sample shows in the directions that all samples determine, and
// its density.
void AddPosteriors(const SampleList& list, const RecognitionJob& job, json* recognition) {
  constexpr double kScatter = 0.1;  // of samples of a fabric, in logarithms
  std::vector<std::string> folders;
  for (const ListedSample& sample : list.samples)
    folders.push_back(job.fits.study.out + "/" + sample.name);
  const FabricBeliefs beliefs = ReadFabricBeliefs(folders, job.by);
  const int size = beliefs.frame.size();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const FabricBelief& belief : beliefs.fabrics)
    mean += beliefs.frame.ToPriorUnits(belief.theta).covariance / double(beliefs.fabrics.size());
  const DeterminedDirections leading = FindDetermined(mean, kMostLeading);
  if (leading.ratios.size() == 0)
    throw InputError(job.fits.study.out,
                     "the fits determine no direction, expected some with less than half of the "
                     "prior's deviation");
  (*recognition)["scales"]["posterior"] =
      std::vector<double>(leading.ratios.size(), kScatter / beliefs.frame.LogUnit());
  for (std::size_t i = 0; i < list.samples.size(); ++i) {
    json& sample = (*recognition)["samples"][i];
    sample["seen"]["posterior"] = ToJson(Evidence(beliefs.frame, beliefs.fabrics[i], leading.axes));
    sample["density"] = beliefs.fabrics[i].density;
  }
}

void AddFeatures(const SampleList& list, json* recognition) {
  (*recognition)["scales"]["features"] = std::vector<double>(2 * kNumFeatures, 1.0);
  for (std::size_t i = 0; i < list.samples.size(); ++i)
    (*recognition)["samples"][i]["seen"]["features"] = ToJson(FeaturesOfSample(list.samples[i]));
}

// False when cancelled.
bool AddPredictions(const SampleList& list, const DrapePool& pool,
                    const DistributionFitOptions& options, const RunControl& control,
                    json* recognition) {
  std::vector<DrapesOfSample> samples;
  for (const ListedSample& sample : list.samples) {
    std::vector<ObservedCapture> captures;
    for (const ObservedCapture* image : sample.images) captures.push_back(*image);
    samples.push_back({sample.fabric, ListTrainingDrapes(captures)});
  }
  const std::vector<Eigen::VectorXd> logs =
      CompareByPredictions(pool, samples, list.num_fabrics(), options, control);
  for (std::size_t i = 0; i < logs.size(); ++i)
    (*recognition)["samples"][i]["predictions"] = logs[i];
  return !logs.empty();
}

DrapePool TakePool(const RecognitionJob& job, const RunControl& control) {
  const FitSpec& fit = job.fits.fit;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(job.learning.pool.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  const auto backend = MakeBackend(fit.backend, model, job.fits.study.threads);
  return ReadOrSimulatePool(job.learning.pool_file, *backend, job.learning.pool, control);
}

}  // namespace

std::vector<FitCell> MakeFitCells(const std::vector<Capture>& captures, bool by_sample) {
  std::vector<FitCell> cells;
  for (const Capture& capture : captures) {
    std::string name = "fabric_" + std::to_string(capture.fabric);
    if (by_sample) name += "/sample_" + std::to_string(capture.sample);
    if (cells.empty() || cells.back().name != name) cells.push_back({std::move(name), {}});
    cells.back().captures.push_back(capture);
  }
  return cells;
}

FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control) {
  Study study;
  study.name = "posteriors";
  study.settings = job.settings;
  for (const FitCell& cell : cells)
    study.cells.push_back(job.study.list ? StudyCell{.name = cell.name} : MakeStudyCell(job, cell));
  study.run = [&](std::size_t k, const RunControl& part) { return FitOne(job, cells[k], part); };
  study.is_whole = [&](std::size_t k, const json& result) {
    return result.contains("failure") ||
           result.at("sha256") == SumOfFit(job.study.out + "/" + cells[k].name);
  };
  FitCellRun run;
  run.study = RunStudy(study, job.study, control);
  for (std::size_t k = 0; k < run.study.results.size(); ++k) {
    const auto& result = run.study.results[k];
    if (!result) continue;
    if (result->contains("failure"))
      run.failures.push_back({cells[k].name, result->at("failure")});
    else
      run.done.push_back(cells[k].name);
  }
  return run;
}

std::vector<Eigen::VectorXd> CompareByPredictions(const DrapePool& pool,
                                                  const std::vector<DrapesOfSample>& samples,
                                                  int fabrics,
                                                  const DistributionFitOptions& options,
                                                  const RunControl& control) {
  const std::vector<Learning> todo = ListLearning(samples, fabrics);
  const int count = static_cast<int>(samples.size());
  std::vector<Eigen::VectorXd> logs(count, Eigen::VectorXd(fabrics));
  DistributionFitOptions alone = options;
  alone.resamples = 0;
  alone.cross_validate = false;
  alone.threads = 1;
  std::mutex mutex;
  int done = 0;
  RunInThreads(static_cast<int>(todo.size()), options.threads, control.cancel, [&](int task) {
    const Learning& learning = todo[task];
    std::vector<TrainingDrape> training, held_out;
    for (int i = 0; i < count; ++i) {
      const std::vector<TrainingDrape>& drapes = samples[i].drapes;
      if (learning.LearnsFrom(samples, i))
        training.insert(training.end(), drapes.begin(), drapes.end());
      if (learning.Predicts(samples, i))
        held_out.insert(held_out.end(), drapes.begin(), drapes.end());
    }
    CHECK(!training.empty() && !held_out.empty());
    const SpecimenDistribution learned = FitDistribution(pool, training, alone, {}).best;
    const Eigen::VectorXd scores = ScoreDrapes(pool, learned, held_out, alone);
    Eigen::Index next = 0;
    for (int i = 0; i < count; ++i) {
      if (!learning.Predicts(samples, i)) continue;
      const auto size = static_cast<Eigen::Index>(samples[i].drapes.size());
      logs[i][learning.fabric] = -SumOverFaces(samples[i].drapes, scores.segment(next, size));
      next += size;
    }
    const std::scoped_lock lock(mutex);
    ++done;
    control.Report(double(done) / double(todo.size()),
                   Format("distribution %d of %d", done, static_cast<int>(todo.size())));
  });
  if (control.cancelled()) logs.clear();
  return logs;
}

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

std::optional<json> Recognise(const RecognitionJob& job, const RunControl& control) {
  DrapePool pool;
  const bool predicts = job.ways.contains("predictions");
  if (predicts) {  // before hours of work: the file may be of another mesh
    pool = TakePool(job, PartOfRun(control, 0.0, kPoolShare));
    if (pool.simulated < job.learning.pool.drapes) return {};
  }
  FitCellRun fits;
  const bool has_fits = job.ways.contains("posterior");
  if (has_fits) {
    fits = RunFitCells(job.fits, job.cells, PartOfRun(control, kPoolShare, kFitShare));
    if (fits.study.cancelled) return {};
  } else {
    for (const FitCell& cell : job.cells) fits.done.push_back(cell.name);
  }
  const SampleList list = ListSamples(job.cells, fits.done, job.images);
  json recognition = {{"fabrics", list.fabrics}, {"failures", json::array()}};
  for (const FitFailure& failure : fits.failures)
    recognition["failures"].push_back(
        {{"name", failure.name}, {"reason", MakePrintableLine(failure.reason)}});
  for (const ListedSample& sample : list.samples)
    recognition["samples"].push_back({{"name", sample.name}, {"fabric", sample.fabric}});
  if (has_fits) AddPosteriors(list, job, &recognition);
  if (job.ways.contains("features")) AddFeatures(list, &recognition);
  const RunControl last = PartOfRun(control, kFitShare, 1.0);
  if (predicts && !AddPredictions(list, pool, job.learning.fit, last, &recognition)) return {};
  return recognition;
}

}  // namespace drape
