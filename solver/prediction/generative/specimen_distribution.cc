// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/specimen_distribution.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "physics/material/material_scaling.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr double kPoissonShare = 0.2;  // c12 over k
constexpr double kSlopeCentre = 5.0;   // the wave whose amplitude no slope changes

double NormalCdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

bool Within(const NumberRange& range, double value) {
  return range.low <= value && value <= range.high;
}

}  // namespace

const std::array<NumberRange, kSpecimenNumbers>& NumberRanges() {
  constexpr double kMilli = 1e-3;
  static const std::array<NumberRange, kSpecimenNumbers> ranges = {{
      {"log_bending_length", "bending length", "mm", kMilli, true, std::log(4.5e-3),
       std::log(0.032), 0.01, 0.17},
      {"bend_anisotropy", "bend along weft / along warp", "", 1, true, -2.0, 2.0, 0.06, 0.8},
      {"bias_bend", "bend at 45 degrees / mean", "", 1, true, -0.8, 0.8, 0.05, 0.5},
      {"log_stretch_length", "stretch over weight", "m", 1, true, std::log(25.0), std::log(4000.0),
       0.15, 3.0},
      {"log_shear_ratio", "shear / stretch", "", 1, true, std::log(0.03), 0.0, 0.15, 3.0},
      {"log_start_height", "start height", "mm", kMilli, true, std::log(5e-4), std::log(0.015), 0.1,
       2.0},
      {"start_slope", "slope of the start's waves", "", 1, false, -1.0, 2.0, 0.12, 2.0},
      {"stretch_anisotropy", "stretch along weft / along warp", "", 1, true, -1.0, 1.0, 0.12, 2.0},
  }};
  return ranges;
}

double LogDensity(const SpecimenDistribution& distribution, ClothFace face,
                  const SpecimenNumbers& numbers) {
  double sum = 0.0;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const NumberRange& range = NumberRanges()[k];
    if (!Within(range, numbers[k])) return -std::numeric_limits<double>::infinity();
    const double mean = distribution.mean_of(face)[k], deviation = distribution.deviation[k];
    const double z = (numbers[k] - mean) / deviation;
    const double inside =
        NormalCdf((range.high - mean) / deviation) - NormalCdf((range.low - mean) / deviation);
    sum -= z * z / 2 + std::log(deviation * inside * std::sqrt(2 * std::numbers::pi));
  }
  return sum;
}

SpecimenNumbers SampleNumbers(const SpecimenDistribution& distribution, ClothFace face,
                              uint64_t seed) {
  SpecimenNumbers numbers;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    std::mt19937_64 random(SeedOfStream(seed, static_cast<uint64_t>(k)));
    do {
      numbers[k] = distribution.mean_of(face)[k] + distribution.deviation[k] * SampleNormal(random);
    } while (!Within(NumberRanges()[k], numbers[k]));
  }
  return numbers;
}

MaterialField SpecimenMaterial(const SpecimenNumbers& numbers, double density) {
  const double weight = density * kStandardGravity;
  const double length = std::exp(numbers[kLogBendingLength]);
  const double rigidity = weight * length * length * length;
  const double stretch = weight * std::exp(numbers[kLogStretchLength]);
  StretchTable membrane;
  for (auto& row : membrane.c) {
    row[0] = stretch * std::exp(numbers[kStretchAnisotropy] / 2);
    row[1] = kPoissonShare * stretch;
    row[2] = stretch * std::exp(-numbers[kStretchAnisotropy] / 2);
    row[3] = stretch * std::exp(numbers[kLogShearRatio]);
    for (double& entry : row) entry /= kMembranePerEntry;
  }
  const double ratios[kBendRows] = {numbers[kBendAnisotropy] / 2, numbers[kBiasBend],
                                    -numbers[kBendAnisotropy] / 2};
  BendTable bend;
  for (int row = 0; row < kBendRows; ++row)
    for (double& entry : bend.b[row]) entry = kBendPerRigidity * rigidity * std::exp(ratios[row]);
  return {density, {membrane}, {bend}};
}

StartShape SpecimenStart(const SpecimenNumbers& numbers, uint64_t seed) {
  StartShape shape = RandomStartShape(seed, 1.0);
  double power = 0.0;  // of the slope, in the mean of the waves
  for (StartShape::Mode& mode : shape.modes) {
    const double factor = std::pow(mode.k / kSlopeCentre, -numbers[kStartSlope]);
    mode.amplitude_m *= factor;
    power += factor * factor / double(shape.modes.size());
  }
  for (StartShape::Mode& mode : shape.modes)
    mode.amplitude_m *= std::exp(numbers[kLogStartHeight]) / std::sqrt(power);
  return shape;
}

nlohmann::ordered_json DistributionJson(const SpecimenDistribution& distribution) {
  nlohmann::ordered_json json;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    nlohmann::ordered_json number;
    if (DiffersByFace(k)) {
      number["mean_up"] = distribution.mean[0][k];
      number["mean_down"] = distribution.mean[1][k];
    } else {
      number["mean"] = distribution.mean[0][k];
    }
    number["deviation"] = distribution.deviation[k];
    json[NumberRanges()[k].key] = number;
  }
  return json;
}

SpecimenDistribution DistributionFromJson(const nlohmann::json& json, const std::string& where) {
  const JsonInput input(json, where);
  SpecimenDistribution distribution;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const JsonInput number = input.At(NumberRanges()[k].key);
    const NumberRange& range = NumberRanges()[k];
    const auto mean = [&](const char* of_face) {
      return number.At(DiffersByFace(k) ? of_face : "mean").NumberWithin(range.low, range.high);
    };
    distribution.mean[0][k] = mean("mean_up");
    distribution.mean[1][k] = mean("mean_down");
    distribution.deviation[k] =
        number.At("deviation").NumberWithin(range.least_deviation, range.most_deviation);
  }
  return distribution;
}

}  // namespace drape
