// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "physics/util/math/random.h"
#include "solver/prediction/generative/distribution_fit.h"

namespace drape::test {

// Drapes without a simulation: coefficient, folds and ellipse follow from a specimen's numbers, and
// chance adds the rest.
inline ObservedDrape FakeDrape(const SpecimenNumbers& numbers, uint64_t seed) {
  std::mt19937_64 random(seed);
  const double stiff = (numbers[kLogBendingLength] - std::log(4.5e-3)) / std::log(0.032 / 4.5e-3);
  ObservedDrape drape;
  drape.shape.drape_coefficient = 0.1 + 0.85 * stiff + 0.01 * SampleNormal(random);
  drape.shape.folds = static_cast<int>(std::lround(13 - 8 * stiff + 0.4 * SampleNormal(random)));
  const double ellipse = 4e-3 * numbers[kBendAnisotropy] + 1e-3 * SampleNormal(random);
  drape.shape.band_energy = {ellipse * ellipse / 2, 5e-6, 2e-5 * (1 - stiff), 2e-6};
  const double phase = 2 * std::numbers::pi * SampleUniform(random);
  drape.radius.resize(kObservedAngles);
  for (int i = 0; i < kObservedAngles; ++i) {
    const double angle = 2 * std::numbers::pi * i / kObservedAngles;
    drape.radius[i] = 0.09 + 0.06 * drape.shape.drape_coefficient + ellipse * std::cos(2 * angle) +
                      6e-3 * (1 - stiff) * std::cos(drape.shape.folds * angle + phase);
  }
  return drape;
}

inline void AddFakeDrape(const SpecimenNumbers& numbers, uint64_t seed, DrapePool* pool) {
  pool->drapes.push_back({numbers, ComputeDrapeShape(FakeDrape(numbers, seed))});
  ++pool->simulated;
}

// Of all NumberRanges.
inline DrapePool FakePool(int drapes, uint64_t seed = 3) {
  DrapePool pool{"disc:100", "none", 1, 0, {}, {{.drapes = drapes}}};
  std::mt19937_64 random(seed);
  for (int i = 0; i < drapes; ++i) {
    SpecimenNumbers numbers;
    for (int k = 0; k < kSpecimenNumbers; ++k)
      numbers[k] = NumberRanges()[k].low +
                   (NumberRanges()[k].high - NumberRanges()[k].low) * SampleUniform(random);
    AddFakeDrape(numbers, SeedOfStream(seed + 2, i), &pool);
  }
  return pool;
}

// Of this distribution, up and down in turn.
inline DrapePool FakePoolAround(const SpecimenDistribution& distribution, int drapes) {
  DrapePool pool{"disc:100", "none", 1, 0, {}, {{.around = {distribution}, .drapes = drapes}}};
  for (int i = 0; i < drapes; ++i) {
    const ClothFace face = i % 2 == 0 ? ClothFace::kUp : ClothFace::kDown;
    AddFakeDrape(SampleNumbers(distribution, face, SeedOfStream(11, i)), SeedOfStream(13, i),
                 &pool);
  }
  return pool;
}

// One drape on each face of so many samples.
inline std::vector<TrainingDrape> FakeSamples(const SpecimenDistribution& distribution, int samples,
                                              uint64_t seed) {
  std::vector<TrainingDrape> drapes;
  for (int sample = 1; sample <= samples; ++sample)
    for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
      const uint64_t of_sample = SeedOfStream(seed, sample);
      const uint64_t of_drape = SeedOfStream(of_sample, face == ClothFace::kDown ? 101 : 100);
      const SpecimenNumbers numbers = SampleNumbers(distribution, face, of_sample);
      drapes.push_back({sample, face, ComputeDrapeShape(FakeDrape(numbers, of_drape))});
    }
  return drapes;
}

// A fabric whose faces differ.
inline SpecimenDistribution FakeFabric() {
  SpecimenDistribution fabric;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    const NumberRange& range = NumberRanges()[k];
    fabric.mean[0][k] = fabric.mean[1][k] = (range.low + range.high) / 2;
    fabric.deviation[k] = std::sqrt(range.least_deviation * range.most_deviation);
  }
  fabric.mean[0][kLogBendingLength] = std::log(0.016);
  fabric.mean[1][kLogBendingLength] = std::log(0.019);
  fabric.mean[0][kBendAnisotropy] = fabric.mean[1][kBendAnisotropy] = 1.2;
  return fabric;
}

}  // namespace drape::test
