// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/job/fit_input.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/prediction.h"

namespace drape {
namespace {

using nlohmann::json;

// A model that a comparison can fit [METHODS, P43].
struct ComparedModel {
  std::string name;
  std::string meaning;                            // for a person
  std::optional<FitModel> fit;                    // none: learned from the distribution of drapes
  std::optional<ParameterTying> parameters = {};  // none: as the job says
  TableForm table_form = TableForm::kGiven;
  std::optional<FieldBasis> basis = {};  // of fields; none: as the job says

  FitSpec ApplyTo(FitSpec spec) const {
    if (fit) spec.model = *fit;
    spec.table_form = table_form;
    if (parameters) spec.stages.parameters = *parameters;
    if (basis) spec.fields.basis = *basis;
    return spec;
  }
  // Models with the same fit of one table resume from one checkpoint of this name.
  std::string TableName() const {
    const bool own = parameters || table_form != TableForm::kGiven;
    return own ? "one_table_" + name : "one_table";
  }
};

// The simplest first, by what a model says of a cloth rather than by its count of numbers.
const std::vector<ComparedModel>& AllModels() {
  using enum FitModel;
  using enum ParameterTying;
  using enum TableForm;
  static const std::vector<ComparedModel> models = {
      {"isotropic", "linear isotropic tables, 2 numbers", kHomogeneous, kScales, kIsotropic},
      {"linear", "linear tables, 7 numbers", kHomogeneous, kColumns, kLinear},
      {"bend", "nonlinear tables, 1 number, stretch from the seed grid", kHomogeneous, kBendScale},
      {"bend_rows", "nonlinear tables, 3 numbers, stretch from the seed grid", kHomogeneous,
       kBendRows},
      {"scales", "nonlinear tables, 2 numbers", kHomogeneous, kScales},
      {"columns", "nonlinear tables, 7 numbers", kHomogeneous, kColumns},
      {"homogeneous", "nonlinear tables, --num_parameters numbers", kHomogeneous},
      {"heterogeneous", "nonlinear tables and smooth fields over the cloth", kHeterogeneous},
      {"elements",
       "nonlinear tables and factors of each face and hinge",
       kHeterogeneous,
       {},
       kGiven,
       FieldBasis::kElements},
      {"bdp", "each face and hinge a draw of a normal distribution", kBdp},
      {"bayes", "a posterior of the fabric and its specimens", kBayes},
      {"generative", "the distribution of specimens, learned from that of drapes, 18 numbers", {}},
  };
  return models;
}

// Throws InputError ("option 'models'") for an unknown or repeated name.
std::vector<ComparedModel> FindComparedModels(const std::vector<std::string>& names) {
  std::string known;
  std::vector<ComparedModel> found;
  for (const ComparedModel& model : AllModels()) {
    known += (known.empty() ? "" : ", ") + model.name;
    if (std::count(names.begin(), names.end(), model.name) > 0) found.push_back(model);
  }
  for (const std::string& name : names) {
    if (std::none_of(found.begin(), found.end(),
                     [&](const ComparedModel& model) { return model.name == name; }))
      throw InputError("option 'models'", "found '" + name + "', expected some of " + known);
    if (std::count(names.begin(), names.end(), name) > 1)
      throw InputError("option 'models'", "found '" + name + "' twice, expected each once");
  }
  return found;
}

constexpr double kShareOfFit = 0.8;  // of the time of a run

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void AddFeature(const std::string& name, const FeatureScore& feature, json* numbers) {
  (*numbers)[name + "_error"] = std::abs(feature.predicted_mean - feature.observed_mean);
  (*numbers)[name + "_crps"] = feature.crps;
  (*numbers)[name + "_coverage_50"] = feature.half.coverage;
  (*numbers)[name + "_width_50"] = feature.half.width;
  (*numbers)[name + "_coverage_90"] = feature.ninety.coverage;
  (*numbers)[name + "_width_90"] = feature.ninety.width;
}

// The numbers of a score by key: errors are absolute values of predicted less observed means.
json ScoreNumbers(const DistributionScore& score) {
  json numbers = {{"mean_image_mse", score.mean_image_mse},
                  {"feature_energy", score.feature_energy},
                  {"outline_energy_m", score.outline_energy}};
  AddFeature("dc", score.features[0], &numbers);
  AddFeature("folds", score.features[1], &numbers);
  for (auto each = numbers.begin(); each != numbers.end();)
    each = std::isnan(each->get<double>()) ? numbers.erase(each) : std::next(each);
  return numbers;
}

// A number, or the sum of the numbers of a list or an object.
double ReadSum(const json& value) {
  if (value.is_number()) return value.get<double>();
  double sum = 0.0;
  for (const json& each : value) sum += each.get<double>();
  return sum;
}

json FitNumbers(const json& summary) {
  const json& mean = summary.at("mean");
  json numbers = {{"train_mse", mean.at("mse")},
                  {"train_profile_rms_px", mean.at("profile_rms_px")},
                  {"train_iou", mean.at("iou")},
                  {"train_hausdorff_m", mean.at("outline_hausdorff_m")},
                  {"parameters", summary.at("parameters").at("count")}};
  double seconds = ReadSum(summary.at("seconds")), rollouts = summary.at("rollouts");
  for (const char* part : {"fields", "posterior"}) {
    if (!summary.contains(part)) continue;
    seconds += ReadSum(summary.at(part).at("seconds"));
    rollouts += summary.at(part).at("rollouts").get<double>();
  }
  numbers["fit_seconds"] = seconds;
  numbers["rollouts"] = rollouts;
  if (summary.contains("fields")) numbers["parameters"] = summary.at("fields").at("parameters");
  if (summary.contains("posterior")) {
    const json& posterior = summary.at("posterior");
    const bool pairs = posterior.at("kind") == ToString(PosteriorKind::kElements);
    numbers["parameters"] = posterior.at("log_factors").size() * (pairs ? 2 : 1);
    if (posterior.at("elbo").is_number()) numbers["elbo"] = posterior.at("elbo");
  }
  return numbers;
}

// The part of summary.json that a fit of the model must have reached; empty: one table is all.
std::string SummaryPart(FitModel model) {
  if (model == FitModel::kHomogeneous) return "";
  return model == FitModel::kHeterogeneous ? "fields" : "posterior";
}

// Why a model could not be fitted; empty: it was.
std::string DescribeFailure(const json& summary, FitModel model) {
  if (!summary.contains("mean")) return "nothing could be fitted";
  const std::string part = SummaryPart(model);
  if (part.empty() || summary.contains(part)) return "";
  return "the " + part + " could not be fitted";
}

// Mean distance of the outlines of draws and the captures of their face [m].
double MeanPairHausdorff(const std::vector<PredictedDrape>& drapes,
                         const std::vector<ObservedCapture>& held_out) {
  double sum = 0.0;
  int pairs = 0;
  for (const ObservedCapture& seen : held_out)
    for (const ObservedDrape* draw : ObservedDrapes(drapes, seen.capture.face)) {
      sum += ComputeDistance(*draw, seen.drape).outline_hausdorff;
      ++pairs;
    }
  return sum / pairs;
}

json CaptureScores(const std::vector<PredictedDrape>& drapes,
                   const std::vector<ObservedCapture>& held_out) {
  json scores = json::array();
  for (const ObservedCapture& seen : held_out) {
    const Capture& c = seen.capture;
    const auto score = ScorePrediction(drapes, {seen});
    scores.push_back({{"fabric", c.fabric},
                      {"sample", c.sample},
                      {"capture", c.capture},
                      {"feature_energy", score->feature_energy},
                      {"outline_energy_m", score->outline_energy}});
  }
  return scores;
}

void AddScores(const std::vector<PredictedDrape>& drapes,
               const std::vector<ObservedCapture>& held_out, json* result) {
  (*result)["draws"] = drapes.size();
  (*result)["at_rest"] = ObservedDrapes(drapes, ClothFace::kUnknown).size();
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) {
    result->erase("numbers");
    (*result)["failure"] = "a face that is held out has fewer than two draws at rest";
    return;
  }
  (*result)["numbers"].update(ScoreNumbers(*score));
  (*result)["numbers"]["hausdorff_m"] = MeanPairHausdorff(drapes, held_out);
  (*result)["score"] = ScoreJson(*score);
  (*result)["captures"] = CaptureScores(drapes, held_out);
}

// Scores of the uncalibrated fit, for comparison.
void AddAsFitted(const std::vector<PredictedDrape>& drapes,
                 const std::vector<ObservedCapture>& held_out, json* numbers) {
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) return;
  const json all = ScoreNumbers(*score);
  for (const char* key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    (*numbers)[std::string(key) + "_as_fitted"] = all.at(key);
}

std::unique_ptr<Backend> MakeFitBackend(const FitSpec& fit) {
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(fit.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  return MakeBackend(fit.backend, model, fit.threads);
}

PredictionOptions MakeOptions(const ExperimentTask& task, const Backend& backend,
                              const RunControl& control) {
  PredictionOptions options = task.prediction;
  options.settle.steps.cancel = options.settle.equilibrium.cancel = control.cancel;
  options.batch = SettleBatchSize(backend, task.fit.threads);
  return options;
}

std::optional<json> LearnAndPredict(const ExperimentTask& task, const RunControl& control) {
  const Clock::time_point begin = Clock::now();
  const auto backend = MakeFitBackend(task.fit);
  const LearnedFabric learned = LearnFabric(*backend, *task.training, *task.learning, control);
  if (learned.cancelled) return {};
  const double learning_seconds = SecondsSince(begin);
  control.Report(kShareOfFit, "prediction");
  const std::vector<PredictedDrape> drapes =
      SampleSpecimens(*backend, learned.fit, MakeOptions(task, *backend, control));
  if (control.cancelled()) return {};
  json result = {{"numbers",
                  {{"fit_seconds", learning_seconds},
                   {"prediction_seconds", SecondsSince(begin) - learning_seconds},
                   {"rollouts", learned.simulated},
                   {"parameters", kDistributionNumbers}}},
                 {"energy_training", learned.fit.score},
                 {"energy_cross_validated", learned.fit.cross_validated},
                 {"effective_drapes", learned.fit.effective}};
  AddScores(drapes, *task.held_out, &result);
  WriteDistributionFit(task.folder + "/specimens.json", learned.fit);
  return result;
}

// Samples drapes of the fit in the folder of the task, and scores it; `result` has the numbers of
// the fit.
std::optional<json> Predict(const ExperimentTask& task, const RunControl& control, json result) {
  constexpr double kUsualTrials = 18;
  const auto report = [&](double share, const char* stage) {
    control.Report(kShareOfFit + (1 - kShareOfFit) * share, stage);
  };
  const auto backend = MakeFitBackend(task.fit);
  PredictionOptions options = MakeOptions(task, *backend, control);
  const ClothModel& model = backend->model();
  const MaterialSource materials = MakeSpecimens(
      ReadFabric(task.folder, ReadingPolicy(model.law), &model.mesh), model.mesh, options.seed);
  const Clock::time_point begin = Clock::now();
  report(0.0, "prediction");
  std::vector<PredictedDrape> drapes = SampleDrapes(*backend, materials, options);
  const double seconds = SecondsSince(begin);
  if (control.cancelled()) return {};
  json calibrated = json::object();
  if (task.calibrate) {
    AddAsFitted(drapes, *task.held_out, &calibrated);
    const BendCalibration calibration =
        CalibrateBend(*backend, materials, options, *task.training, {}, [&](int trials) {
          report(std::min(0.9, 0.3 + 0.6 * trials / kUsualTrials), "calibration");
        });
    if (calibration.cancelled) return {};
    options.bend = calibration.factors;
    calibrated["bend_factor_up"] = calibration.factors.up;
    calibrated["bend_factor_down"] = calibration.factors.down;
    calibrated["calibration_seconds"] = SecondsSince(begin) - seconds;
    report(0.9, "prediction");
    drapes = SampleDrapes(*backend, materials, options);
    if (control.cancelled()) return {};
  }
  AddScores(drapes, *task.held_out, &result);
  if (result.contains("failure")) return result;
  result["numbers"].update(calibrated);
  result["numbers"]["prediction_seconds"] = seconds;
  return result;
}

std::optional<json> FitAndPredict(const ExperimentTask& task, const RunControl& control) {
  const FitFiles files{.out = task.folder,
                       .checkpoint = task.checkpoint,
                       .keep_checkpoint = true,
                       .log = task.folder + "/fit.log",
                       .provenance = task.provenance};
  const RunControl part{control.cancel, [&](double fraction, const std::string& note) {
                          control.Report(kShareOfFit * fraction, note);
                        }};
  if (ContinueFitJob(task.fit, task.data, files, part).cancelled) return {};
  const json summary = ParseJson(ReadOwnFile(task.folder + "/summary.json"), task.folder);
  json result = SummariseFit(summary, task.fit.model);
  if (result.contains("failure")) return result;
  return Predict(task, control, std::move(result));
}

// What all models of a fabric and a seed share.
struct SharedSplit {
  int fabric = 0, seed = 0;
  Split split = {};
  FitSpec fit = {};  // without the choices of a model
  FitData data = {};
  std::vector<ObservedCapture> training = {}, held_out = {};
  std::vector<ReadRecord::File> files = {};  // that the captures were read from
};

std::string FabricName(int fabric) { return "fabric_" + std::to_string(fabric); }

std::string CellName(int fabric, const std::string& model, int seed) {
  return FabricName(fabric) + "/" + model + "/seed_" + std::to_string(seed);
}

void CheckJob(const ComparisonJob& job) {
  if (job.materials.size() != 1 && job.materials.size() != job.fabrics.size())
    throw InputError("option 'materials'", "found " + std::to_string(job.materials.size()) +
                                               ", expected one for all, or one for each of the " +
                                               std::to_string(job.fabrics.size()) + " fabrics");
  if (std::set(job.seeds.begin(), job.seeds.end()).size() != job.seeds.size())
    throw InputError("option 'seeds'", "found a seed twice, expected each once");
}

std::vector<Capture> UsableCaptures(const ComparisonJob& job, const Dataset& dataset, int fabric,
                                    const RunControl& control) {
  std::vector<FileNote> skipped;
  std::vector<Capture> usable =
      KeepUsable(Select(dataset, {.fabrics = {fabric}, .face = job.face}), &skipped);
  for (const FileNote& note : skipped) control.Log("skipped: " + note.text);
  return usable;
}

Split MakeSplit(const ComparisonJob& job, const std::vector<Capture>& usable, int seed) {
  Split split = SplitBySample(usable, job.train, seed);
  if (job.train_captures.empty()) return split;
  std::erase_if(split.train, [&](const Capture& capture) {
    return std::find(job.train_captures.begin(), job.train_captures.end(), capture.capture) ==
           job.train_captures.end();
  });
  return split;
}

SharedSplit MakeShared(const ComparisonJob& job, const std::vector<Capture>& usable,
                       std::size_t fabric, int seed) {
  const ReadRecord record;
  SharedSplit shared{.fabric = job.fabrics[fabric],
                     .seed = seed,
                     .split = MakeSplit(job, usable, seed),
                     .fit = job.fit};
  shared.training = ObserveCaptures(shared.split.train, Camera());
  shared.held_out = ObserveCaptures(shared.split.held_out, Camera());
  shared.data.material = job.materials[job.materials.size() == 1 ? 0 : fabric];
  shared.fit.posterior.seed = seed;
  UseCaptures(shared.split.train, &shared.data);
  shared.files = record.files();
  return shared;
}

PredictionOptions MakePredictionOptions(const ComparisonJob& job, const SharedSplit& shared) {
  std::set<ClothFace> faces;
  for (const ObservedCapture& seen : shared.held_out) faces.insert(seen.capture.face);
  if (faces.contains(ClothFace::kUnknown)) faces = {ClothFace::kUp, ClothFace::kDown};
  PredictionOptions prediction;
  prediction.faces.assign(faces.begin(), faces.end());
  prediction.specimens = std::max(2, job.draws / prediction.drapes_of_specimen());
  prediction.seed = shared.seed;
  return prediction;
}

// A cell with the files that the fit reads.
StudyCell MakeCell(const SharedSplit& shared, const ComparedModel& model) {
  const std::string name = CellName(shared.fabric, model.name, shared.seed);
  json input = {{"cell", name}};
  for (const auto& [side, captures] :
       {std::pair{"train", &shared.split.train}, {"held_out", &shared.split.held_out}})
    for (const Capture& capture : *captures) input[side].push_back(capture.Name());
  StudyCell cell = CheckedCell(name, input, [&] {
    if (model.fit) ReadFitInput(model.ApplyTo(shared.fit), shared.data);
  });
  cell.files.insert(cell.files.end(), shared.files.begin(), shared.files.end());
  return cell;
}

std::optional<json> RunCell(const ComparisonJob& job, const SharedSplit& shared,
                            const ComparedModel& model, const RunControl& control) {
  const std::string folder = job.out + "/" + FabricName(shared.fabric),
                    seed = std::to_string(shared.seed);
  std::filesystem::create_directories(folder);
  WriteSplit(folder + "/split_" + seed + ".json", shared.split);
  ExperimentTask task{.folder = job.out + "/" + CellName(shared.fabric, model.name, shared.seed),
                      .fit = model.ApplyTo(shared.fit),
                      .data = shared.data,
                      .checkpoint = folder + "/" + model.TableName() + "_" + seed + ".json",
                      .provenance = job.provenance,
                      .prediction = MakePredictionOptions(job, shared),
                      .training = &shared.training,
                      .held_out = &shared.held_out,
                      .calibrate = job.calibrate};
  if (!model.fit) {
    task.learning = job.learning;
    task.learning->fit.seed = static_cast<uint64_t>(shared.seed);
  }
  return RunExperiment(task, control);
}

// The trivial predictors of a split, as runs.
void AddTrivial(const SharedSplit& shared, nlohmann::ordered_json* runs) {
  const TrivialPredictors trivial =
      EvaluateTrivialPredictors(shared.training, shared.held_out, Camera(), false);
  const auto add = [&](const char* name, const std::string& row_name,
                       const std::optional<DistributionScore>& score) {
    if (!score) return;
    json numbers = ScoreNumbers(*score);
    for (const PredictorRow& row : trivial.rows)
      if (row.name == row_name) numbers["hausdorff_m"] = row.mean.outline_hausdorff;
    runs->push_back({{"fabric", shared.fabric},
                     {"model", name},
                     {"seed", shared.seed},
                     {"numbers", numbers},
                     {"captures", json::array()}});
  };
  add("other samples", "another sample, same face", trivial.other_samples);
  add("normal", "", trivial.normal);
  add("circle", "circle of the mean area", trivial.circle);
}

// All that the runs of a study need; they outlive the caller.
struct Plan {
  ComparisonJob job;
  std::vector<ComparedModel> models;
  std::vector<SharedSplit> splits = {};

  // The split and the model of a cell.
  const SharedSplit& FindSplit(std::size_t cell) const { return splits[cell / models.size()]; }
  const ComparedModel& FindModel(std::size_t cell) const { return models[cell % models.size()]; }
};

// Simulates what the pool lacks that the cells of the generative model learn from, and adds the
// pool to what they read.
void AddPool(const Plan& plan, Study* study, const RunControl& control) {
  std::filesystem::create_directories(plan.job.out);
  const LearningOptions& learning = plan.job.learning;
  const ReadRecord record;
  ReadOrSimulatePool(learning.pool_file, *MakeFitBackend(plan.job.fit), learning.pool, control);
  for (std::size_t k = 0; k < study->cells.size(); ++k)
    if (!plan.FindModel(k).fit)
      for (const ReadRecord::File& file : record.files()) study->cells[k].files.push_back(file);
}

nlohmann::ordered_json Summarise(const Plan& plan, const StudyResult& result) {
  nlohmann::ordered_json file = {{"format", "drapefit-comparison"}, {"version", 2}};
  for (const ComparedModel& model : plan.models)
    file["models"].push_back({{"name", model.name}, {"meaning", model.meaning}});
  file["runs"] = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < result.results.size(); ++k) {
    if (!result.results[k]) continue;
    const SharedSplit& shared = plan.FindSplit(k);
    file["runs"].push_back(
        {{"fabric", shared.fabric}, {"model", plan.FindModel(k).name}, {"seed", shared.seed}});
    file["runs"].back().update(nlohmann::ordered_json(*result.results[k]));
  }
  if (result.complete)
    for (const SharedSplit& shared : plan.splits) AddTrivial(shared, &file["runs"]);
  return file;
}

}  // namespace

json SummariseFit(const json& summary, FitModel model) {
  const std::string failure = DescribeFailure(summary, model);
  if (!failure.empty()) return {{"failure", failure}};
  json result = {{"numbers", FitNumbers(summary)}};
  if (summary.contains("posterior"))
    for (const char* key : {"stretch_n_per_m", "bend_n_m"})
      result["posterior"][key] = summary["posterior"].at(key);
  return result;
}

std::optional<json> RunExperiment(const ExperimentTask& task, const RunControl& control) {
  std::filesystem::create_directories(task.folder);
  return task.learning ? LearnAndPredict(task, control) : FitAndPredict(task, control);
}

Comparison MakeComparison(const ComparisonJob& job, const RunControl& control) {
  CheckJob(job);
  const auto plan = std::make_shared<Plan>(Plan{job, FindComparedModels(job.models)});
  const Dataset dataset = job.list ? Dataset() : ReadDataset(job.data);
  Comparison comparison{{.name = "comparison", .settings = job.settings}, {}};
  for (std::size_t i = 0; i < job.fabrics.size(); ++i) {
    std::vector<Capture> usable;
    if (!job.list) usable = UsableCaptures(job, dataset, job.fabrics[i], control);
    for (const int seed : job.seeds) {
      if (!job.list) plan->splits.push_back(MakeShared(job, usable, i, seed));
      for (const ComparedModel& model : plan->models)
        comparison.study.cells.push_back(
            job.list ? StudyCell{.name = CellName(job.fabrics[i], model.name, seed)}
                     : MakeCell(plan->splits.back(), model));
    }
  }
  if (!job.list && !plan->models.back().fit) AddPool(*plan, &comparison.study, control);
  comparison.study.run = [plan](std::size_t k, const RunControl& cell) {
    return RunCell(plan->job, plan->FindSplit(k), plan->FindModel(k), cell);
  };
  comparison.summarise = [plan](const StudyResult& result) { return Summarise(*plan, result); };
  return comparison;
}

}  // namespace drape
