// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/bend_calibration.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr uint64_t kTrialStream = 0x5ca1e;  // of the prediction's seed
constexpr int kPerOctave = 4;               // lattice points
constexpr int kFirstStep = kPerOctave;      // one octave
constexpr int kFarthest = 4 * kPerOctave;   // a factor of 16

// Of a point of the lattice.
double FactorAt(int point) { return std::exp2(double(point) / kPerOctave); }

FeatureVector CalibrationScales() {
  FeatureVector scales = FeatureVector::Constant(std::numeric_limits<double>::infinity());
  scales.head<2>() = kFeatureScales.head<2>();  // drape coefficient, folds
  return scales;
}

// Of one face, or of all together.
class CompassSearch {
 public:
  CompassSearch(Backend& backend, const MaterialSource& materials,
                const PredictionOptions& prediction, std::vector<ObservedCapture> training,
                const CalibrationOptions& options, const std::function<void(int)>& progress,
                BendCalibration* found)
      : backend_(backend),
        materials_(materials),
        prediction_(prediction),
        training_(std::move(training)),
        options_(options),
        progress_(progress),
        found_(*found) {
    prediction_.specimens = options.specimens;
    prediction_.seed = SeedOfStream(prediction.seed, kTrialStream);
  }

  double Search() {
    best_value_ = ValueAt(best_);
    // A cloth so soft that it finds no rest is stiffened until it does.
    while (std::isinf(best_value_) && best_ < kFarthest && !found_.cancelled) {
      best_ += kFirstStep;
      best_value_ = ValueAt(best_);
    }
    for (int step = kFirstStep; step >= 1; step /= 2)
      while (Improve(step)) {
      }
    return std::isinf(best_value_) ? 1.0 : FactorAt(best_);
  }

 private:
  // Goes to the first neighbour that is better; the side that was is tried first.
  bool Improve(int step) {
    for (const int side : {side_, -side_}) {
      const int next = best_ + step * side;
      if (std::abs(next) > kFarthest || found_.cancelled) continue;
      const double value = ValueAt(next);
      if (!(value < best_value_)) continue;
      best_ = next;
      best_value_ = value;
      side_ = side;
      return true;
    }
    return false;
  }

  double ValueAt(int point) {
    const auto known = values_.find(point);
    if (known != values_.end()) return known->second;
    const auto& faces = prediction_.faces;
    BendTrial trial{faces.size() == 1 ? faces[0] : ClothFace::kUnknown, FactorAt(point)};
    trial.objective = Try(&trial);
    if (found_.cancelled) return std::numeric_limits<double>::infinity();
    found_.trials.push_back(trial);
    values_.emplace(point, trial.objective);
    if (progress_) progress_(static_cast<int>(found_.trials.size()));
    return trial.objective;
  }

  double Try(BendTrial* trial) {
    PredictionOptions options = prediction_;
    options.bend = {trial->factor, trial->factor};
    const std::vector<PredictedDrape> drapes = SampleDrapes(backend_, materials_, options);
    found_.cancelled = static_cast<int>(drapes.size()) < options.num_drapes();
    found_.drapes += static_cast<int>(drapes.size());
    trial->at_rest = static_cast<int>(ObservedDrapes(drapes, ClothFace::kUnknown).size());
    const auto score = ScorePrediction(drapes, training_, CalibrationScales());
    if (!score) return std::numeric_limits<double>::infinity();
    const double z = std::log(trial->factor) / options_.sigma;
    return double(training_.size()) * score->feature_energy + z * z / 2;
  }

  Backend& backend_;
  const MaterialSource& materials_;
  PredictionOptions prediction_;
  const std::vector<ObservedCapture> training_;
  const CalibrationOptions& options_;
  const std::function<void(int)>& progress_;
  BendCalibration& found_;
  int side_ = 1;
  int best_ = 0;
  double best_value_ = 0.0;
  std::map<int, double> values_;
};

std::vector<ObservedCapture> OfFace(const std::vector<ObservedCapture>& captures, ClothFace face) {
  std::vector<ObservedCapture> of_face;
  for (const ObservedCapture& seen : captures)
    if (seen.capture.face == face) of_face.push_back(seen);
  return of_face;
}

}  // namespace

BendCalibration CalibrateBend(Backend& backend, const MaterialSource& materials,
                              const PredictionOptions& prediction,
                              const std::vector<ObservedCapture>& training,
                              const CalibrationOptions& options,
                              const std::function<void(int)>& progress) {
  CHECK(!training.empty());
  CHECK_GT(options.sigma, 0.0);
  CHECK_GE(options.specimens, 2);
  BendCalibration found;
  const auto search = [&](const std::vector<ClothFace>& faces, std::vector<ObservedCapture> seen) {
    PredictionOptions on_faces = prediction;
    on_faces.faces = faces;
    return CompassSearch(backend, materials, on_faces, std::move(seen), options, progress, &found)
        .Search();
  };
  if (!OfFace(training, ClothFace::kUnknown).empty()) {
    const double factor = search(prediction.faces, training);
    found.factors = {factor, factor};
    return found;
  }
  const auto up = OfFace(training, ClothFace::kUp), down = OfFace(training, ClothFace::kDown);
  BendFactors& factors = found.factors;
  if (!up.empty()) factors.up = search({ClothFace::kUp}, up);
  factors.down = down.empty() ? factors.up : search({ClothFace::kDown}, down);
  if (up.empty()) factors.up = factors.down;
  return found;
}

}  // namespace drape
