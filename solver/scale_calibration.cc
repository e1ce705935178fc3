// SPDX-License-Identifier: Apache-2.0
#include "solver/scale_calibration.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "physics/random.h"

namespace drape {
namespace {

constexpr uint64_t kTrialStream = 0x5ca1e;  // of the prediction's seed
constexpr int kPerOctave = 4;               // lattice points
constexpr int kFirstStep = kPerOctave;      // one octave
constexpr int kFarthest = 4 * kPerOctave;   // a factor of 16

using Point = std::pair<int, int>;  // of the lattice: stretch, bend

ScaleFactors FactorsAt(const Point& point) {
  return {std::exp2(double(point.first) / kPerOctave),
          std::exp2(double(point.second) / kPerOctave)};
}

FeatureVector CalibrationScales() {
  FeatureVector scales = FeatureVector::Constant(std::numeric_limits<double>::infinity());
  scales.head<2>() = kFeatureScales.head<2>();  // drape coefficient, folds
  return scales;
}

// Of one face, or of all together.
class CompassSearch {
 public:
  CompassSearch(Backend& backend, const MaterialSource& materials,
                const PredictionOptions& prediction, std::vector<SeenCapture> learnt,
                const CalibrationOptions& options, const std::function<void(int)>& progress,
                ScaleCalibration* found)
      : backend_(backend),
        materials_(materials),
        prediction_(prediction),
        learnt_(std::move(learnt)),
        options_(options),
        progress_(progress),
        found_(*found) {
    prediction_.specimens = options.specimens;
    prediction_.seed = SeedOfStream(prediction.seed, kTrialStream);
  }

  ScaleFactors Search() {
    best_value_ = ValueAt(best_);
    // A cloth so soft that it finds no rest is stiffened until it does.
    while (std::isinf(best_value_) && best_.second < kFarthest && !found_.cancelled) {
      best_.second += kFirstStep;
      best_value_ = ValueAt(best_);
    }
    for (int step = kFirstStep; step >= 1; step /= 2)
      while (Improve(step)) {
      }
    return std::isinf(best_value_) ? ScaleFactors() : FactorsAt(best_);
  }

 private:
  // Goes to the first neighbour that is better; the direction that was is tried first.
  bool Improve(int step) {
    for (std::size_t k = 0; k < directions_.size() && !found_.cancelled; ++k) {
      const Point next{best_.first + step * directions_[k].first,
                       best_.second + step * directions_[k].second};
      if (std::max(std::abs(next.first), std::abs(next.second)) > kFarthest) continue;
      const double value = ValueAt(next);
      if (!(value < best_value_)) continue;
      best_ = next;
      best_value_ = value;
      std::rotate(directions_.begin(), directions_.begin() + k, directions_.begin() + k + 1);
      return true;
    }
    return false;
  }

  double ValueAt(const Point& point) {
    const auto known = values_.find(point);
    if (known != values_.end()) return known->second;
    const auto& faces = prediction_.faces;
    ScaleTrial trial{faces.size() == 1 ? faces[0] : ClothFace::kUnknown, FactorsAt(point)};
    trial.objective = Try(&trial);
    if (found_.cancelled) return std::numeric_limits<double>::infinity();
    found_.trials.push_back(trial);
    values_.emplace(point, trial.objective);
    if (progress_) progress_(static_cast<int>(found_.trials.size()));
    return trial.objective;
  }

  double Try(ScaleTrial* trial) {
    PredictionOptions options = prediction_;
    options.up = options.down = trial->factors;
    const std::vector<PredictedDrape> drapes = DrawDrapes(backend_, materials_, options);
    found_.cancelled = static_cast<int>(drapes.size()) < options.num_drapes();
    found_.drapes += static_cast<int>(drapes.size());
    trial->at_rest = static_cast<int>(SeenDrapes(drapes, ClothFace::kUnknown).size());
    const auto score = ScorePrediction(drapes, learnt_, CalibrationScales());
    if (!score) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d z =
        Eigen::Vector2d(std::log(trial->factors.stretch), std::log(trial->factors.bend)) /
        options_.sigma;
    return double(learnt_.size()) * score->feature_energy + z.squaredNorm() / 2;
  }

  Backend& backend_;
  const MaterialSource& materials_;
  PredictionOptions prediction_;
  const std::vector<SeenCapture> learnt_;
  const CalibrationOptions& options_;
  const std::function<void(int)>& progress_;
  ScaleCalibration& found_;
  // Bend first: the drape is more sensitive to it.
  std::array<Point, 4> directions_ = {Point{0, 1}, Point{0, -1}, Point{1, 0}, Point{-1, 0}};
  Point best_{0, 0};
  double best_value_ = 0.0;
  std::map<Point, double> values_;
};

std::vector<SeenCapture> OfFace(const std::vector<SeenCapture>& captures, ClothFace face) {
  std::vector<SeenCapture> of_face;
  for (const SeenCapture& seen : captures)
    if (seen.capture.face == face) of_face.push_back(seen);
  return of_face;
}

}  // namespace

ScaleCalibration CalibrateScales(Backend& backend, const MaterialSource& materials,
                                 const PredictionOptions& prediction,
                                 const std::vector<SeenCapture>& learnt,
                                 const CalibrationOptions& options,
                                 const std::function<void(int)>& progress) {
  CHECK(!learnt.empty());
  CHECK_GT(options.sigma, 0.0);
  CHECK_GE(options.specimens, 2);
  ScaleCalibration found;
  const auto search = [&](const std::vector<ClothFace>& faces, std::vector<SeenCapture> seen) {
    PredictionOptions on_faces = prediction;
    on_faces.faces = faces;
    return CompassSearch(backend, materials, on_faces, std::move(seen), options, progress, &found)
        .Search();
  };
  if (!OfFace(learnt, ClothFace::kUnknown).empty()) {
    found.up = found.down = search(prediction.faces, learnt);
    return found;
  }
  const auto up = OfFace(learnt, ClothFace::kUp), down = OfFace(learnt, ClothFace::kDown);
  if (!up.empty()) found.up = search({ClothFace::kUp}, up);
  found.down = down.empty() ? found.up : search({ClothFace::kDown}, down);
  if (up.empty()) found.up = found.down;
  return found;
}

}  // namespace drape
