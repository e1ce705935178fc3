// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "solver/forward/settle.h"

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

// Simulated drapes of specimens from all over NumberRanges. One pool serves all fabrics, since a
// fabric is a way of weighting its drapes [METHODS, P72]; a second round of drapes near what was
// inferred makes it finer for one.

inline constexpr int kPoolAngles = 72;

// What a camera above sees of a drape, as far as distributions are compared by it.
struct DrapeShape {
  FeatureVector features;  // ComputeFeatures
  Eigen::VectorXd radius;  // [m], shape [kPoolAngles], θ_i = 2π i/kPoolAngles
};
DrapeShape ComputeDrapeShape(const ObservedDrape& drape);

struct PooledDrape {
  SpecimenNumbers numbers;
  DrapeShape shape;
};

// What drapes were drawn from: uniform in NumberRanges, or an equal mixture of these distributions
// on these faces.
struct PoolRound {
  std::vector<SpecimenDistribution> around = {};
  std::vector<ClothFace> faces = {ClothFace::kUp, ClothFace::kDown};
  int drapes = 0;
};

struct DrapePool {
  std::string mesh;     // "disc:600", or "of SHA-256 …" of a file
  std::string setting;  // how it was simulated: "smooth law, contact none, 100 steps of 0.1 s"
  uint64_t seed = 0;
  int simulated = 0;  // with those that have no stable drape, or pass through themselves
  std::vector<PooledDrape> drapes;
  std::vector<PoolRound> rounds;

  // ln of the density from which all rounds together have drawn each drape, shape [drapes]
  // (balance heuristic [Veach 1995]).
  Eigen::VectorXd LogProposal() const;
};

struct PoolOptions {
  std::string mesh;       // its name or file (ParseMeshSpec), which the backend has
  DrapeDiscs discs = {};  // of the cloth
  int drapes = 4096;
  uint64_t seed = 1;
  PoolRound from = {};  // its count is not used
  SettleOptions settle = {.steps = {.h = 0.1, .steps = 100}};
};

// Drape i of a pool of this seed, drawn from all of NumberRanges: its specimen and start shape.
struct PooledSpecimen {
  SpecimenNumbers numbers;
  StartShape start;
};
PooledSpecimen MakePooledSpecimen(const PoolRound& from, uint64_t seed, int i);

// Drape by drape, each a function of the seed and its index, after those that `begun`, a pool of
// the same options, has; independent of the threads. Fewer when control.cancel turns true.
DrapePool SimulatePool(Backend& backend, const PoolOptions& options, const RunControl& control,
                       DrapePool begun = {});

// All drapes of both, which are of one mesh and setting (CHECK).
DrapePool Join(DrapePool pool, const DrapePool& further);

// A file of some 400 bytes for each drape; lengths are rounded to 1 µm and numbers to seven digits,
// also in the result of SimulatePool, so that reading gives what was written. For pools of one
// round from all of NumberRanges (CHECK). Both throw InputError.
void WritePool(const std::string& path, const DrapePool& pool);
DrapePool ReadPool(const std::string& path);

// The pool of a file with at least options.drapes: all that it has, or those that it lacks too,
// which are added to the file, also as far as they are when they are cancelled. For a ReadRecord
// the file is read as it is at the end. Throws InputError where the file holds a pool of another
// mesh, setting or seed.
DrapePool ReadOrSimulatePool(const std::string& path, Backend& backend, const PoolOptions& options,
                             const RunControl& control);

}  // namespace drape
