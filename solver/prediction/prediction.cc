// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/prediction.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/posterior/variational_fit.h"

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

namespace fs = std::filesystem;

// Separate the samples from one another, and from the start shapes, which follow from the same
// seed.
constexpr uint64_t kMaterialStream = 0x6d6174, kPosteriorStream = 0x706f7374,
                   kPriorStream = 0x7072696f;

uint64_t SeedOfSpecimen(uint64_t seed, int specimen) {
  return SeedOfStream(SeedOfStream(seed, kMaterialStream), static_cast<uint64_t>(specimen));
}

MaterialSource HierarchySamples(const StoredPosterior& posterior, uint64_t seed) {
  const int n = posterior.num_fabric();
  const TableParametrisation table(posterior.base, posterior.fabric);
  const Eigen::VectorXd mean = posterior.mean.head(n);
  const Eigen::MatrixXd root = CovarianceRoot(posterior.covariance.topLeftCorner(n, n));
  Eigen::Vector2d sd = Eigen::Vector2d::Zero();  // of a specimen's stretch and bend
  if (posterior.specimens > 0) sd = posterior.prior_sd.segment<2>(n);
  return [=](int specimen) {
    std::mt19937_64 random(SeedOfSpecimen(seed, specimen));
    Eigen::VectorXd noise(n);
    for (double& value : noise) value = SampleNormal(random);
    const double stretch = sd[0] * SampleNormal(random), bend = sd[1] * SampleNormal(random);
    return Scaled(table.Material(mean + root * noise), std::exp(stretch), std::exp(bend));
  };
}

MaterialSource ElementwiseSamples(const StoredPosterior& posterior, const Mesh& mesh,
                                  uint64_t seed) {
  const auto shared = std::make_shared<const Mesh>(mesh);
  Eigen::VectorXd theta(2 * kMaterialEntries);
  theta << posterior.mean, posterior.element_sd;
  return [=, base = posterior.base](int specimen) {
    const FieldParametrisation field(base, shared->num_faces(), shared->num_hinges(),
                                     NoiseTerms(*shared, 1.0, SeedOfSpecimen(seed, specimen)));
    return field.Material(theta);
  };
}

// Returns whether the last fit of a folder has a posterior: files of an earlier fit may lie beside
// those of the last, which the summary is of.
bool HasPosterior(const std::string& folder) {
  if (!fs::is_directory(folder)) return false;
  const std::string summary = folder + "/summary.json";
  if (fs::exists(summary)) return ReadJsonFile(summary).contains("posterior");
  return fs::exists(folder + "/posterior.json");
}

FabricSamples SampleLogFactors(const StoredPosterior& posterior, const Eigen::VectorXd& mean,
                               const Eigen::MatrixXd& covariance, int count, uint64_t seed) {
  CHECK_GE(count, 1);
  return SamplesAt(
      posterior,
      (CovarianceRoot(covariance) * IndependentSamples(posterior.size(), count, seed)).colwise() +
          mean);
}

constexpr uint64_t kTrialStream = 0x5ca1e;  // of the prediction's seed
constexpr int kPerOctave = 4;               // lattice points
constexpr int kFirstStep = kPerOctave;      // one octave
constexpr int kFarthest = 4 * kPerOctave;   // a factor of 16

// The factor at a point of the lattice.
double FactorAt(int point) { return std::exp2(double(point) / kPerOctave); }

FeatureVector CalibrationScales() {
  FeatureVector scales = FeatureVector::Constant(std::numeric_limits<double>::infinity());
  scales.head<2>() = kFeatureScales.head<2>();  // drape coefficient, folds
  return scales;
}

// The search for the factor of one face, or of all faces together.
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

FabricSource ReadFabric(const std::string& path, const MaterialPolicy& policy, const Mesh* mesh) {
  FabricSource fabric;
  fabric.path = path;
  if (!HasPosterior(path)) {
    fabric.material =
        mesh == nullptr ? ReadMaterial(path, policy) : ReadMaterialFor(*mesh, path, policy);
    fabric.kind = fabric.material.field.stretch.size() == 1 ? "table" : "field";
    return fabric;
  }
  fabric.posterior = ReadPosterior(path, policy);
  fabric.kind = ToString(fabric.posterior->kind);
  fabric.material.field = MedianTables(*fabric.posterior);
  fabric.material.warp_known = fabric.posterior->warp_known;
  const fs::path folder = fs::weakly_canonical(path);
  fabric.material.name =
      (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  return fabric;
}

MaterialSource MakeSpecimens(const FabricSource& fabric, const Mesh& mesh, uint64_t seed) {
  if (!fabric.posterior) return [field = fabric.material.field](int) { return field; };
  return fabric.posterior->kind == PosteriorKind::kHierarchy
             ? HierarchySamples(*fabric.posterior, seed)
             : ElementwiseSamples(*fabric.posterior, mesh, seed);
}

FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors) {
  CHECK(posterior.kind == PosteriorKind::kHierarchy);
  CHECK_EQ(log_factors.rows(), posterior.size());
  FabricSamples samples;
  for (int i = 0; i < posterior.size(); ++i) samples.names.push_back(posterior.NameFor(i));
  samples.log_factors = std::move(log_factors);
  const TableParametrisation table(posterior.base, posterior.fabric);
  samples.tables.reserve(samples.log_factors.cols());
  for (const auto& sample : samples.log_factors.colwise())
    samples.tables.push_back(table.Material(sample.head(posterior.num_fabric())));
  return samples;
}

FabricSamples SampleFabric(const StoredPosterior& posterior, int count, uint64_t seed) {
  return SampleLogFactors(posterior, posterior.mean, posterior.covariance, count,
                          SeedOfStream(seed, kPosteriorStream));
}

FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed) {
  const int n = posterior.num_fabric();
  Eigen::MatrixXd covariance = posterior.prior_sd.cwiseAbs2().asDiagonal();
  covariance.topLeftCorner(n, n) = posterior.FabricPrior();
  return SampleLogFactors(posterior, Eigen::VectorXd::Zero(posterior.size()), covariance, count,
                          SeedOfStream(seed, kPriorStream));
}

MaterialField MedianTables(const StoredPosterior& posterior) {
  return TableParametrisation(posterior.base, posterior.fabric)
      .Material(posterior.mean.head(posterior.num_fabric()));
}

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
