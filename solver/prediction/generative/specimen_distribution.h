// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "losses/dataset/dataset.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"

namespace drape {

// A fabric as the distribution of its specimens [METHODS, P72]: a linear material and a random
// start shape in eight numbers, which are normal and independent. Once the stiffness over the
// weight is known, a drape depends on the weight only in that the springs of the support give way,
// which moves it by less than 1 mm. So the numbers are lengths and ratios, and drapes of one
// density serve for all.

inline constexpr int kSpecimenNumbers = 8;
using SpecimenNumbers = Eigen::Matrix<double, kSpecimenNumbers, 1>;

enum SpecimenNumber {
  kLogBendingLength,   // ln c [ln m], c³ = D/(ρg), D the geometric mean of warp and weft
  kBendAnisotropy,     // ln(D of edges along weft / D of edges along warp)
  kBiasBend,           // ln(D of edges at 45° / D)
  kLogStretchLength,   // ln k/(ρg) [ln m], k the geometric mean of c11 and c22
  kLogShearRatio,      // ln(c33/k)
  kLogStartHeight,     // ln of the root mean square of the start shape at the hem [ln m]
  kStartSlope,         // s of the amplitude ∝ k^-s of its waves k = 2 … 12
  kStretchAnisotropy,  // ln(c11/c22)
};

// A logistic map of the real line onto the numbers between two bounds.
struct BoundedNumber {
  double low, high;

  double At(double u) const { return low + (high - low) * Share(u); }
  // The u of a value, which is taken as no nearer to a bound than this share of the range.
  double From(double value, double least_share) const {
    const double share = std::clamp((value - low) / (high - low), least_share, 1.0 - least_share);
    return std::log(share / (1.0 - share));
  }
  // dAt/du.
  double Slope(double u) const { return (high - low) * Share(u) * (1.0 - Share(u)); }

 private:
  static double Share(double u) { return 1.0 / (1.0 + std::exp(-u)); }
};

// What is known of a number before any drape: it is uniform in [low, high], and its deviation
// between specimens is in [least_deviation, most_deviation].
struct NumberRange {
  const char* key;  // of files
  // What a person is shown of it: its name, and its value over `unit_size`, or that of its
  // exponential, in `unit` (may be empty).
  const char* label;
  const char* unit;
  double unit_size;
  bool is_log;
  double low, high;
  double least_deviation, most_deviation;

  double Shown(double number) const { return (is_log ? std::exp(number) : number) / unit_size; }
};
const std::array<NumberRange, kSpecimenNumbers>& NumberRanges();

// The two faces of a fabric differ in bending length and bend anisotropy alone.
constexpr bool DiffersByFace(int number) {
  return number == kLogBendingLength || number == kBendAnisotropy;
}

// Free numbers of a distribution: the means, those that differ once for each face, and deviations.
inline constexpr int kDistributionNumbers = 2 * kSpecimenNumbers + 2;

struct SpecimenDistribution {
  std::array<SpecimenNumbers, 2> mean = {};  // of drapes with this face up, by FaceIndex
  SpecimenNumbers deviation = SpecimenNumbers::Ones();

  static int FaceIndex(ClothFace face) { return face == ClothFace::kDown ? 1 : 0; }
  const SpecimenNumbers& mean_of(ClothFace face) const { return mean[FaceIndex(face)]; }
};

// The log density of numbers that are conditioned on lying in NumberRanges, of drapes with this
// face up; -infinity outside.
double LogDensity(const SpecimenDistribution& distribution, ClothFace face,
                  const SpecimenNumbers& numbers);
// A specimen, within NumberRanges; a function of the seed, in which the faces of one specimen share
// their random deviates.
SpecimenNumbers SampleNumbers(const SpecimenDistribution& distribution, ClothFace face,
                              uint64_t seed);

// The linear tables of a specimen of this density [kg/m²], c12 = 0.2·k.
MaterialField SpecimenMaterial(const SpecimenNumbers& numbers, double density = 0.2);
// Random waves whose expected mean square is that of the numbers; a function of both arguments.
StartShape SpecimenStart(const SpecimenNumbers& numbers, uint64_t seed);

// A member for each number: mean (of both faces where they differ) and deviation. FromJson throws
// InputError (prefix `where`).
nlohmann::ordered_json DistributionJson(const SpecimenDistribution& distribution);
SpecimenDistribution DistributionFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace drape
