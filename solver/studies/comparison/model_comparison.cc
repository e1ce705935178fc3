// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/model_comparison.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "losses/dataset/dataset_split.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/job/fit_captures.h"
#include "solver/job/fit_input.h"
#include "solver/studies/cells/study_settings.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// What all models of a fabric and a seed share.
struct SharedSplit {
  int fabric = 0, seed = 0;
  Split split;
  std::vector<ObservedCapture> training, held_out;
  FitSpec fit;  // of all but the model
  FitData data;
};

std::string FabricName(int fabric) { return "fabric_" + std::to_string(fabric); }

std::string FabricFolder(const ComparisonJob& job, int fabric) {
  return job.out + "/" + FabricName(fabric);
}

std::string CellName(int fabric, const std::string& model, int seed) {
  return FabricName(fabric) + "/" + model + "/seed_" + std::to_string(seed);
}

std::string SettingsPath(const ComparisonJob& job) { return job.out + "/settings.json"; }

// Beside those of experiments that are there: fabrics may be compared by runs side by side.
void WriteSettings(const ComparisonJob& job, const std::vector<SharedSplit>& splits) {
  AddStudySettings(SettingsPath(job), job.settings);
  for (const SharedSplit& shared : splits) {
    const std::string folder = FabricFolder(job, shared.fabric);
    fs::create_directories(folder);
    if (!job.share) RemoveTemporaries(folder);  // those of other shares may be in use
    WriteSplit(folder + "/split_" + std::to_string(shared.seed) + ".json", shared.split);
  }
}

void CheckJob(const ComparisonJob& job) {
  if (job.materials.size() != 1 && job.materials.size() != job.fabrics.size())
    throw InputError("option 'materials'", "found " + std::to_string(job.materials.size()) +
                                               ", expected one for all, or one for each of the " +
                                               std::to_string(job.fabrics.size()) + " fabrics");
  InOrderOfComplexity(job.models);
  if (std::set(job.seeds.begin(), job.seeds.end()).size() != job.seeds.size())
    throw InputError("option 'seeds'", "found a seed twice, expected each once");
}

const std::string& FabricMaterial(const ComparisonJob& job, std::size_t fabric) {
  return job.materials[job.materials.size() == 1 ? 0 : fabric];
}

ComparisonJob WithMaterialSettings(ComparisonJob job) {
  for (std::size_t i = 0; i < job.fabrics.size(); ++i)
    job.settings["material of fabric " + std::to_string(job.fabrics[i])] = FabricMaterial(job, i);
  return job;
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

SharedSplit Share(const ComparisonJob& job, const std::vector<Capture>& usable, std::size_t fabric,
                  int seed) {
  SharedSplit shared{job.fabrics[fabric], seed, MakeSplit(job, usable, seed), {}, {}, job.fit, {}};
  shared.training = ObserveCaptures(shared.split.train, Camera());
  shared.held_out = ObserveCaptures(shared.split.held_out, Camera());
  shared.data.material = FabricMaterial(job, fabric);
  shared.fit.posterior.seed = seed;
  UseCaptures(shared.split.train, &shared.data);
  return shared;
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

ExperimentTask MakeTask(const ComparisonJob& job, const SharedSplit& shared,
                        const std::string& model) {
  ExperimentTask task{job.out + "/" + CellName(shared.fabric, model, shared.seed),
                      WithModel(shared.fit, model),
                      shared.data,
                      FabricFolder(job, shared.fabric) + "/" + TableName(model) + "_" +
                          std::to_string(shared.seed) + ".json",
                      job.provenance,
                      MakePredictionOptions(job, shared),
                      &shared.training,
                      &shared.held_out,
                      {},
                      job.calibrate};
  if (IsGenerative(model)) {
    task.learning = job.learning;
    task.learning->fit.seed = static_cast<uint64_t>(shared.seed);
  }
  return task;
}

// The trivial predictors of a split, as experiments.
void AddTrivial(const SharedSplit& shared, std::vector<ComparedExperiment>* experiments) {
  const TrivialPredictors trivial =
      EvaluateTrivialPredictors(shared.training, shared.held_out, Camera(), false);
  const auto add = [&](const std::string& name, const std::string& row_name,
                       const std::optional<DistributionScore>& score) {
    if (!score) return;
    ComparedExperiment experiment{shared.fabric, name, shared.seed, {}};
    experiment.result.numbers = ComputeNumbers(*score);
    for (const PredictorRow& row : trivial.rows)
      if (row.name == row_name)
        experiment.result.numbers["hausdorff_m"] = row.mean.outline_hausdorff;
    experiments->push_back(experiment);
  };
  add(kOtherSamples, "another sample, same face", trivial.other_samples);
  add(kNormal, "", trivial.normal);
  add(kCircle, "circle of the mean area", trivial.circle);
}

// Whatever a fit would refuse, before hours of work: each model of each fabric, first seed.
void CheckFits(const ComparisonJob& job, const std::vector<SharedSplit>& splits) {
  for (const SharedSplit& shared : splits)
    if (shared.seed == job.seeds[0])
      for (const std::string& model : job.models)
        if (!IsGenerative(model)) ReadFitInput(WithModel(shared.fit, model), shared.data);
}

std::vector<SharedSplit> ShareAll(const ComparisonJob& job, const RunControl& control) {
  const Dataset dataset = ReadDataset(job.data);
  std::vector<SharedSplit> all;
  for (std::size_t i = 0; i < job.fabrics.size(); ++i) {
    const std::vector<Capture> usable = UsableCaptures(job, dataset, job.fabrics[i], control);
    for (const int seed : job.seeds) all.push_back(Share(job, usable, i, seed));
  }
  return all;
}

std::string NameFor(const ExperimentTask& task, const std::string& model, int seed, int number,
                    int of) {
  return "run " + std::to_string(number) + " of " + std::to_string(of) + ", fabric " +
         std::to_string(task.data.captures[0].fabric) + ", " + model + ", seed " +
         std::to_string(seed);
}

// Computes what is missing; false when it was cancelled.
bool RunExperiments(const ComparisonJob& job, const std::vector<SharedSplit>& splits,
                    const RunControl& control, ComparisonRun* run) {
  struct Todo {
    ExperimentTask task;
    std::string model;
    int seed;
  };
  std::vector<Todo> todo;
  std::size_t cell = 0;
  for (const SharedSplit& shared : splits)
    for (const std::string& model : job.models) {
      if (job.share && !job.share->Has(cell++)) continue;
      ExperimentTask task = MakeTask(job, shared, model);
      ++run->experiments;
      if (ReadExperiment(task.folder)) {
        ++run->done;
      } else {
        todo.push_back({std::move(task), model, shared.seed});
      }
    }
  if (run->done > 0)
    control.Log(std::to_string(run->done) + " of " + std::to_string(run->experiments) +
                " runs are kept from " + job.out);
  const double count = static_cast<double>(todo.size());
  for (std::size_t i = 0; i < todo.size(); ++i) {
    const std::string name =
        NameFor(todo[i].task, todo[i].model, todo[i].seed, run->done + 1, run->experiments);
    const RunControl experiment{control.cancel, [&](double fraction, const std::string& note) {
                                  control.Report((i + fraction) / count, name + ", " + note);
                                }};
    if (!RunExperiment(todo[i].task, experiment)) return false;
    ++run->done;
  }
  return true;
}

}  // namespace

std::vector<std::string> ListComparisonCells(const ComparisonJob& job) {
  CheckJob(job);
  std::vector<std::string> cells;
  for (const int fabric : job.fabrics)
    for (const int seed : job.seeds)
      for (const std::string& model : job.models) cells.push_back(CellName(fabric, model, seed));
  return cells;
}

ComparisonRun RunComparison(const ComparisonJob& given, const RunControl& control) {
  CheckJob(given);
  const ComparisonJob job = WithMaterialSettings(given);
  CheckStudySettings(SettingsPath(job), job.settings, "runs");
  const std::vector<SharedSplit> splits = ShareAll(job, control);
  CheckFits(job, splits);
  WriteSettings(job, splits);
  ComparisonRun run;
  if (!RunExperiments(job, splits, control, &run)) {
    run.cancelled = true;
    return run;
  }
  if (job.share) return run;
  std::vector<ComparedExperiment> experiments;
  for (const SharedSplit& shared : splits) {
    for (const std::string& model : job.models) {
      const auto result = ReadExperiment(MakeTask(job, shared, model).folder);
      if (!result)
        throw InputError(MakeTask(job, shared, model).folder, "its files cannot be read back");
      experiments.push_back({shared.fabric, model, shared.seed, *result});
    }
    AddTrivial(shared, &experiments);
  }
  run.comparison =
      SumUp(experiments, InOrderOfComplexity(job.models), {kOtherSamples, kNormal, kCircle});
  return run;
}

}  // namespace drape
