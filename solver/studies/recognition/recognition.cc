// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "cuda/make_backend.h"
#include "losses/dataset/index_list.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "solver/posterior/space/material_space.h"
#include "solver/prediction/bend_calibration.h"
#include "solver/studies/recognition/sample_model.h"

namespace drape {
namespace {

constexpr StoredFormat kFormat = {"drapefit-recognition-prediction", 1};
constexpr double kNotSeen = 1e6;    // variance of a feature of a face that has no capture
constexpr double kExact = 1e-8;     // variance of a measured feature
constexpr double kFitShare = 0.7;   // of the time
constexpr double kWeighing = 0.03;  // standard deviation of ln density
constexpr int kWithoutNone = 0;

// A sample with its posterior in common coordinates.
struct FittedSample {
  const FitCell* cell = nullptr;
  int fabric = 0, sample = 0;  // from 0 among the fabrics; number in the data set
  FabricBelief belief;
};

struct Samples {
  SpaceFrame frame;
  std::vector<int> fabrics;  // numbers in the data set
  std::vector<FittedSample> fitted;
  DeterminedDirections leading;  // of all samples
  Eigen::VectorXd centre;        // mean of all posteriors, in z
};

// Of fabrics with at least two samples; a fabric with one cannot be recognised by the others.
Samples CollectSamples(const RecognitionJob& job, const std::vector<std::string>& done) {
  std::map<int, std::vector<const FitCell*>> by_fabric;
  for (const FitCell& cell : job.cells)
    if (std::find(done.begin(), done.end(), cell.name) != done.end())
      by_fabric[cell.captures[0].fabric].push_back(&cell);
  std::erase_if(by_fabric, [](const auto& each) { return each.second.size() < 2; });
  if (by_fabric.size() < 2)
    throw InputError("option 'data'", Format("found %d fabric(s) with two fitted samples or more, "
                                             "expected at least two",
                                             static_cast<int>(by_fabric.size())));
  Samples samples;
  std::vector<std::string> folders;
  for (const auto& [fabric, cells] : by_fabric) {
    for (const FitCell* cell : cells) {
      samples.fitted.push_back(
          {cell, static_cast<int>(samples.fabrics.size()), cell->captures[0].sample, {}});
      folders.push_back(job.fits.out + "/" + cell->name);
    }
    samples.fabrics.push_back(fabric);
  }
  FabricBeliefs beliefs = ReadFabricBeliefs(folders, job.by);
  samples.frame = beliefs.frame;
  const int size = samples.frame.size();
  samples.centre = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < folders.size(); ++i) {
    samples.fitted[i].belief = std::move(beliefs.fabrics[i]);
    const NormalDistribution z = samples.frame.ToPriorUnits(samples.fitted[i].belief.theta);
    mean += z.covariance / double(folders.size());
    samples.centre += z.mean / double(folders.size());
  }
  samples.leading = FindDetermined(mean, kMostLeading);
  if (samples.leading.ratios.size() == 0)
    throw InputError(job.fits.out,
                     "the fits determine no direction, expected some with less than "
                     "half of the prior's deviation");
  return samples;
}

// without: of the fitted samples; −1: none is left out.
SampleModel ModelOfPosteriors(const Samples& samples, int without) {
  std::vector<SeenSample> seen;
  for (int i = 0; i < int(samples.fitted.size()); ++i)
    if (i != without)
      seen.push_back({samples.fitted[i].fabric,
                      Evidence(samples.frame, samples.fitted[i].belief, samples.leading.axes)});
  constexpr double kScatter = 0.1;  // log units, of samples of a fabric
  const auto d = samples.leading.ratios.size();
  return {seen, static_cast<int>(samples.fabrics.size()),
          Eigen::VectorXd::Constant(d, kScatter / samples.frame.LogUnit())};
}

Eigen::VectorXd ScaledFeatures(const ObservedDrape& drape) {
  return ComputeFeatures(drape.shape).cwiseQuotient(kFeatureScales);
}

// Means over the captures of each face, shape [2·kNumFeatures]; a capture of unknown face counts
// for both.
NormalDistribution FeaturesOfSample(const RecognitionJob& job, const FittedSample& sample) {
  NormalDistribution seen{Eigen::VectorXd::Zero(2 * kNumFeatures),
                          kExact * Eigen::MatrixXd::Identity(2 * kNumFeatures, 2 * kNumFeatures)};
  Eigen::Vector2d count = Eigen::Vector2d::Zero();
  for (const ObservedCapture& image : job.images) {
    if (image.capture.fabric != sample.cell->captures[0].fabric ||
        image.capture.sample != sample.sample)
      continue;
    for (int face = 0; face < 2; ++face) {
      if (image.capture.face == (face == 0 ? ClothFace::kDown : ClothFace::kUp)) continue;
      seen.mean.segment(face * kNumFeatures, kNumFeatures) += ScaledFeatures(image.drape);
      ++count[face];
    }
  }
  for (int face = 0; face < 2; ++face) {
    seen.mean.segment(face * kNumFeatures, kNumFeatures) /= std::max(1.0, count[face]);
    if (count[face] == 0)
      seen.covariance.diagonal().segment(face * kNumFeatures, kNumFeatures).setConstant(kNotSeen);
  }
  return seen;
}

// A prediction: features of the drapes of a fabric, without one of its samples.
struct PredictionCell {
  int fabric = 0;             // from 0
  int without = -1;           // of the fitted samples; −1: all count
  std::string name;           // of the file
  std::vector<int> training;  // numbers of the samples that count
};

std::vector<PredictionCell> ListPredictions(const Samples& samples) {
  std::vector<PredictionCell> cells;
  for (int f = 0; f < int(samples.fabrics.size()); ++f)
    cells.push_back({f, -1, "fabric_" + std::to_string(samples.fabrics[f]), {}});
  for (int i = 0; i < int(samples.fitted.size()); ++i)
    cells.push_back({samples.fitted[i].fabric,
                     i,
                     Format("fabric_%d_without_%d", samples.fabrics[samples.fitted[i].fabric],
                            samples.fitted[i].sample),
                     {}});
  return cells;
}

std::string PredictionFile(const RecognitionJob& job, const PredictionCell& cell) {
  return job.fits.out + "/prediction/" + cell.name + ".json";
}

// Specimens of the fabric as the model has it; directions that the data do not determine are at
// the mean of all fits.
MaterialSource MakeSpecimens(const Samples& samples, const PredictionCell& cell) {
  const SampleModel model = ModelOfPosteriors(samples, cell.without);
  const NormalDistribution& fabric = model.fabric(cell.fabric);
  const Eigen::MatrixXd axes = samples.leading.axes;
  const Eigen::MatrixXd root = (fabric.covariance + model.within()).llt().matrixL();
  const Eigen::VectorXd rest = samples.centre - axes * (axes.transpose() * samples.centre);
  double density = 0.0;
  for (const FittedSample& sample : samples.fitted)
    if (sample.fabric == cell.fabric) density = sample.belief.density;
  return [=, mean = fabric.mean, frame = samples.frame](int specimen) {
    std::mt19937_64 random(SeedOfStream(static_cast<uint64_t>(cell.fabric), specimen));
    Eigen::VectorXd noise(mean.size());
    for (double& value : noise) value = SampleNormal(random);
    const Eigen::VectorXd z = rest + axes * (mean + root * noise);
    return frame.Table(frame.prior_root * z, density);
  };
}

nlohmann::json FeatureRows(const std::vector<PredictedDrape>& drapes, ClothFace face) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ObservedDrape* drape : ObservedDrapes(drapes, face)) {
    const Eigen::VectorXd features = ScaledFeatures(*drape);
    rows.push_back(std::vector<double>(features.begin(), features.end()));
  }
  return rows;
}

std::vector<ObservedCapture> TrainingImages(const RecognitionJob& job, const Samples& samples,
                                            const PredictionCell& cell) {
  std::vector<ObservedCapture> training;
  const int left_out = cell.without >= 0 ? samples.fitted[cell.without].sample : kWithoutNone;
  for (const ObservedCapture& image : job.images)
    if (image.capture.fabric == samples.fabrics[cell.fabric] && image.capture.sample != left_out)
      training.push_back(image);
  return training;
}

void RunPredictionCell(const RecognitionJob& job, const Samples& samples,
                       const PredictionCell& cell, const std::atomic<bool>* cancel) {
  const FitSpec& fit = job.fits.fit;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(fit.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  const auto backend = MakeBackend(fit.backend, model, 1);
  PredictionOptions options = job.prediction;
  options.faces = {ClothFace::kUp, ClothFace::kDown};
  options.specimens = std::max(2, job.draws / options.drapes_of_specimen());
  options.settle.steps.cancel = options.settle.equilibrium.cancel = cancel;
  options.batch = SettleBatchSize(*backend, 1);
  const MaterialSource materials = MakeSpecimens(samples, cell);
  if (job.calibrate)
    options.bend =
        CalibrateBend(*backend, materials, options, TrainingImages(job, samples, cell), {}).factors;
  const std::vector<PredictedDrape> drapes = SampleDrapes(*backend, materials, options);
  if (cancel != nullptr && cancel->load()) return;
  WriteStoredJson(PredictionFile(job, cell), kFormat,
                  {{"up", FeatureRows(drapes, ClothFace::kUp)},
                   {"down", FeatureRows(drapes, ClothFace::kDown)}},
                  1);
}

// Moments of each face; none where a file is missing, damaged or of too few drapes at rest.
struct PredictedFeatures {
  std::array<NormalDistribution, 2> face;
};

Eigen::MatrixXd ReadFeatures(const JsonInput& input) {
  const int count = input.ExpectArray().Size();
  if (count <= kNumFeatures) input.Fail("the features of more drapes at rest");
  Eigen::MatrixXd features(kNumFeatures, count);
  for (int i = 0; i < count; ++i) features.col(i) = input.At(i).Vector(kNumFeatures);
  return features;
}

PredictedFeatures ReadPrediction(const std::string& path) {
  const nlohmann::json file = ReadStoredJson(path, kFormat);
  const JsonInput input(file, path);
  PredictedFeatures predicted;
  for (int face = 0; face < 2; ++face) {
    const Eigen::MatrixXd features = ReadFeatures(input.At(face == 0 ? "up" : "down"));
    const ShrunkMoments moments = EstimateShrunkMoments(features);
    predicted.face[face] = {moments.mean,
                            moments.covariance * (1.0 + 1.0 / double(features.cols()))};
  }
  return predicted;
}

// Σ over the sample's captures of ln p(features | predicted drapes of the face).
double SyntheticLogLikelihood(const RecognitionJob& job, const Samples& samples,
                              const FittedSample& sample, const PredictedFeatures& predicted) {
  double sum = 0.0;
  for (const ObservedCapture& image : job.images) {
    if (image.capture.fabric != samples.fabrics[sample.fabric] ||
        image.capture.sample != sample.sample)
      continue;
    const Eigen::VectorXd features = ScaledFeatures(image.drape);
    const double up = LogDensity(predicted.face[0], features);
    const double down = LogDensity(predicted.face[1], features);
    if (image.capture.face == ClothFace::kUnknown)
      sum += std::max(up, down) + std::log1p(std::exp(-std::abs(up - down))) - std::log(2.0);
    else
      sum += image.capture.face == ClothFace::kUp ? up : down;
  }
  return sum;
}

// Predicts what is missing. False when it was cancelled.
bool RunPredictions(const RecognitionJob& job, const Samples& samples, const RunControl& control) {
  std::filesystem::create_directories(job.fits.out + "/prediction");
  std::vector<PredictionCell> todo;
  for (PredictionCell& cell : ListPredictions(samples))
    if (!std::filesystem::exists(PredictionFile(job, cell))) todo.push_back(std::move(cell));
  std::mutex mutex;
  int done = 0;
  RunCells(static_cast<int>(todo.size()), job.fits.threads, control.cancel, [&](int i) {
    RunPredictionCell(job, samples, todo[i], control.cancel);
    const std::scoped_lock lock(mutex);
    ++done;
    control.Report(kFitShare + (1 - kFitShare) * done / double(todo.size()),
                   Format("prediction %d of %d", done, static_cast<int>(todo.size())));
  });
  return !control.cancelled();
}

void AddDrapeWay(const RecognitionJob& job, const Samples& samples, Recognition* result) {
  const std::vector<PredictionCell> cells = ListPredictions(samples);
  std::map<std::string, PredictedFeatures> predicted;
  for (const PredictionCell& cell : cells) {
    try {
      predicted[cell.name] = ReadPrediction(PredictionFile(job, cell));
    } catch (const InputError& error) {
      result->failures.push_back({"prediction/" + cell.name, error.what()});
    }
  }
  const auto fabrics = samples.fabrics.size();
  for (std::size_t i = 0; i < samples.fitted.size(); ++i) {
    Eigen::VectorXd logs(fabrics);
    bool complete = true;
    for (std::size_t f = 0; f < fabrics; ++f) {
      const bool own = int(f) == samples.fitted[i].fabric;
      const auto found = predicted.find(own ? cells[fabrics + i].name : cells[f].name);
      complete &= found != predicted.end();
      if (complete)
        logs[Eigen::Index(f)] =
            SyntheticLogLikelihood(job, samples, samples.fitted[i], found->second);
    }
    if (complete) result->samples[i].by_way[kByDrapes] = logs;
  }
}

// By the density of the fabric, as if weighed with an error.
Eigen::VectorXd DensityLogs(const Samples& samples, int fabric) {
  Eigen::VectorXd density(samples.fabrics.size());
  for (const FittedSample& sample : samples.fitted) density[sample.fabric] = sample.belief.density;
  return -0.5 * ((density.array() / density[fabric]).log() / kWeighing).square();
}

void AddFitWays(const RecognitionJob& job, const Samples& samples, Recognition* result) {
  const int count = static_cast<int>(samples.fitted.size());
  std::vector<SeenSample> features;
  for (const FittedSample& sample : samples.fitted)
    features.push_back({sample.fabric, FeaturesOfSample(job, sample)});
  for (int i = 0; i < count; ++i) {
    const FittedSample& sample = samples.fitted[i];
    RecognisedSample recognised{sample.cell->name, sample.fabric, {}};
    recognised.by_way[kByPosterior] =
        ModelOfPosteriors(samples, i)
            .LogLikelihoods(Evidence(samples.frame, sample.belief, samples.leading.axes));
    std::vector<SeenSample> others = features;
    others.erase(others.begin() + i);
    const SampleModel model(others, static_cast<int>(samples.fabrics.size()),
                            Eigen::VectorXd::Ones(2 * kNumFeatures));
    recognised.by_way[kByFeatures] = model.LogLikelihoods(features[i].seen);
    recognised.by_way[kByDensity] = DensityLogs(samples, sample.fabric);
    result->samples.push_back(std::move(recognised));
  }
}

}  // namespace

Recognition Recognise(const RecognitionJob& job, const RunControl& control) {
  const RunControl of_fits{
      control.cancel,
      [&](double share, const std::string& note) { control.Report(kFitShare * share, note); },
      control.log};
  FitCellRun fits = RunFitCells(job.fits, job.cells, of_fits);
  Recognition result{.cancelled = fits.cancelled, .failures = std::move(fits.failures)};
  if (result.cancelled) return result;
  const Samples samples = CollectSamples(job, fits.done);
  result.fabrics = samples.fabrics;
  result.cancelled = job.draws > 0 && !RunPredictions(job, samples, control);
  if (result.cancelled) return result;
  AddFitWays(job, samples, &result);
  std::vector<std::string> ways = {kByPosterior, kByFeatures};
  AddProduct("A and features", ways, &result.samples);
  ways.emplace_back("A and features");
  if (job.draws > 0) {
    AddDrapeWay(job, samples, &result);
    AddProduct("B and features", {kByDrapes, kByFeatures}, &result.samples);
    AddProduct("A, B and features", {kByPosterior, kByDrapes, kByFeatures}, &result.samples);
    for (const char* way : {kByDrapes, "B and features", "A, B and features"})
      ways.emplace_back(way);
  }
  ways.emplace_back(kByDensity);
  for (const std::string& way : ways)
    result.scores.push_back(
        ScoreWay(result.samples, way, static_cast<int>(samples.fabrics.size())));
  result.scores.back().by_drapes = false;
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
