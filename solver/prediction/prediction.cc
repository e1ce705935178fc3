// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/prediction.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/cloth/state.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

// Streams of a specimen's seed.
enum Stream : uint64_t { kStartStream, kScaleStream, kCaptureStream };

MaterialField SpecimenMaterial(const PredictionOptions& options, const MaterialSource& materials,
                               int specimen, ClothFace face) {
  std::mt19937_64 random(SeedOfStream(SpecimenSeed(options, specimen), kScaleStream));
  const double stretch = options.specimen_stretch_sigma * SampleNormal(random);
  const double bend = options.specimen_bend_sigma * SampleNormal(random);
  return Scaled(materials(specimen), std::exp(stretch), options.bend.of(face) * std::exp(bend));
}

void AddCaptureNoise(const Mesh& mesh, const PredictionOptions& options, uint64_t seed,
                     Eigen::VectorXd* x) {
  const double edge =
      options.discs.support + 1e-6;  // the ring of vertices on it lies on the support
  std::mt19937_64 random(seed);
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const double height = options.capture_rms * SampleNormal(random);
    if (mesh.rest_x.segment<2>(3 * i).norm() > edge) (*x)[3 * i + 2] += height;
  }
}

void Fill(const ClothModel& model, const PredictionOptions& options, SettledDrape settled,
          PredictedDrape* drape) {
  const bool stepped = settled.steps == RolloutStatus::kOk;
  drape->status = stepped ? ToString(settled.rest.status) : ToString(settled.steps);
  drape->residual = settled.rest.residual;
  drape->newton_iterations = settled.rest.iterations;
  drape->x = std::move(settled.rest.x);
  if (!stepped || settled.rest.status != EquilibriumStatus::kStable) return;
  if (CountSelfIntersections(model.mesh, drape->x) > 0) {
    drape->status = "passes through itself";
    return;
  }
  try {
    drape->seen = ObserveSurface({drape->x, ListTriangles(model.mesh)}, options.camera,
                                 options.discs, "drape");
  } catch (const InputError& unseen) {  // counted like a drape without equilibrium
    drape->status = unseen.what();
  }
}

}  // namespace

void PredictionOptions::Check() const {
  CheckFields(*this);
  CHECK(!faces.empty());
  for (const ClothFace face : faces) CHECK(face != ClothFace::kUnknown);
  CHECK(bend.up > 0.0 && bend.down > 0.0);
  CHECK(settle.solve_mode == SolveMode::kStatic) << "drapes are judged at rest";
}

uint64_t SpecimenSeed(const PredictionOptions& options, int specimen) {
  return SeedOfStream(options.seed, static_cast<uint64_t>(specimen));
}

PredictedDrape NumberedDrape(const PredictionOptions& options, int drape) {
  const int of_specimen = drape % options.drapes_of_specimen();
  PredictedDrape numbered;
  numbered.specimen = drape / options.drapes_of_specimen();
  numbered.face = options.faces[of_specimen / options.repeats];
  numbered.repeat = of_specimen % options.repeats;
  return numbered;
}

State StartOfDrape(const ClothModel& model, const PredictionOptions& options,
                   const PredictedDrape& which, StartShape of_specimen) {
  if (which.face == ClothFace::kDown)
    for (StartShape::Mode& mode : of_specimen.modes) mode.amplitude_m *= -1.0;
  State start = model.RestState();
  start.x = ApplyStartShape(model.mesh, options.discs.support, of_specimen);
  // Streams by face and repeat, so that more repeats leave the first ones as they are.
  const uint64_t capture = 2 * which.repeat + (which.face == ClothFace::kDown);
  AddCaptureNoise(model.mesh, options,
                  SeedOfStream(SpecimenSeed(options, which.specimen), kCaptureStream + capture),
                  &start.x);
  return start;
}

DrapeTask MakeDrapeTask(const ClothModel& model, const MaterialSource& materials,
                        const PredictionOptions& options, int drape) {
  const PredictedDrape which = NumberedDrape(options, drape);
  const uint64_t seed = SeedOfStream(SpecimenSeed(options, which.specimen), kStartStream);
  return {SpecimenMaterial(options, materials, which.specimen, which.face),
          StartOfDrape(model, options, which, RandomStartShape(seed, options.start_rms))};
}

std::vector<PredictedDrape> SampleDrapes(Backend& backend, const MaterialSource& materials,
                                         const PredictionOptions& options,
                                         const std::function<void(int done)>& progress) {
  return SampleTasks(
      backend, [&](int i) { return MakeDrapeTask(backend.model(), materials, options, i); },
      options, progress);
}

std::vector<PredictedDrape> SampleTasks(Backend& backend,
                                        const std::function<DrapeTask(int drape)>& task,
                                        const PredictionOptions& options,
                                        const std::function<void(int done)>& progress) {
  options.Check();
  std::vector<PredictedDrape> drapes;
  const auto done = [&](int i, SettledDrape settled) {
    drapes.push_back(NumberedDrape(options, i));
    Fill(backend.model(), options, std::move(settled), &drapes.back());
    if (progress) progress(i + 1);
  };
  SettleInBatches(backend, options.num_drapes(), options.batch, task, options.settle, done);
  return drapes;
}

DistributionScorer::Drapes ObservedDrapes(const std::vector<PredictedDrape>& drapes,
                                          ClothFace face) {
  DistributionScorer::Drapes seen;
  for (const PredictedDrape& drape : drapes)
    if (drape.seen && (face == ClothFace::kUnknown || drape.face == face))
      seen.push_back(&*drape.seen);
  return seen;
}

std::optional<DistributionScore> ScorePrediction(const std::vector<PredictedDrape>& drapes,
                                                 const std::vector<ObservedCapture>& held_out,
                                                 const FeatureVector& scales) {
  if (held_out.empty()) return {};
  DistributionScorer scorer(scales);
  for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown, ClothFace::kUnknown}) {
    DistributionScorer::Drapes observed;
    for (const ObservedCapture& seen : held_out)
      if (seen.capture.face == face) observed.push_back(&seen.drape);
    const DistributionScorer::Drapes draws = ObservedDrapes(drapes, face);
    if (observed.empty()) continue;
    if (draws.size() < 2) return {};
    scorer.Add(draws, observed);
  }
  return scorer.Score();
}

}  // namespace drape
