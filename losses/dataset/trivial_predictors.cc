// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/trivial_predictors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "losses/dataset/dataset.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "physics/util/math/statistics.h"

namespace drape {
namespace {

constexpr size_t kMaxPairs = 2000;

constexpr double DrapeDistance::*kNumbers[] = {&DrapeDistance::mse, &DrapeDistance::iou,
                                               &DrapeDistance::profile_rms,
                                               &DrapeDistance::outline_hausdorff};

// The mean of each number separately.
DrapeDistance ComputeMean(const std::vector<DrapeDistance>& distances) {
  DrapeDistance mean;
  for (const auto number : kNumbers)
    for (const DrapeDistance& d : distances) mean.*number += d.*number / distances.size();
  return mean;
}

DrapeDistance ComputeMedian(const std::vector<DrapeDistance>& distances) {
  DrapeDistance median;
  for (const auto number : kNumbers) {
    std::vector<double> values;
    for (const DrapeDistance& d : distances) values.push_back(d.*number);
    std::sort(values.begin(), values.end());
    median.*number = Quantile(values, 0.5);
  }
  return median;
}

using Pair = std::pair<const ObservedCapture*, const ObservedCapture*>;  // predicted, held out

bool SameFace(const Capture& a, const Capture& b) {
  return a.face == b.face && a.face != ClothFace::kUnknown;
}

bool Repeats(const Capture& a, const Capture& b) {
  return a.fabric == b.fabric && a.sample == b.sample && SameFace(a, b) && a.capture != b.capture;
}

bool ShowsAnotherSample(const Capture& a, const Capture& b) {
  return a.fabric == b.fabric && a.sample != b.sample && SameFace(a, b);
}

template <class Related>
std::vector<Pair> MakePairs(const std::vector<ObservedCapture>& predicted,
                            const std::vector<ObservedCapture>& held_out, const Related& related) {
  std::vector<Pair> pairs;
  for (const ObservedCapture& b : held_out)
    for (const ObservedCapture& a : predicted)
      if (related(a.capture, b.capture)) pairs.emplace_back(&a, &b);
  return pairs;
}

std::vector<Pair> Thinned(const std::vector<Pair>& pairs) {
  if (pairs.size() <= kMaxPairs) return pairs;
  std::vector<Pair> thinned;
  for (size_t i = 0; i < kMaxPairs; ++i) thinned.push_back(pairs[i * pairs.size() / kMaxPairs]);
  return thinned;
}

// Samples of the normal distribution fitted to features of drapes (TrivialPredictors::normal).
Eigen::MatrixXd SampleNormalFeatures(const DistributionScorer::Drapes& drapes) {
  constexpr int kSamples = 1000;
  constexpr double kLeastDeviation = 1e-3;  // in units of kFeatureScales
  const Eigen::MatrixXd features =
      kFeatureScales.cwiseInverse().asDiagonal() * ComputeFeatures(drapes);
  const double n = static_cast<double>(drapes.size());
  const FeatureVector mean = features.rowwise().mean();
  const Eigen::MatrixXd centred = features.colwise() - mean;
  Eigen::MatrixXd covariance = 0.5 * (1.0 + 1.0 / n) / (n - 1.0) * centred * centred.transpose();
  covariance.diagonal() *= 2.0;
  covariance.diagonal().array() += kLeastDeviation * kLeastDeviation;
  std::mt19937_64 random(1);
  Eigen::MatrixXd samples(kNumFeatures, kSamples);
  for (double& value : samples.reshaped()) value = SampleNormal(random);
  samples = covariance.llt().matrixL() * samples;
  return kFeatureScales.asDiagonal() * (samples.colwise() + mean).eval();
}

// The trivial predictors of one split.
class Evaluation {
 public:
  Evaluation(const std::vector<ObservedCapture>& train,
             const std::vector<ObservedCapture>& held_out, const Camera& camera, bool aligned)
      : train_(train), held_out_(held_out), camera_(camera), aligned_(aligned) {}

  TrivialPredictors Run() {
    AddPairs("same sample, same face", MakePairs(held_out_, held_out_, Repeats));
    AddPairs("another sample, same face", MakePairs(train_, held_out_, ShowsAnotherSample));
    AddPairs("another fabric",
             Thinned(MakePairs(train_, held_out_, [](const Capture& a, const Capture& b) {
               return a.fabric != b.fabric;
             })));
    AddSummaries();
    return result_;
  }

 private:
  void AddRow(const std::string& name, const std::vector<DrapeDistance>& raw,
              const std::vector<DrapeDistance>& aligned = {}) {
    if (raw.empty()) return;
    PredictorRow row{name, static_cast<int>(raw.size()), ComputeMean(raw), ComputeMedian(raw)};
    if (!aligned.empty()) row.aligned_mean = ComputeMean(aligned);
    result_.rows.push_back(row);
  }

  void AddPairs(const std::string& name, const std::vector<Pair>& pairs) {
    std::vector<DrapeDistance> raw, aligned;
    for (const auto& [predicted, held_out] : pairs) {
      if (aligned_) {
        const DrapeComparison c = CompareDrapes(held_out->drape, predicted->drape, camera_);
        raw.push_back(c.raw);
        aligned.push_back(c.aligned);
      } else {
        raw.push_back(ComputeDistance(held_out->drape, predicted->drape));
      }
    }
    AddRow(name, raw, aligned);
  }

  // Predictors that summarise the training captures of the fabric and face.
  void AddSummaries() {
    // Captures of one sample and face get the same prediction.
    std::map<std::tuple<int, ClothFace, int>, std::vector<const ObservedCapture*>> groups;
    for (const ObservedCapture& seen : held_out_) {
      const Capture& c = seen.capture;
      groups[{c.fabric, c.face, c.sample}].push_back(&seen);
    }
    DistributionScorer scorer, normal;
    bool complete = !groups.empty(), known_area = complete;
    for (const auto& [key, group] : groups) {
      DistributionScorer::Drapes known, observed;
      for (const ObservedCapture& seen : train_)
        if (ShowsAnotherSample(seen.capture, group[0]->capture)) known.push_back(&seen.drape);
      for (const ObservedCapture* seen : group) observed.push_back(&seen->drape);
      complete &= known.size() >= 2;
      known_area &= !known.empty();
      if (known.size() >= 2) {
        scorer.Add(known, observed);
        normal.AddFeatures(SampleNormalFeatures(known), ComputeFeatures(observed));
      }
      if (!known.empty()) AddCircleAndGrey(known, observed);
    }
    AddRow("circle of the mean area", circle_);
    AddRow("grey mean image", grey_);
    if (complete) {
      result_.other_samples = scorer.Score();
      result_.normal = normal.Score();
    }
    if (known_area) result_.circle = circle_scorer_.Score();
  }

  void AddCircleAndGrey(const DistributionScorer::Drapes& known,
                        const DistributionScorer::Drapes& observed) {
    MeanImage images;
    double area = 0;
    for (const ObservedDrape* drape : known) {
      images.Add(drape->image);
      area += CoverageArea(drape->image, camera_) / static_cast<double>(known.size());
    }
    const ObservedDrape disc = ObserveDisc(std::sqrt(area / M_PI), camera_, DrapeDiscs());
    const GrayImage mean = images.Mean();
    circle_scorer_.Add({&disc, &disc}, observed);
    for (const ObservedDrape* drape : observed) {
      circle_.push_back(ComputeDistance(*drape, disc));
      grey_.push_back({.mse = MeanSquaredError(mean, drape->image)});
    }
  }

  const std::vector<ObservedCapture>& train_;
  const std::vector<ObservedCapture>& held_out_;
  const Camera camera_;
  const bool aligned_;
  std::vector<DrapeDistance> circle_, grey_;
  DistributionScorer circle_scorer_;
  TrivialPredictors result_;
};

Selection MakeSelection(const DatasetQuery& query) {
  return {.fabrics = ParseIndexList(query.fabric, "option 'data_fabric'"),
          .samples = ParseIndexList(query.samples, "option 'samples'"),
          .captures = ParseIndexList(query.captures, "option 'captures'"),
          .face = ParseClothFace(query.face)};
}

// The captures of `all` that are among the usable ones.
std::vector<Capture> Usable(const std::vector<Capture>& all, const std::vector<Capture>& usable) {
  std::vector<Capture> kept;
  for (const Capture& capture : all)
    for (const Capture& other : usable)
      if (capture.image == other.image) kept.push_back(other);
  return kept;
}

void UseStoredSplit(const DatasetQuery& query, const Dataset& dataset, DatasetReport* report) {
  const bool selects = !(query.fabric + query.samples + query.captures).empty();
  if (selects || query.face != "both") {
    throw InputError("option 'split'",
                     "a stored split names its captures, expected none of fabric, samples, "
                     "captures, face beside it");
  }
  report->split = ReadSplit(query.split, dataset);
  std::vector<Capture> both = report->split.train;
  both.insert(both.end(), report->split.held_out.begin(), report->split.held_out.end());
  report->captures = KeepUsable(both, &report->skipped);
  report->split.train = Usable(report->split.train, report->captures);
  report->split.held_out = Usable(report->split.held_out, report->captures);
}

void SampleSplit(const DatasetQuery& query, const Dataset& dataset, DatasetReport* report) {
  report->captures = KeepUsable(Select(dataset, MakeSelection(query)), &report->skipped);
  report->in_turn = query.train == 0;
  report->split = report->in_turn ? Split{0, report->captures, report->captures}
                                  : SplitBySample(report->captures, query.train, query.seed);
}

}  // namespace

std::vector<ObservedCapture> ObserveCaptures(const std::vector<Capture>& captures,
                                             const Camera& camera) {
  std::vector<ObservedCapture> seen;
  for (const Capture& capture : captures) {
    const GrayImage image = ReadSilhouette(capture.image).image;
    seen.push_back({capture, ObserveImage(image, camera, DrapeDiscs(), capture.image)});
  }
  return seen;
}

TrivialPredictors EvaluateTrivialPredictors(const std::vector<ObservedCapture>& train,
                                            const std::vector<ObservedCapture>& held_out,
                                            const Camera& camera, bool aligned) {
  return Evaluation(train, held_out, camera, aligned).Run();
}

DatasetReport EvaluateDataset(const DatasetQuery& query, const Camera& camera,
                              const RunControl& control) {
  const Dataset dataset = ReadDataset(query.folder);
  DatasetReport report;
  report.training_images = dataset.training_images;
  report.skipped = dataset.skipped;
  report.notes = dataset.notes;
  if (query.split.empty()) {
    SampleSplit(query, dataset, &report);
  } else {
    UseStoredSplit(query, dataset, &report);
  }
  if (!query.save_split.empty() && report.in_turn)
    throw InputError("option 'save_split'", "there is no split to store with train = 0");
  if (control.cancelled()) return report;
  report.seen_train = ObserveCaptures(report.split.train, camera);
  report.seen_held_out =
      report.in_turn ? report.seen_train : ObserveCaptures(report.split.held_out, camera);
  report.predictors =
      EvaluateTrivialPredictors(report.seen_train, report.seen_held_out, camera, query.aligned);
  if (!query.save_split.empty()) WriteSplit(query.save_split, report.split);
  return report;
}

}  // namespace drape
