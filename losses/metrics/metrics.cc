// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/metrics.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kSupersample = 4;
constexpr double kFarthest = 1e6;  // [px] from the corner, where no drape can be

double PixelOrWhite(const GrayImage& image, int column, int row) {
  const bool inside = column >= 0 && row >= 0 && column < image.width && row < image.height;
  return inside ? image.at(column, row) : 0.0;
}

// The image of its size whose pixels are bilinear samples at place_of(column, row).
GrayImage Resampled(const GrayImage& image, const auto& place_of) {
  GrayImage result(image.width, image.height);
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const Eigen::Vector2d place = place_of(column, row);
      const int c = static_cast<int>(std::floor(place.x()));
      const int r = static_cast<int>(std::floor(place.y()));
      const double u = place.x() - c, v = place.y() - r;
      result.at(column, row) = static_cast<float>(
          (1 - v) * ((1 - u) * PixelOrWhite(image, c, r) + u * PixelOrWhite(image, c + 1, r)) +
          v * ((1 - u) * PixelOrWhite(image, c, r + 1) + u * PixelOrWhite(image, c + 1, r + 1)));
    }
  return result;
}

void CheckSameSize(const GrayImage& a, const GrayImage& b) {
  CHECK_EQ(a.width, b.width);
  CHECK_EQ(a.height, b.height);
  CHECK(!a.coverage.empty());
}

nlohmann::ordered_json IntervalJson(const IntervalSkill& skill) {
  return {{"nominal", skill.nominal}, {"coverage", skill.coverage}, {"width", skill.width}};
}

using Drapes = DistributionScorer::Drapes;

// The outlines [m] divided by √K, so that Euclidean distances are root mean squares.
Eigen::MatrixXd OutlineMatrix(const Drapes& drapes) {
  Eigen::MatrixXd outlines(kObservedAngles, drapes.size());
  for (size_t i = 0; i < drapes.size(); ++i)
    outlines.col(i) = drapes[i]->radius / std::sqrt(double(kObservedAngles));
  return outlines;
}

GrayImage ComputeMean(const Drapes& drapes) {
  MeanImage mean;
  for (const ObservedDrape* drape : drapes) mean.Add(drape->image);
  return mean.Mean();
}

void AddInterval(const std::vector<double>& samples, double probability, double observed,
                 IntervalSkill* sum) {
  const CentralInterval interval = ComputeInterval(samples, probability);
  sum->nominal += interval.nominal;
  sum->coverage += interval.Contains(observed);
  sum->width += interval.high - interval.low;
}

void Divide(double count, IntervalSkill* sum) {
  for (double* value : {&sum->nominal, &sum->coverage, &sum->width}) *value /= count;
}

// The value at rank `rank`, from 1 to the number of values, with linear interpolation between
// values.
double AtRank(const std::vector<double>& sorted, double rank) {
  const double last = static_cast<double>(sorted.size()) - 1;
  const double position = std::clamp(rank - 1, 0.0, last);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - below) * (sorted[above] - sorted[below]);
}

// The best of 360 rotations times two flips by least squares of the outlines, refined between the
// angles.
Alignment AlignDrapes(const ObservedDrape& a, const ObservedDrape& b) {
  const OutlineMatch match = RefineRotation(
      a.radius, b.radius, MatchOutlines(a.radius, b.radius, OutlineFreedom::kRotationAndMirror));
  return {std::remainder(match.rotation, 2 * M_PI), match.mirrored};
}

}  // namespace

ObservedDrape ObserveImage(const GrayImage& image, const Camera& camera, const DrapeDiscs& discs,
                           const std::string& where) {
  if (image.width != camera.width || image.height != camera.height) {
    throw InputError(where, "image is " + std::to_string(image.width) + "x" +
                                std::to_string(image.height) + ", expected the camera's " +
                                std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  Outline outline;
  if (!OutlineFromImage(image, camera, kObservedAngles, &outline)) {
    throw InputError(
        where, "the outline has gaps: no cloth at " + std::to_string(outline.missing.size()) +
                   " of " + std::to_string(kObservedAngles) + " angles about the camera's centre");
  }
  ObservedDrape drape{image, VerticalProfile(outline.radius, camera, discs), {}, discs};
  drape.shape = MeasureShape(drape.radius, discs);
  return drape;
}

ObservedDrape ObserveSurface(const ObjSurface& surface, const Camera& camera,
                             const DrapeDiscs& discs, const std::string& where) {
  Eigen::Matrix2Xd points;
  if (!ProjectVertices(surface.x, camera, &points) || points.cwiseAbs().maxCoeff() > kFarthest)
    throw InputError(where, "a vertex is not in front of the camera");
  return ObserveImage(Rasterize(surface, camera, kSupersample), camera, discs, where);
}

ObservedDrape ObserveDisc(double radius, const Camera& camera, const DrapeDiscs& discs) {
  CHECK_GT(radius, 0);
  const double radius_px = radius * camera.pixels_per_metre();
  GrayImage image(camera.width, camera.height);
  constexpr int kSamples = kSupersample * kSupersample;
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      int inside = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double x = col - camera.cx + (i % kSupersample + 0.5) / kSupersample - 0.5;
        const double y = row - camera.cy + (i / kSupersample + 0.5) / kSupersample - 0.5;
        inside += x * x + y * y <= radius_px * radius_px;
      }
      image.at(col, row) = static_cast<float>(inside) / kSamples;
    }
  }
  return ObserveImage(image, camera, discs, "disc");
}

GrayImage TurnedImage(const GrayImage& image, const Camera& camera, double rotation,
                      bool mirrored) {
  const double c = std::cos(rotation), s = std::sin(rotation), sign = mirrored ? -1 : 1;
  return Resampled(image, [&](int column, int row) {
    const double x = column - camera.cx, y = camera.cy - row;
    const double from_x = c * x + s * y, from_y = sign * (c * y - s * x);
    return Eigen::Vector2d(camera.cx + from_x, camera.cy - from_y);
  });
}

GrayImage MovedImage(const GrayImage& image, const Camera& from, const Camera& to) {
  return Resampled(image, [&](int column, int row) {
    return Eigen::Vector2d(column + from.cx - to.cx, row + from.cy - to.cy);
  });
}

void MeanImage::Add(const GrayImage& image) {
  if (count_ == 0) {
    first_ = image;
    sum_ = Eigen::VectorXd::Zero(image.coverage.size());
  }
  CHECK(image.width == first_.width && image.height == first_.height);
  sum_ += Eigen::Map<const Eigen::VectorXf>(image.coverage.data(), sum_.size()).cast<double>();
  ++count_;
}

GrayImage MeanImage::Mean() const {
  CHECK_GT(count_, 0);
  GrayImage mean(first_.width, first_.height);
  Eigen::Map<Eigen::VectorXf>(mean.coverage.data(), sum_.size()) = (sum_ / count_).cast<float>();
  return mean;
}

DrapeDistance ComputeDistance(const ObservedDrape& a, const ObservedDrape& b) {
  CHECK(a.discs == b.discs) << ToString(a.discs) << ", " << ToString(b.discs);
  return {
      .mse = MeanSquaredError(a.image, b.image),
      .iou = IntersectionOverUnion(a.image, b.image),
      .profile_rms = ProfileRms(a.radius, b.radius),
      .outline_hausdorff = HausdorffOfPolygons(ProfilePolygon(a.radius), ProfilePolygon(b.radius))};
}

DrapeComparison CompareDrapes(const ObservedDrape& a, const ObservedDrape& b,
                              const Camera& camera) {
  DrapeComparison comparison{ComputeDistance(a, b), {}, AlignDrapes(a, b)};
  const auto& [rotation, mirrored] = comparison.alignment;
  const GrayImage turned = TurnedImage(b.image, camera, rotation, mirrored);
  comparison.aligned = ComputeDistance(a, ObserveImage(turned, camera, b.discs, "turned image"));
  return comparison;
}

SurfaceDistance CompareSurfaces(const ObjSurface& a, const ObjSurface& b,
                                const Alignment& alignment, const std::string& where,
                                double tolerance) {
  const ObjSurface turned{TurnedAboutZ(b.x, alignment.rotation, alignment.mirrored), b.triangles};
  return {HausdorffOfSurfaces(a, b, where, tolerance),
          HausdorffOfSurfaces(a, turned, where, tolerance)};
}

double MeanSquaredError(const GrayImage& a, const GrayImage& b) {
  CheckSameSize(a, b);
  double sum = 0;
  for (size_t i = 0; i < a.coverage.size(); ++i) {
    const double difference = double(a.coverage[i]) - b.coverage[i];
    sum += difference * difference;
  }
  return sum / a.coverage.size();
}

double IntersectionOverUnion(const GrayImage& a, const GrayImage& b, float threshold) {
  CheckSameSize(a, b);
  size_t both = 0, any = 0;
  for (size_t i = 0; i < a.coverage.size(); ++i) {
    const bool in_a = a.coverage[i] >= threshold, in_b = b.coverage[i] >= threshold;
    both += in_a && in_b;
    any += in_a || in_b;
  }
  return any == 0 ? 1.0 : double(both) / any;
}

double CoverageArea(const GrayImage& image, const Camera& camera) {
  const double pixels = std::accumulate(image.coverage.begin(), image.coverage.end(), 0.0);
  return pixels / std::pow(camera.pixels_per_metre(), 2);
}

SilhouetteMetrics CompareSilhouettes(const GrayImage& image, const Eigen::VectorXd& image_radius,
                                     const GrayImage& fitted_image,
                                     const Eigen::VectorXd& fitted_radius, const Camera& camera,
                                     const DrapeDiscs& discs) {
  const Eigen::VectorXd image_metres = VerticalProfile(image_radius, camera, discs);
  const Eigen::VectorXd fitted_metres = VerticalProfile(fitted_radius, camera, discs);
  SilhouetteMetrics metrics;
  metrics.mse = MeanSquaredError(image, fitted_image);
  metrics.iou = IntersectionOverUnion(image, fitted_image);
  metrics.profile_rms = ProfileRms(image_radius, fitted_radius);
  metrics.hausdorff =
      HausdorffOfPolygons(ProfilePolygon(image_metres), ProfilePolygon(fitted_metres));
  metrics.image_area_dc = DrapeCoefficient(CoverageArea(image, camera), discs);
  metrics.fitted_area_dc = DrapeCoefficient(CoverageArea(fitted_image, camera), discs);
  metrics.image = MeasureShape(image_metres, discs);
  metrics.fitted = MeasureShape(fitted_metres, discs);
  return metrics;
}

nlohmann::ordered_json QualityJson(const ImageQuality& quality) {
  const Segmentation& segmentation = quality.segmentation;
  return {{"scale", quality.scale_given ? "given" : "of the published images"},
          {"centre", ToString(quality.centre)},
          {"centre_offset_px", quality.centre_offset},
          {"centre_error_px", quality.centre_error},
          {"dc", quality.drape_coefficient},
          {"radius_min_m", quality.radius_min},
          {"radius_max_m", quality.radius_max},
          {"overhanging_share", quality.overhanging},
          {"photograph", segmentation.photograph},
          {"contrast", segmentation.cloth - segmentation.background},
          {"cut_px", CountPixels(segmentation.cut)},
          {"filled_px", CountPixels(segmentation.filled)},
          {"notes", quality.notes}};
}

nlohmann::ordered_json MetricsJson(const SilhouetteMetrics& metrics) {
  return {{"mse", metrics.mse},
          {"iou", metrics.iou},
          {"profile_rms_px", metrics.profile_rms},
          {"outline_hausdorff_m", metrics.hausdorff},
          {"dc_image", metrics.image.drape_coefficient},
          {"dc_fit", metrics.fitted.drape_coefficient},
          {"folds_image", metrics.image.folds},
          {"folds_fit", metrics.fitted.folds}};
}

nlohmann::ordered_json StabilityJson(const Eigen::VectorXd& lowest_eigenvalues) {
  const bool known = lowest_eigenvalues.size() > 0, stable = IsStable(lowest_eigenvalues);
  nlohmann::ordered_json json = {
      {"stable", known ? nlohmann::ordered_json(stable) : nullptr},
      {"lowest_eigenvalues_per_s2",
       std::vector<double>(lowest_eigenvalues.begin(), lowest_eigenvalues.end())},
      {"lowest_frequency_hz", nullptr}};
  if (stable) json["lowest_frequency_hz"] = std::sqrt(lowest_eigenvalues[0]) / (2.0 * M_PI);
  return json;
}

nlohmann::ordered_json ScoreJson(const DistributionScore& score) {
  nlohmann::ordered_json json = {{"observed", score.observed},
                                 {"mean_image_mse", score.mean_image_mse},
                                 {"feature_energy_score", score.feature_energy},
                                 {"outline_energy_score_m", score.outline_energy}};
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureScore& f = score.features[k];
    json["features"][kFeatureNames[k]] = {
        {"observed_mean", f.observed_mean},    {"predicted_mean", f.predicted_mean},
        {"predicted_sd", f.predicted_sd},      {"crps", f.crps},
        {"interval_50", IntervalJson(f.half)}, {"interval_90", IntervalJson(f.ninety)}};
  }
  return json;
}

FeatureVector ComputeFeatures(const ShapeFeatures& shape) {
  return ListShapeFeatures(shape).head<kNumFeatures>();
}

Eigen::MatrixXd ComputeFeatures(const Drapes& drapes) {
  Eigen::MatrixXd features(kNumFeatures, drapes.size());
  for (size_t i = 0; i < drapes.size(); ++i) features.col(i) = ComputeFeatures(drapes[i]->shape);
  return features;
}

void DistributionScorer::AddFeature(int feature, const Eigen::VectorXd& samples, double observed) {
  FeatureScore& sum = sum_.features[feature];
  const double mean = samples.mean();
  const std::vector<double> values(samples.begin(), samples.end());
  sum.observed_mean += observed;
  sum.predicted_mean += mean;
  sum.predicted_sd += (samples.array() - mean).matrix().norm() / std::sqrt(samples.size() - 1.0);
  sum.crps += EnsembleCrps(values, observed);
  AddInterval(values, 0.5, observed, &sum.half);
  AddInterval(values, 0.9, observed, &sum.ninety);
}

void DistributionScorer::Add(const Drapes& samples, const Drapes& observed) {
  CHECK_GE(samples.size(), 2u);
  if (observed.empty()) return;
  const GrayImage mean = ComputeMean(samples);
  for (const ObservedDrape* drape : observed)
    sum_.mean_image_mse += MeanSquaredError(mean, drape->image);
  sum_.outline_energy += EnergyScores(OutlineMatrix(samples), OutlineMatrix(observed)).sum();
  SumFeatures(ComputeFeatures(samples), ComputeFeatures(observed));
}

void DistributionScorer::AddFeatures(const Eigen::MatrixXd& samples,
                                     const Eigen::MatrixXd& observed) {
  features_alone_ = true;
  SumFeatures(samples, observed);
}

void DistributionScorer::SumFeatures(const Eigen::MatrixXd& samples,
                                     const Eigen::MatrixXd& observed) {
  for (Eigen::Index i = 0; i < observed.cols(); ++i)
    for (int k = 0; k < kNumFeatures; ++k) AddFeature(k, samples.row(k), observed(k, i));
  const auto weights = scales_.cwiseInverse().asDiagonal();
  sum_.feature_energy += EnergyScores(weights * samples, weights * observed).sum();
  sum_.observed += static_cast<int>(observed.cols());
}

DistributionScore DistributionScorer::Score() const {
  CHECK_GT(sum_.observed, 0);
  DistributionScore score = sum_;
  const double count = sum_.observed;
  if (features_alone_)
    score.mean_image_mse = score.outline_energy = std::numeric_limits<double>::quiet_NaN();
  for (double* value : {&score.mean_image_mse, &score.feature_energy, &score.outline_energy})
    *value /= count;
  for (FeatureScore& feature : score.features) {
    for (double* value :
         {&feature.observed_mean, &feature.predicted_mean, &feature.predicted_sd, &feature.crps})
      *value /= count;
    Divide(count, &feature.half);
    Divide(count, &feature.ninety);
  }
  return score;
}

double EnsembleCrps(std::vector<double> samples, double observed) {
  CHECK_GE(samples.size(), 2u);
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  double distance = 0, spread = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    distance += std::abs(samples[i] - observed) / m;
    spread += (2.0 * i - m + 1) * samples[i];  // Σ_{i<j} (x_j − x_i) of sorted samples
  }
  return distance - spread / (m * (m - 1));
}

Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed) {
  CHECK_GE(samples.cols(), 2);
  CHECK_EQ(samples.rows(), observed.rows());
  const double m = static_cast<double>(samples.cols());
  double spread = 0;
  for (Eigen::Index i = 1; i < samples.cols(); ++i)
    spread += (samples.leftCols(i).colwise() - samples.col(i)).colwise().norm().sum();
  Eigen::VectorXd scores(observed.cols());
  for (Eigen::Index i = 0; i < observed.cols(); ++i) {
    scores[i] =
        (samples.colwise() - observed.col(i)).colwise().norm().mean() - spread / (m * (m - 1));
  }
  return scores;
}

CentralInterval ComputeInterval(std::vector<double> samples, double probability) {
  CHECK_GE(samples.size(), 2u);
  CHECK(probability > 0 && probability < 1) << probability;
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  const double nominal = std::min(probability, (m - 1) / (m + 1));
  const double rank = 0.5 * (1 - nominal) * (m + 1);
  return {AtRank(samples, rank), AtRank(samples, m + 1 - rank), nominal};
}

Spread SpreadOfValues(const std::vector<double>& values) {
  Spread spread;
  if (values.empty()) return spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  if (values.size() == 1) return spread;
  double squares = 0.0;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  spread.sd = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return spread;
}

}  // namespace drape
