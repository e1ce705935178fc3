// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/drape_pool.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/math/sha256.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kPoissonShare = 0.2;  // c12 over k
constexpr double kSlopeCentre = 5.0;   // the wave whose amplitude no slope changes

double NormalCdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

bool Within(const NumberRange& range, double value) {
  return range.low <= value && value <= range.high;
}

constexpr StoredFormat kPoolFormat = {"drapefit-drape-pool", 1};
constexpr double kRadiusUnit = 1e-6;  // of the file [m]
constexpr int kDeviceBatch = 512;     // keeps two devices busy
constexpr int kBatchOfThread = 8;     // so that threads seldom wait for one another

enum PoolStream : uint64_t { kPoolNumbers, kPoolStart };

double Rounded(double value) {
  if (value == 0.0) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 6.0);
  return std::round(value / unit) * unit;
}

SpecimenNumbers UniformNumbers(uint64_t seed) {
  std::mt19937_64 random(seed);
  SpecimenNumbers numbers;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const NumberRange& range = NumberRanges()[k];
    numbers[k] = range.low + (range.high - range.low) * SampleUniform(random);
  }
  return numbers;
}

// Number i of a round; the components of the mixture take turns.
SpecimenNumbers RoundNumbers(const PoolRound& round, int i, uint64_t seed) {
  if (round.around.empty()) return UniformNumbers(seed);
  const std::size_t faces = round.faces.size(), which = i % (faces * round.around.size());
  return SampleNumbers(round.around[which / faces], round.faces[which % faces], seed);
}

// ln of the volume of NumberRanges.
double LogVolume() {
  double sum = 0.0;
  for (const NumberRange& range : NumberRanges()) sum += std::log(range.high - range.low);
  return sum;
}

double Density(const PoolRound& round, const SpecimenNumbers& numbers) {
  if (round.around.empty()) return std::exp(-LogVolume());
  double sum = 0.0;
  for (const SpecimenDistribution& component : round.around)
    for (const ClothFace face : round.faces) sum += std::exp(LogDensity(component, face, numbers));
  return sum / double(round.around.size() * round.faces.size());
}

DrapeShape Rounded(DrapeShape shape) {
  for (double& feature : shape.features) feature = Rounded(feature);
  for (double& radius : shape.radius) radius = std::round(radius / kRadiusUnit) * kRadiusUnit;
  return shape;
}

// None where the camera sees no drape, as of the prediction.
std::optional<DrapeShape> See(const ClothModel& model, const SettledDrape& settled,
                              const DrapeDiscs& discs) {
  if (!settled.IsUsable(SolveMode::kStatic)) return {};
  const Eigen::VectorXd& x = settled.rest.x;
  if (CountSelfIntersections(model.mesh, x) > 0) return {};
  try {
    return Rounded(ComputeDrapeShape(
        ObserveSurface({x, ListTriangles(model.mesh)}, CameraAbove(discs), discs, "drape")));
  } catch (const InputError&) {  // an outline with gaps
    return {};
  }
}

std::string DescribeSetting(const ClothModel& model, const RolloutOptions& steps) {
  const bool touches_itself = HasSelfContact(model.scene);
  const char* contact = touches_itself ? "self" : model.scene.contact ? "support" : "none";
  return Format("%s law, contact %s, %d steps of %g s",
                model.law.rejects_negative_entries() ? "smooth" : "reference", contact, steps.steps,
                steps.h);
}

// The contents of a mesh file stand for it.
std::string DescribeMesh(const std::string& mesh) {
  if (!std::filesystem::is_regular_file(mesh)) return mesh;
  return "of SHA-256 " + Sha256(ReadOwnFile(mesh));
}

void CheckSame(const std::string& path, const DrapePool& pool, const PoolOptions& options,
               const std::string& setting) {
  const auto check = [&](const char* what, const std::string& found, const std::string& expected) {
    if (found != expected)
      throw InputError(path, std::string("found a pool of ") + what + " " + found + ", expected " +
                                 expected + ": name another file, or remove this one");
  };
  check("mesh", pool.mesh, DescribeMesh(options.mesh));
  check("seed", std::to_string(pool.seed), std::to_string(options.seed));
  check("setting", pool.setting, setting);
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

DrapeShape ComputeDrapeShape(const ObservedDrape& drape) {
  DrapeShape shape{ComputeFeatures(drape.shape), Eigen::VectorXd(kPoolAngles)};
  constexpr int kEach = kObservedAngles / kPoolAngles;
  for (int i = 0; i < kPoolAngles; ++i) shape.radius[i] = drape.radius[i * kEach];
  return shape;
}

Eigen::VectorXd DrapePool::LogProposal() const {
  Eigen::VectorXd density = Eigen::VectorXd::Zero(drapes.size());
  for (const PoolRound& round : rounds)
    for (Eigen::Index i = 0; i < density.size(); ++i)
      density[i] += round.drapes * Density(round, drapes[i].numbers) / simulated;
  return density.array().log();
}

DrapePool Join(DrapePool pool, const DrapePool& further) {
  CHECK(pool.mesh == further.mesh && pool.setting == further.setting);
  pool.simulated += further.simulated;
  pool.drapes.insert(pool.drapes.end(), further.drapes.begin(), further.drapes.end());
  pool.rounds.insert(pool.rounds.end(), further.rounds.begin(), further.rounds.end());
  return pool;
}

PooledSpecimen MakePooledSpecimen(const PoolRound& from, uint64_t seed, int i) {
  const uint64_t own = SeedOfStream(seed, static_cast<uint64_t>(i));
  PooledSpecimen specimen{RoundNumbers(from, i, SeedOfStream(own, kPoolNumbers)), {}};
  for (double& number : specimen.numbers) number = Rounded(number);
  specimen.start = SpecimenStart(specimen.numbers, SeedOfStream(own, kPoolStart));
  return specimen;
}

DrapePool SimulatePool(Backend& backend, const PoolOptions& options, const RunControl& control,
                       DrapePool begun) {
  const ClothModel& model = backend.model();
  DrapePool pool = std::move(begun);
  pool.mesh = DescribeMesh(options.mesh);
  pool.setting = DescribeSetting(model, options.settle.steps);
  pool.seed = options.seed;
  const int first = pool.simulated;
  std::vector<SpecimenNumbers> numbers;
  const auto task = [&](int further) {
    const int i = first + further;
    const PooledSpecimen specimen = MakePooledSpecimen(options.from, options.seed, i);
    numbers.push_back(specimen.numbers);
    DrapeTask drape{SpecimenMaterial(specimen.numbers), model.RestState()};
    drape.start.x = ApplyStartShape(model.mesh, options.discs.support, specimen.start);
    return drape;
  };
  SettleOptions settle = options.settle;
  settle.steps.cancel = settle.equilibrium.cancel = control.cancel;
  const int batch_size =
      backend.name() == "cpu" ? kBatchOfThread * backend.threads() : kDeviceBatch;
  std::vector<SettledDrape> batch;
  const auto see = [&] {
    std::vector<std::optional<DrapeShape>> seen(batch.size());
    RunInThreads(static_cast<int>(batch.size()), backend.threads(), nullptr,
                 [&](int i) { seen[i] = See(model, batch[i], options.discs); });
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (seen[i]) pool.drapes.push_back({numbers[pool.simulated - first + i], *seen[i]});
    pool.simulated += static_cast<int>(batch.size());
    batch.clear();
    control.Report(
        double(pool.simulated) / options.drapes,
        "pool, drape " + std::to_string(pool.simulated) + " of " + std::to_string(options.drapes));
  };
  const int count = std::max(0, options.drapes - first);
  SettleInBatches(backend, count, batch_size, task, settle, [&](int i, SettledDrape drape) {
    batch.push_back(std::move(drape));
    if (static_cast<int>(batch.size()) == batch_size || i + 1 == count) see();
  });
  pool.rounds = {options.from};
  pool.rounds.front().drapes = pool.simulated;
  return pool;
}

void WritePool(const std::string& path, const DrapePool& pool) {
  CHECK(pool.rounds.size() == 1 && pool.rounds.front().around.empty());
  nlohmann::json drapes = nlohmann::json::array();
  for (const PooledDrape& drape : pool.drapes) {
    std::vector<int64_t> radius;
    for (const double r : drape.shape.radius) radius.push_back(std::llround(r / kRadiusUnit));
    drapes.push_back(
        {{"numbers", drape.numbers}, {"features", drape.shape.features}, {"radius_um", radius}});
  }
  WriteStoredJson(path, kPoolFormat,
                  {{"mesh", pool.mesh},
                   {"setting", pool.setting},
                   {"seed", pool.seed},
                   {"simulated", pool.simulated},
                   {"drapes", std::move(drapes)}});
}

// Returns whether the numbers can be those of a drape of a pool.
bool IsPossible(const PooledDrape& drape) {
  constexpr double kMostCoefficient = 1.1, kMostFolds = 100, kLeastRadius = 0.5, kMostRadius = 1.1;
  const DrapeDiscs discs;
  const FeatureVector& features = drape.shape.features;
  const double folds = features[1], least = kLeastRadius * discs.support,
               most = kMostRadius * discs.specimen;
  bool possible = features[0] > -0.1 && features[0] < kMostCoefficient && folds >= 0 &&
                  folds < kMostFolds && std::abs(folds - std::round(folds)) < 1e-6 &&
                  features.tail<kNumBands>().minCoeff() >= 0 &&
                  drape.shape.radius.minCoeff() >= least && drape.shape.radius.maxCoeff() <= most;
  // Rounding moves a number at the end of its range across it.
  constexpr double kRounding = 1e-6;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const NumberRange& range = NumberRanges()[k];
    possible = possible && range.low - kRounding <= drape.numbers[k] &&
               drape.numbers[k] <= range.high + kRounding;
  }
  return possible;
}

DrapePool ReadPool(const std::string& path) {
  const nlohmann::json json = ReadStoredJson(path, kPoolFormat);
  const JsonInput input(json, path);
  const JsonInput seed = input.At("seed"), drapes = input.At("drapes");
  if (!seed.value().is_number_unsigned()) seed.Fail("a whole number that is not negative");
  constexpr int kMost = std::numeric_limits<int>::max();
  DrapePool pool{input.At("mesh").String(),
                 input.At("setting").String(),
                 seed.value().get<uint64_t>(),
                 input.At("simulated").IntegerWithin(drapes.ExpectArray().Size(), kMost),
                 {},
                 {}};
  pool.rounds = {{.drapes = pool.simulated}};
  for (int i = 0; i < drapes.Size(); ++i) {
    const JsonInput drape = drapes.At(i);
    pool.drapes.push_back(
        {drape.At("numbers").Vector(kSpecimenNumbers),
         {drape.At("features").Vector(kNumFeatures),
          (drape.At("radius_um").Vector(kPoolAngles).array() * kRadiusUnit).matrix()}});
    if (!IsPossible(pool.drapes.back())) drape.Fail("a drape of " + ToString(DrapeDiscs()));
  }
  return pool;
}

DrapePool ReadOrSimulatePool(const std::string& path, Backend& backend, const PoolOptions& options,
                             const RunControl& control) {
  DrapePool pool;
  if (std::filesystem::exists(path)) {
    pool = ReadPool(path);
    CheckSame(path, pool, options, DescribeSetting(backend.model(), options.settle.steps));
    control.Log("pool: " + std::to_string(pool.simulated) + " drapes of " + path);
  }
  const int had = pool.simulated;
  if (had < options.drapes) pool = SimulatePool(backend, options, control, std::move(pool));
  if (pool.simulated > had) WritePool(path, pool);
  if (pool.simulated > 0) ReadWholeFile(path);  // it is an input as it is now
  return pool;
}

}  // namespace drape
