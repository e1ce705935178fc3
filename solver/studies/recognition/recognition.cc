// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/studies/recognition/drape_predictions.h"
#include "solver/studies/recognition/fitted_samples.h"

namespace drape {
namespace {

constexpr double kNotSeen = 1e6;    // variance of a feature of a face that has no capture
constexpr double kExact = 1e-8;     // variance of a measured feature
constexpr double kWeighing = 0.03;  // standard deviation of ln density
constexpr double kFitShare = 0.7;   // of the time

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

// Σ over the sample's captures of ln p(features | predicted drapes of the face).
double SyntheticLogLikelihood(const RecognitionJob& job, const FittedSamples& samples,
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

void AddDrapeWay(const RecognitionJob& job, const FittedSamples& samples, Recognition* result) {
  const std::vector<PredictionCell> cells = ListPredictions(samples);
  std::map<std::string, PredictedFeatures> predicted;
  for (const PredictionCell& cell : cells) {
    try {
      predicted[cell.name] = ReadPrediction(job, cell);
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
Eigen::VectorXd DensityLogs(const FittedSamples& samples, int fabric) {
  Eigen::VectorXd density(samples.fabrics.size());
  for (const FittedSample& sample : samples.fitted) density[sample.fabric] = sample.belief.density;
  return -0.5 * ((density.array() / density[fabric]).log() / kWeighing).square();
}

void AddFitWays(const RecognitionJob& job, const FittedSamples& samples, Recognition* result) {
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

// The part of a run from one share of its time to another.
RunControl PartOfRun(const RunControl& whole, double from, double to) {
  return {whole.cancel,
          [&whole, from, to](double share, const std::string& note) {
            whole.Report(from + (to - from) * share, note);
          },
          whole.log};
}

RunControl FitPart(const RecognitionJob& job, const RunControl& whole) {
  return PartOfRun(whole, 0.0, job.draws > 0 ? kFitShare : 1.0);
}

// Those of the names that have all fits that they need.
std::vector<PredictionCell> FindPredictions(const std::vector<std::string>& own,
                                            const FittedSamples& samples) {
  std::vector<PredictionCell> cells = ListPredictions(samples);
  std::erase_if(cells, [&](const PredictionCell& cell) {
    return std::find(own.begin(), own.end(), cell.name) == own.end();
  });
  return cells;
}

// Predicts what is of the share once all fits have ended; adds to what the share has done.
void AddPredictions(const RecognitionJob& job, const std::vector<std::string>& own,
                    const RunControl& control, RecognitionShare* share) {
  const FitCellRun fits = FindFits(job.fits, job.cells);
  if (!fits.missing.empty()) {
    share->waiting = own.size();
    return;
  }
  const FittedSamples samples = CollectSamples(job, fits.done);
  const std::vector<PredictionCell> cells = FindPredictions(own, samples);
  share->cancelled = !RunPredictions(job, samples, cells, PartOfRun(control, kFitShare, 1.0));
  share->done += own.size() - cells.size();  // without a fit there is nothing to predict
  for (const PredictionCell& cell : cells) share->done += HasPrediction(job, samples, cell);
}

}  // namespace

std::vector<std::string> ListRecognitionCells(const RecognitionJob& job) {
  std::vector<std::string> names;
  for (const FitCell& cell : job.cells) names.push_back(cell.name);
  if (job.draws > 0)
    for (const std::string& name : ListPredictionNames(job.cells))
      names.push_back("prediction/" + name);
  return names;
}

RecognitionShare RunRecognitionShare(const RecognitionJob& job, const RunControl& control) {
  CheckPredictionSettings(job);
  const std::vector<FitCell> own = CellsOfShare(job.cells, *job.share);
  const FitCellRun fits = RunFitCells(job.fits, own, FitPart(job, control));
  RecognitionShare share{.cancelled = fits.cancelled,
                         .cells = own.size(),
                         .done = fits.done.size() + fits.failures.size(),
                         .failures = fits.failures};
  std::vector<std::string> predictions;
  if (job.draws > 0) {
    const std::vector<std::string> all = ListPredictionNames(job.cells);
    for (std::size_t k = 0; k < all.size(); ++k)
      if (job.share->Has(job.cells.size() + k)) predictions.push_back(all[k]);
  }
  share.cells += predictions.size();
  if (!share.cancelled && !predictions.empty()) AddPredictions(job, predictions, control, &share);
  return share;
}

Recognition Recognise(const RecognitionJob& job, const RunControl& control) {
  CheckPredictionSettings(job);
  FitCellRun fits = RunFitCells(job.fits, job.cells, FitPart(job, control));
  Recognition result{.cancelled = fits.cancelled, .failures = std::move(fits.failures)};
  if (result.cancelled) return result;
  const FittedSamples samples = CollectSamples(job, fits.done);
  result.fabrics = samples.fabrics;
  result.cancelled = job.draws > 0 && !RunPredictions(job, samples, ListPredictions(samples),
                                                      PartOfRun(control, kFitShare, 1.0));
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
