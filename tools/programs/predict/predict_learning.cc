// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/predict/predict_learning.h"

#include <algorithm>
#include <map>

#include "physics/util/errors.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

// What one sample can be, by the drapes of each face.
std::map<ClothFace, SpecimenPosterior> InferSample(const std::vector<ObservedCapture>& seen,
                                                   const LearningOptions& learning) {
  constexpr int kSamples = 199;
  const DrapePool pool = ReadPool(learning.pool_file);
  std::map<ClothFace, std::vector<TrainingDrape>> drapes;
  for (TrainingDrape& drape : ListTrainingDrapes(seen)) drapes[drape.face].push_back(drape);
  std::map<ClothFace, SpecimenPosterior> specimen;
  for (const auto& [face, of_face] : drapes)
    specimen[face] =
        InferSpecimen(pool, of_face, learning.fit.outline_weight, kSamples, learning.fit.seed);
  return specimen;
}

bool ShowsOneSample(const std::vector<ObservedCapture>& seen) {
  return std::all_of(seen.begin(), seen.end(), [&](const ObservedCapture& each) {
    return each.capture.sample == seen[0].capture.sample;
  });
}

}  // namespace

std::vector<Option> LearningOptionRows(PredictToolOptions& options) {
  const std::vector<Option> rows = {
      {.key = "learn",
       .value = &options.learn,
       .doc =
           "instead of a material: learn the distribution of specimens from drapes, of images or "
           "of the training samples of data"},
      {.key = "specimens",
       .value = &options.specimens,
       .doc = "instead of a material: file specimens.json of a run with learn",
       .is_path = true},
      {.key = "pool_seed",
       .value = &options.pool_seed,
       .doc = "random seed of the pool",
       .least = 0},
      {.key = "resamples",
       .value = &options.learning.fit.resamples,
       .doc = "inferences with random weights of the samples, which show how uncertain the "
              "distribution is",
       .least = 0,
       .most = 1000},
  };
  return Concatenate(rows, TrainingImageOptions(options.images), PoolOptionRows(options.learning));
}

void CheckTrainingImages(const PredictToolOptions& options, const DrapeDiscs& discs) {
  if (options.images.images.empty()) {
    if (!options.images.samples.empty() || !options.images.faces.empty())
      throw InputError("option 'image_samples' or 'image_faces'", "found without 'images'");
    return;
  }
  if (!options.learn) throw InputError("option 'images'", "found without 'learn'");
  if (!options.data.folder.empty())
    throw InputError("options 'images' and 'data'", "found both, expected one of them");
  if (discs != DrapeDiscs())
    throw InputError("option 'specimen' or 'support'",
                     "found " + ToString(discs) + " beside 'learn', expected " +
                         ToString(DrapeDiscs()) + ", of which the drapes of a pool are");
}

void Learn(const PredictToolOptions& options, Backend& backend,
           const std::vector<ObservedCapture>& seen, const RunControl& control,
           PredictionRun* run) {
  constexpr int kLeastPool = 1000;
  if (!options.specimens.empty()) {
    run->learned = {.fit = ReadDistributionFit(options.specimens)};
    return;
  }
  LearningOptions learning = options.learning;
  learning.pool.mesh = options.scene.mesh;
  learning.pool.seed = static_cast<uint64_t>(options.pool_seed);
  learning.pool.settle = run->prediction.settle;
  learning.fit.seed = run->prediction.seed;
  learning.fit.threads = backend.threads();
  if (learning.pool_file.empty()) learning.pool_file = options.out + "/pool.json";
  const bool one_sample = ShowsOneSample(seen);
  if (one_sample && learning.pool.drapes < kLeastPool)
    throw InputError("option 'pool_drapes'",
                     "found " + std::to_string(learning.pool.drapes) + ", expected at least " +
                         std::to_string(kLeastPool) + " to learn from one sample");
  const LearnedFabric learned = LearnFabric(backend, seen, learning, control);
  if (learned.cancelled) return;
  run->learned = learned;
  if (one_sample) run->specimen = InferSample(seen, learning);
}

}  // namespace drape
