// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/comparison.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "losses/dataset/dataset_split.h"
#include "physics/util/errors.h"
#include "solver/job/fit_input.h"

namespace drape {
namespace {

using nlohmann::json;

// What all models of a fabric and a seed share.
struct SharedSplit {
  int fabric = 0, seed = 0;
  Split split = {};
  FitSpec fit = {};  // without the choices of a model
  FitData data = {};
  std::vector<ObservedCapture> training = {}, held_out = {};
  std::vector<ReadRecord::File> files = {};  // that the captures were read from
};

// One run of the comparison.
struct Experiment {
  std::string name;
  const SharedSplit* shared = nullptr;
  ComparedModel model;
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

std::vector<SharedSplit> ShareAll(const ComparisonJob& job, const RunControl& control) {
  const Dataset dataset = ReadDataset(job.data);
  std::vector<SharedSplit> all;
  for (std::size_t i = 0; i < job.fabrics.size(); ++i) {
    const std::vector<Capture> usable = UsableCaptures(job, dataset, job.fabrics[i], control);
    for (const int seed : job.seeds) all.push_back(MakeShared(job, usable, i, seed));
  }
  return all;
}

PredictionOptions MakePredictionOptions(const ComparisonJob& job, const SharedSplit& shared) {
  std::set<ClothFace> faces;
  for (const ObservedCapture& seen : shared.held_out) faces.insert(seen.capture.face);
  if (faces.contains(ClothFace::kUnknown)) faces = {ClothFace::kUp, ClothFace::kDown};
  PredictionOptions prediction = job.prediction;
  prediction.faces.assign(faces.begin(), faces.end());
  prediction.specimens = std::max(2, job.draws / prediction.drapes_of_specimen());
  prediction.seed = shared.seed;
  return prediction;
}

ExperimentTask MakeTask(const ComparisonJob& job, const Experiment& experiment) {
  const SharedSplit& shared = *experiment.shared;
  ExperimentTask task{.folder = job.out + "/" + experiment.name,
                      .fit = experiment.model.ApplyTo(shared.fit),
                      .data = shared.data,
                      .checkpoint = job.out + "/" + FabricName(shared.fabric) + "/" +
                                    experiment.model.TableName() + "_" +
                                    std::to_string(shared.seed) + ".json",
                      .provenance = job.provenance,
                      .prediction = MakePredictionOptions(job, shared),
                      .training = &shared.training,
                      .held_out = &shared.held_out,
                      .calibrate = job.calibrate};
  if (experiment.model.generative) {
    task.learning = job.learning;
    task.learning->fit.seed = static_cast<uint64_t>(shared.seed);
  }
  return task;
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

std::optional<json> RunAndKeepSplit(const ComparisonJob& job, const Experiment& experiment,
                                    const RunControl& control) {
  const SharedSplit& shared = *experiment.shared;
  const std::string folder = job.out + "/" + FabricName(shared.fabric);
  std::filesystem::create_directories(folder);
  WriteSplit(folder + "/split_" + std::to_string(shared.seed) + ".json", shared.split);
  return RunExperiment(MakeTask(job, experiment), control);
}

// All that the runs of a study need; they outlive the caller.
struct Plan {
  ComparisonJob job;
  std::vector<ComparedModel> models;
  std::vector<SharedSplit> splits;
  std::vector<Experiment> experiments;
};

nlohmann::ordered_json Summarise(const Plan& plan, const StudyResult& result) {
  nlohmann::ordered_json file = {{"format", "drapefit-comparison"}, {"version", 2}};
  for (const ComparedModel& model : plan.models)
    file["models"].push_back({{"name", model.name}, {"meaning", model.meaning}});
  file["runs"] = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < plan.experiments.size(); ++k) {
    if (!result.results[k]) continue;
    const SharedSplit& shared = *plan.experiments[k].shared;
    file["runs"].push_back({{"fabric", shared.fabric},
                            {"model", plan.experiments[k].model.name},
                            {"seed", shared.seed}});
    file["runs"].back().update(nlohmann::ordered_json(*result.results[k]));
  }
  if (result.complete)
    for (const SharedSplit& shared : plan.splits) AddTrivial(shared, &file["runs"]);
  return file;
}

}  // namespace

Comparison MakeComparison(const ComparisonJob& job, const RunControl& control) {
  CheckJob(job);
  const auto plan = std::make_shared<Plan>(Plan{job, FindComparedModels(job.models), {}, {}});
  Comparison comparison;
  comparison.study.name = "comparison";
  comparison.study.settings = job.settings;
  if (job.list) {
    for (const int fabric : job.fabrics)
      for (const int seed : job.seeds)
        for (const ComparedModel& model : plan->models)
          comparison.study.cells.push_back({.name = CellName(fabric, model.name, seed)});
    return comparison;
  }
  plan->splits = ShareAll(job, control);
  for (const SharedSplit& shared : plan->splits)
    for (const ComparedModel& model : plan->models) {
      const std::string name = CellName(shared.fabric, model.name, shared.seed);
      StudyCell cell = CheckedCell(name, {}, [&] {
        if (!model.generative) ReadFitInput(model.ApplyTo(shared.fit), shared.data);
      });
      cell.files.insert(cell.files.end(), shared.files.begin(), shared.files.end());
      comparison.study.cells.push_back(std::move(cell));
      plan->experiments.push_back({name, &shared, model});
    }
  comparison.study.run = [plan](std::size_t k, const RunControl& cell) {
    return RunAndKeepSplit(plan->job, plan->experiments[k], cell);
  };
  comparison.summarise = [plan](const StudyResult& result) { return Summarise(*plan, result); };
  return comparison;
}

}  // namespace drape
