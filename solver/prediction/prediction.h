// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "losses/dataset/trivial_predictors.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh.h"
#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "solver/forward/settle.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// Drapes of a fabric as a distribution [METHODS, P39]: fabric → specimen,
// with a start shape and log scales of its own → capture, with noise on that start → drape at rest.

// Factors on all bend entries of every specimen, when this face lies up; > 0.
struct BendFactors {
  double up = 1.0, down = 1.0;
  double of(ClothFace face) const { return face == ClothFace::kDown ? down : up; }
};

struct PredictionOptions {
  int specimens = 64;
  int repeats = 1;                                  // drapes of a specimen on each face
  std::vector<ClothFace> faces = {ClothFace::kUp};  // kUp, kDown; on kDown the start's sign flips
  uint64_t seed = 1;
  double start_rms = 3e-3;              // of the start at the hem, k = 2…12, one per specimen [m]
  double capture_rms = 1e-4;            // of the height of each vertex outside the support [m]
  double specimen_stretch_sigma = 0.0;  // standard deviations of a specimen's log factors of all
  double specimen_bend_sigma = 0.0;     // stretch, of all bend entries
  BendFactors bend = {};
  SettleOptions settle = {.steps = {.h = 0.1, .steps = 100}};
  Camera camera = {};
  DrapeDiscs discs = {};  // of the cloth
  int batch = 1;          // drapes at a time (SettleBatchSize)

  int drapes_of_specimen() const { return repeats * static_cast<int>(faces.size()); }
  int num_drapes() const { return specimens * drapes_of_specimen(); }
  void Check() const;  // programmer errors
};

template <MutableOrConst<PredictionOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [specimens, repeats, faces, seed, start_rms, capture_rms, specimen_stretch_sigma,
         specimen_bend_sigma, bend, settle, camera, discs, batch] = options;
  visit(specimens, Field{.key = "specimens", .range = {.least = 1}, .is_option = false});
  visit(repeats, Field{.key = "repeats",
                       .doc = "number of drapes of each specimen on each face, which differ only "
                              "by the noise of the capture",
                       .range = {.least = 1, .most = 1000}});
  visit(seed, Field{.key = "seed", .is_option = false});
  visit(start_rms, Field{.key = "start_rms",
                         .doc = "root mean square height of a specimen's random start shape at "
                                "the hem",
                         .unit = "m",
                         .range = {.least = 0, .most = 0.05}});
  visit(capture_rms, Field{.key = "capture_rms",
                           .doc = "root mean square noise of each vertex at the start of each "
                                  "drape",
                           .unit = "m",
                           .range = {.least = 0, .most = 0.05}});
  visit(specimen_stretch_sigma,
        Field{.key = "specimen_stretch_sigma",
              .doc = "variation between specimens: standard deviation of a log factor on all "
                     "stretch entries",
              .range = {.least = 0, .most = 3}});
  visit(specimen_bend_sigma, Field{.key = "specimen_bend_sigma",
                                   .doc = "variation between specimens: standard deviation of a "
                                          "log factor on all bend entries",
                                   .range = {.least = 0, .most = 3}});
  visit(settle.steps.h, Field{.key = "time_step",
                              .doc = "time step",
                              .unit = "s",
                              .range = {.least = 0, .most = 10, .above_least = true}});
  visit(settle.steps.steps, Field{.key = "steps",
                                  .doc = "number of time steps before Newton's method",
                                  .range = {.least = 0, .most = 100000}});
}

// The material of a specimen: the same for all, a sample of a posterior, a field. A function of the
// number alone, which counts from 0; called once for each drape, on the caller's thread.
using MaterialSource = std::function<MaterialField(int specimen)>;

struct PredictedDrape {
  int specimen = 0, repeat = 0;  // from 0
  ClothFace face = ClothFace::kUp;
  std::string status;  // "stable", or why there is no drape
  // As the camera sees it; none where there is no stable drape or no outline.
  std::optional<ObservedDrape> seen;
  double residual = 0.0;  // ‖f‖ / weight
  int newton_iterations = 0;
  Eigen::VectorXd x;  // [m], shape [3V]; empty where the steps failed
};

// Which drape of which specimen number `drape` of num_drapes() is: specimen by specimen, face by
// face, repeat by repeat. The rest of it is not set.
PredictedDrape NumberedDrape(const PredictionOptions& options, int drape);
// The seed of all that is random of a specimen.
uint64_t SpecimenSeed(const PredictionOptions& options, int specimen);
// Its start from a specimen's start shape, of opposite sign on kDown and with the noise of the
// capture.
State StartOfDrape(const ClothModel& model, const PredictionOptions& options,
                   const PredictedDrape& which, StartShape of_specimen);

// Material and start of drape number `drape`. It depends on the seed, the specimen, the face and
// the repeat alone.
DrapeTask MakeDrapeTask(const ClothModel& model, const MaterialSource& materials,
                        const PredictionOptions& options, int drape);

// All drapes in that order, also those without a stable drape; fewer when
// *options.settle.steps.cancel turns true. Independent of batch size and number of threads.
std::vector<PredictedDrape> SampleDrapes(Backend& backend, const MaterialSource& materials,
                                         const PredictionOptions& options,
                                         const std::function<void(int done)>& progress = {});
// The same of any tasks, which are called once for each drape, on the caller's thread.
std::vector<PredictedDrape> SampleTasks(Backend& backend,
                                        const std::function<DrapeTask(int drape)>& task,
                                        const PredictionOptions& options,
                                        const std::function<void(int done)>& progress = {});

// The drapes that were found, of one face or, for kUnknown, of all.
DistributionScorer::Drapes ObservedDrapes(const std::vector<PredictedDrape>& drapes,
                                          ClothFace face);

// Each held-out capture is predicted by the drapes of its face, or by all if the face is not known.
// None if a capture has fewer than two drapes that predict it, or there is no capture.
std::optional<DistributionScore> ScorePrediction(const std::vector<PredictedDrape>& drapes,
                                                 const std::vector<ObservedCapture>& held_out,
                                                 const FeatureVector& scales = kFeatureScales);

// A fabric as drapefit stores it.
struct FabricSource {
  std::string path;
  std::string kind;   // "table", "field"; of a posterior "hierarchy", "bdp"
  Material material;  // of a posterior the median
  std::optional<StoredPosterior> posterior;
};

// Reads what ReadMaterial does, or a folder of drape_fit: its posterior where the last fit has one,
// otherwise its material.json. mesh: the cloth of tables that vary over it; nullptr: such tables
// are refused. Throws InputError.
FabricSource ReadFabric(const std::string& path, const MaterialPolicy& policy = {},
                        const Mesh* mesh = nullptr);

// The materials of specimens 0, 1, 2, … of a fabric on a mesh, a function of (seed, specimen)
// alone:
//  - "table", "field": the same for all;
//  - "hierarchy": one table, the fabric's log factors sampled from their mean and covariance, those
//    of the specimen from their prior;
//  - "bdp": the fabric's 39 fitted means and deviations, and for each face and hinge a sample
//    of its own, exp(mean + deviation·ε).
MaterialSource MakeSpecimens(const FabricSource& fabric, const Mesh& mesh, uint64_t seed);

// Independent samples of what a fit knows of a fabric, or assumed of it.
struct FabricSamples {
  std::vector<std::string> names;     // of the log factors (StoredPosterior::NameFor), [P]
  Eigen::MatrixXd log_factors;        // shape [P, S]
  std::vector<MaterialField> tables;  // of the fabric, without its specimens' factors, [S]
};

// count ≥ 1 samples, which depend on the seed alone. CHECKs kind hierarchy: the deviations of kind
// bdp are a scatter over the cloth, not an uncertainty.
FabricSamples SampleFabric(const StoredPosterior& posterior, int count, uint64_t seed);
FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed);
// The fabric at log factors of the posterior, shape [P, S].
FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors);

// The tables of the fabric at the mean of the log factors, which is the median of every entry.
MaterialField MedianTables(const StoredPosterior& posterior);

// A fit to outlines finds the stiffness at which the observed drapes are equilibria. Drapes
// simulated from random starts also settle on other branches, and stiffness trades off against the
// branch, so in the mean they may hang higher or lower than the observed ones; and the two faces of
// a fabric can differ more than its samples. For each face a factor b on all bend entries matches
// the distribution of simulated drapes to the observed ones: the minimum over ln b of
//   n · S(b) + ln²b / (2σ²),
// S the mean energy score of drape coefficient and fold count, the two numbers that laboratories
// report of a Cusick test, in units of kFeatureScales, against the n drapes of the training set.
// The energy score is proper, so this is a minimum scoring rule estimate [Dawid 2016] with a
// log-normal prior about the fit. The band energies are left out: real folds are more regular than
// those of random starts, no factor corrects that, and the attempt costs accuracy of the drape
// coefficient (tests/bench/PREDICTIONS.md). A second factor, on stretch, does not improve
// predictions (tests/bench/COMPARISON.md).
//
// Drapes of one random seed change branch as the factor does, so the objective has no useful
// derivative: compass search [Kolda 2003] on a lattice of factors 2^(i/4), all trials with the same
// random starts. Trials with another random seed move the result by one or two lattice steps.
struct CalibrationOptions {
  double sigma = 1.0;  // of ln b, > 0
  int specimens = 16;  // of each trial, ≥ 2
};

struct BendTrial {
  ClothFace face = ClothFace::kUnknown;  // that lies up; kUnknown: all faces of the prediction
  double factor = 1.0;
  int at_rest = 0;         // of its drapes
  double objective = 0.0;  // infinite: a face has fewer than two drapes at rest
};

struct BendCalibration {
  bool cancelled = false;  // then the factors are the best so far
  // A face without a training drape has the factor of the other.
  BendFactors factors;
  int drapes = 0;                 // of all trials
  std::vector<BendTrial> trials;  // face by face, in their order; the first of each is no change
};

// `prediction`: how drapes are simulated; its factors and count of specimens are replaced, its seed
// gives the trials' streams. `training`: at least one drape of the prediction's faces; if the face
// of one is not known, all have the same factor. progress: trials done. The result does not depend
// on the number of threads.
BendCalibration CalibrateBend(Backend& backend, const MaterialSource& materials,
                              const PredictionOptions& prediction,
                              const std::vector<ObservedCapture>& training,
                              const CalibrationOptions& options,
                              const std::function<void(int trials)>& progress = {});

}  // namespace drape
