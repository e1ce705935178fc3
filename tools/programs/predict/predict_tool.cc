// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "losses/dataset/dataset.h"
#include "losses/image/segmentation.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/predict/predict_report.h"
#include "tools/programs/results/tables/outline_list.h"

namespace drape {
namespace {

std::vector<Option> DrawOptions(PredictToolOptions& options) {
  const std::vector<Option> draws = {
      NumberOption("draws", &options.draws, 2, 4096,
                   "number of drapes: a multiple of repeats times faces"),
      NumberOption("seed", &options.seed, 0, kUnlimited,
                   "random seed of the run; the split has split_seed")};
  return Concatenate(draws, FieldOptionList(options.prediction),
                     std::vector{ThreadsOption(options.threads), BackendOption(options.backend)});
}

Option CalibrateOption(PredictToolOptions& options) {
  return PlainOption(
      "calibrate", &options.calibrate,
      "fit a factor on the bend stiffness for each face first, so that simulated drapes "
      "look like those of the training samples");
}

std::vector<Option> FileOptions(PredictToolOptions& options) {
  return {
      PlainOption("keep_meshes", &options.keep_meshes, "also write draw_<i>.obj of each drape"),
      OutOption(options.out),
  };
}

bool IsGenerative(const PredictToolOptions& options) {
  return options.learn || !options.specimens.empty();
}

// Refuses factors on specimens beside a posterior, which has them.
void CheckFactors(const PredictToolOptions& options, const FabricSource& fabric) {
  const PredictionOptions& prediction = options.prediction;
  const bool scaled = prediction.specimen_stretch_sigma > 0 || prediction.specimen_bend_sigma > 0;
  if (!scaled || fabric.kind != ToString(PosteriorKind::kHierarchy)) return;
  throw InputError("option 'specimen_stretch_sigma' or 'specimen_bend_sigma'",
                   "found a positive value beside " + fabric.path +
                       ", whose posterior already describes how specimens differ; expected 0");
}

void RequireOneSource(const PredictToolOptions& options) {
  const int given = int(options.scene.fabric.path != kBuiltInName) + int(options.learn) +
                    int(!options.specimens.empty());
  if (given > 1)
    throw InputError("options 'fabric', 'learn' and 'specimens'",
                     "found " + std::to_string(given) + " of them, expected one of them");
  const PredictionOptions& prediction = options.prediction;
  if (IsGenerative(options) && (options.calibrate || prediction.specimen_stretch_sigma > 0 ||
                                prediction.specimen_bend_sigma > 0))
    throw InputError("option 'calibrate', 'specimen_stretch_sigma' or 'specimen_bend_sigma'",
                     "found a value beside 'learn' or 'specimens', which already describe how "
                     "specimens differ; expected none");
}

std::vector<ClothFace> ListFaces(const std::string& face) {
  if (const auto one = ParseClothFace(face)) return {*one};
  return {ClothFace::kUp, ClothFace::kDown};
}

// The discs of the fit, unless the user asks for other ones.
DiscsInput ChooseDiscs(const PredictToolOptions& options) {
  DiscsInput chosen = options.scene.discs;
  if (const auto fitted = StoredDiscs(options.scene.fabric.path + "/summary.json")) {
    if (std::isnan(chosen.specimen)) chosen.specimen = 2 * fitted->specimen;
    if (std::isnan(chosen.support)) chosen.support = 2 * fitted->support;
  }
  return chosen;
}

PredictionOptions MakePredictionOptions(const PredictToolOptions& options, const DrapeDiscs& discs,
                                        const std::atomic<bool>* cancel) {
  PredictionOptions prediction = options.prediction;
  prediction.faces = ListFaces(options.data.face);
  const int each = prediction.drapes_of_specimen();
  if (options.draws % each != 0) {
    throw InputError("option 'draws'", "found " + std::to_string(options.draws) +
                                           ", expected a multiple of " + std::to_string(each) +
                                           ", repeats times faces");
  }
  prediction.specimens = options.draws / each;
  prediction.seed = static_cast<uint64_t>(options.seed);
  prediction.discs = discs;
  prediction.camera =
      options.images.images.empty() ? MakeCamera(options.camera, discs) : CameraAbove(discs);
  prediction.settle.steps.cancel = prediction.settle.equilibrium.cancel = cancel;
  return prediction;
}

// The held-out data: of one fabric, since the material is that of one fabric.
std::optional<DatasetReport> ReadData(const DatasetQuery& query, const PredictionOptions& options,
                                      const RunControl& control) {
  if (query.folder.empty()) return {};
  if (options.discs != DrapeDiscs())
    throw InputError("option 'specimen' or 'support'",
                     "found " + ToString(options.discs) + " beside the published data set, " +
                         "expected its " + ToString(DrapeDiscs()) +
                         ": drapes of different sizes cannot be compared");
  DatasetReport report = EvaluateDataset(query, options.camera, control);
  std::set<int> fabrics;
  for (const Capture& capture : report.split.held_out) fabrics.insert(capture.fabric);
  if (fabrics.size() != 1) {
    throw InputError("option 'data_fabric'", "found drapes of fabrics " +
                                                 IndexListText({fabrics.begin(), fabrics.end()}) +
                                                 " held out, expected those of one");
  }
  return report;
}

// Refuses calibration and learning without training samples.
void CheckTraining(const PredictToolOptions& options, const PredictionRun& run) {
  if (!options.calibrate && !options.learn) return;
  if (!options.images.images.empty()) return;
  const char* where = options.learn ? "option 'learn'" : "option 'calibrate'";
  const char* needs = options.learn ? "'images' or 'data'" : "'data'";
  if (!run.data)
    throw InputError(where,
                     std::string("found true without ") + needs + ", expected training samples");
  if (run.data->in_turn)
    throw InputError(where, "found true with train = 0, expected samples that are not held out");
  if (run.data->seen_train.empty())
    throw InputError(where,
                     "the training side of the split is empty, expected at least one capture");
}

void Calibrate(Backend& backend, const MaterialSource& materials, const RunControl& control,
               PredictionRun* run) {
  run->calibration = CalibrateBend(
      backend, materials, run->prediction, run->data->seen_train, {},
      [&](int trials) { control.Report(0.0, "calibration, trial " + std::to_string(trials)); });
  run->prediction.bend = run->calibration->factors;
}

// Images of a user's own to learn from.

void CheckCount(const char* option, std::size_t found, std::size_t images) {
  if (found != 0 && found != images)
    throw InputError(std::string("option '") + option + "'",
                     "found " + std::to_string(found) + " values, expected " +
                         std::to_string(images) + ", one for each image");
}

std::vector<Option> TrainingImageOptions(TrainingImages& training) {
  return {
      PathOption(
          "images", &training.images,
          "with learn: silhouettes of the fabric to learn from in place of data (JPEG or PNG): "
          "files, folders, patterns; the camera is then theirs"),
      NumberOption("image_samples", &training.samples, 1, 1000,
                   "the sample of each image, from 1; none: each shows its own"),
      ChoiceOption("image_faces", &training.faces, {"up", "down"},
                   "the face of each image that lies up; none: all up"),
  };
}

// Reads each image through its own camera.
std::vector<ObservedCapture> ObserveTrainingImages(const TrainingImages& training,
                                                   const CameraInput& camera,
                                                   const DrapeDiscs& discs) {
  std::vector<std::string> files;
  for (const std::string& text : training.images)
    for (std::string& file : ExpandImages(text)) files.push_back(std::move(file));
  CheckCount("image_samples", training.samples.size(), files.size());
  CheckCount("image_faces", training.faces.size(), files.size());
  std::vector<ObservedCapture> seen;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    const Capture capture{.fabric = 1,
                          .sample = training.samples.empty() ? number : training.samples[i],
                          .capture = number,
                          .face = ParseClothFace(training.faces.empty() ? "up" : training.faces[i])
                                      .value_or(ClothFace::kUp),
                          .image = files[i]};
    const GrayImage image = ReadSilhouette(files[i]).image;
    seen.push_back({capture, ObserveImage(image, MakeCamera(camera, image, discs, files[i]), discs,
                                          files[i])});
  }
  return seen;
}

// Learning.

// The posterior of one sample, by its drapes with each face up.
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

std::vector<Option> LearningOptionRows(PredictToolOptions& options) {
  const std::vector<Option> rows = {
      PlainOption(
          "learn", &options.learn,
          "instead of a material: learn the distribution of specimens from drapes, of images or "
          "of the training samples of data"),
      PathOption("specimens", &options.specimens,
                 "instead of a material: file specimens.json of a run with learn"),
      NumberOption("pool_seed", &options.pool_seed, 0, kUnlimited, "random seed of the pool"),
      NumberOption("resamples", &options.learning.fit.resamples, 0, 1000,
                   "inferences with random weights of the samples, which show how uncertain the "
                   "distribution is"),
  };
  return Concatenate(rows, TrainingImageOptions(options.images), PoolOptionRows(options.learning));
}

// Refuses images that are not to be learned from, or of other discs than a pool's.
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

// Sets run->learned by the drapes seen, and run->specimen where they are of one sample; nothing
// when it is cancelled.
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

// Draws the drapes; a cancelled run has fewer.
std::vector<PredictedDrape> Draw(const PredictToolOptions& options, Backend& backend,
                                 const MaterialSource& materials, const RunControl& control,
                                 const PredictionRun& run) {
  const auto progress = [&](int done) {
    control.Report(static_cast<double>(done) / options.draws,
                   "draw " + std::to_string(done) + " of " + std::to_string(options.draws));
  };
  if (!IsGenerative(options)) return SampleDrapes(backend, materials, run.prediction, progress);
  if (!run.learned) return {};
  return SampleSpecimens(backend, run.learned->fit, run.prediction, progress);
}

// The material as it drapes with each face up.
void WriteCalibratedMaterials(const PredictionRun& run, const OutputFolder& out) {
  for (const ClothFace face : run.prediction.faces) {
    Material material = run.scene.fabric.material;
    material.field = Scaled(material.field, 1.0, run.prediction.bend.of(face));
    material.source = "drape_predict --calibrate, from " + material.name;
    WriteMaterial(out.Staged("material_" + ClothFaceName(face) + ".json"), material);
  }
}

// The mean image of the drapes, which is white without one.
GrayImage ComputeMean(const PredictionRun& run) {
  const Camera& camera = run.prediction.camera;
  if (run.at_rest() == 0) return GrayImage(camera.width, camera.height);
  MeanImage mean;
  for (const PredictedDrape& drape : run.drapes)
    if (drape.seen) mean.Add(drape.seen->image);
  return mean.Mean();
}

void WriteMeshes(const PredictionRun& run, const OutputFolder& out) {
  for (std::size_t i = 0; i < run.drapes.size(); ++i)
    if (run.drapes[i].seen)
      WriteObj(out.Staged("draw_" + std::to_string(i + 1) + ".obj"), run.scene.model->mesh,
               run.drapes[i].x, run.prediction.discs);
}

OptionTable PredictTable(PredictToolOptions& options) {
  return {
      .tool = "drape_predict",
      .summary =
          "predicts the drapes of a fabric as a distribution and scores it on held-out drapes",
      .example =
          "drape_predict --config=configs/programs/predict.json --draws=64 --out=out/predict",
      .notes =
          "files: summary.json (features of each drape, their intervals, scores), mean_image.png "
          "(mean coverage), outlines.json (of all drapes, for drape_report) and draw_<i>.obj. They "
          "replace the files of an earlier run together, at the end.\n"
          "--calibrate: the factors are in summary.json and, of one table, in material_up.json "
          "and material_down.json.\n"
          "--learn: eight numbers of a specimen (bending length, anisotropy, stretch, shear, "
          "start) as normal distributions, which go to specimens.json, from a pool of simulated "
          "drapes; of one sample also what its own numbers can be, whatever branch its drape is "
          "on; --specimens=FILE predicts from them again.\n"
          "--data: the prediction is scored on held-out samples of --data_fabric, beside "
          "predictors "
          "without a model; the material should have been fitted to other samples.\n"
          "exit code 3: no sample came to rest\n"
          "Ctrl-C writes the results so far.\n",
      .options = Concatenate(
          Grouped("fabric", ClothOptions(options.scene)),
          Grouped("samples and simulation", DrawOptions(options)),
          Grouped("held-out drapes (--data)", Concatenate(FieldOptionList(options.data),
                                                          std::vector{CalibrateOption(options)})),
          Grouped("learning (--learn)", LearningOptionRows(options)),
          Grouped("camera", FieldOptionList(options.camera)),
          Grouped("files", FileOptions(options))),
      .common = {"fabric", "learn", "images", "pool", "specimen", "support", "mesh", "draws",
                 "repeats", "seed", "data", "data_fabric", "train", "calibrate", "threads",
                 "backend", "out"}};
}

// Reads all input before it computes. A cancelled run writes what it has.
ToolOutcome Run(const PredictToolOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  RequireOneSource(options);
  PredictionRun run;
  SceneInput scene = options.scene;
  scene.discs = ChooseDiscs(options);
  if (IsGenerative(options)) scene.fabric.path.clear();
  run.scene = LoadScene(scene);
  CheckFactors(options, run.scene.fabric);
  RequireDiscs(*run.scene.model, run.scene.discs, scene.mesh);
  CheckTrainingImages(options, run.scene.discs);
  run.prediction = MakePredictionOptions(options, run.scene.discs, control.cancel);
  const MaterialSource materials =
      MakeSpecimens(run.scene.fabric, run.scene.model->mesh, static_cast<uint64_t>(options.seed));
  run.data = ReadData(options.data, run.prediction, control);
  if (!control.cancelled()) CheckTraining(options, run);
  const std::vector<ObservedCapture> seen =
      run.data ? run.data->seen_train
               : ObserveTrainingImages(options.images, options.camera, run.scene.discs);
  const auto backend =
      MakeLoggedBackend(options.backend, run.scene.model, CountThreads(options.threads), control);
  const OutputFolder out(options.out, {"summary.json", "mean_image.png", kOutlinesFile});
  run.backend = backend->name();
  run.prediction.batch = SettleBatchSize(*backend, CountThreads(options.threads));
  if (options.calibrate && !control.cancelled()) Calibrate(*backend, materials, control, &run);
  if (IsGenerative(options) && !control.cancelled()) Learn(options, *backend, seen, control, &run);
  run.drapes = Draw(options, *backend, materials, control, run);
  run.cancelled = static_cast<int>(run.drapes.size()) < options.draws;
  if (run.data) run.score = ScorePrediction(run.drapes, run.data->seen_held_out);
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  WritePng(ComputeMean(run), out.Staged("mean_image.png"), run.prediction.discs);
  WritePredictedOutlines(out.Staged(kOutlinesFile), run);
  if (options.keep_meshes) WriteMeshes(run, out);
  if (options.learn && run.learned)
    WriteDistributionFit(out.Staged("specimens.json"), run.learned->fit);
  if (run.calibration && run.scene.fabric.kind == "table") WriteCalibratedMaterials(run, out);
  WritePredictionSummary(out.Staged("summary.json"), options, run);
  out.Publish();
  return {.text = PredictionText(run),
          .cancelled = run.cancelled,
          .failure = run.at_rest() > 0 ? "" : "no sample came to rest, see summary.json"};
}

}  // namespace

int PredictMain(int argc, char** argv) { return ToolMain(argc, argv, PredictTable, Run); }

}  // namespace drape
