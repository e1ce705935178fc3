// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_study.h"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using nlohmann::json;

// Work of a run in steps of a cloth of one vertex, for the time left.
double GuessWork(const BenchSetting& setting) {
  constexpr double kNewtonSteps = 40.0, kGrowth = 1.4;
  const double steps = (setting.integrator == "static" ? 0 : setting.steps()) +
                       (setting.integrator == "dynamic" ? 0 : kNewtonSteps);
  return setting.batch * steps * std::pow(ParseMeshSpec(setting.mesh).num_vertices(), kGrowth);
}

double GuessReferenceWork(const BenchJob& job) {
  const auto work = [](const std::string& mesh) {
    return GuessWork({.mesh = mesh, .integrator = "static"});
  };
  return (work(job.reference.fine) + work(job.reference.coarse)) / job.measuring.repeats;
}

// Reads what a run will read, so that bad names are found before hours are spent.
void CheckRun(const BenchJob& job, const BenchSetting& setting) {
  if (job.work != BenchWork::kFit && IsDistribution(setting))
    throw InputError("axis 'model'", "found " + setting.model + ", which only fits have");
  ReadMaterial(setting.material, {NegativeEntries::kWarn});
  for (const std::string& mesh : {setting.mesh, job.problem.coarse_mesh}) ParseMeshSpec(mesh);
  if (job.work == BenchWork::kFit) CheckBenchFit(setting, job.fit);
}

// The runs, and what they need of one another.
class Bench {
 public:
  explicit Bench(const BenchJob& job) : job_(job), runs_(ListRuns(job.work, job.axes)) {}

  Study MakeStudy() {
    Study study = EmptyStudy("bench");
    if (job_.work != BenchWork::kFit) CheckReference(job_.reference);
    for (const BenchSetting& run : runs_) {
      StudyCell cell =
          CheckedCell(RunName(job_.work, run), json(ListAxes(run)), [&] { CheckRun(job_, run); });
      cell.work = GuessWork(run);
      if (job_.work != BenchWork::kFit) AddReference(run, &cell);
      study.cells.push_back(std::move(cell));
    }
    for (std::size_t k = 0; k < runs_.size(); ++k)
      folders_.push_back(job_.out + "/fits/" + CellId(study, k));
    return study;
  }

  bool Prepare(std::size_t run, const RunControl& control) {
    return job_.work == BenchWork::kFit ? DrawSilhouette(control) : TakeReference(run, control);
  }

  json Run(std::size_t run, const RunControl& control) const {
    if (job_.work == BenchWork::kFit)
      return RunBenchFit(runs_[run], job_.fit, folders_[run], control.cancel);
    if (!reference_) return {{"status", "no reference"}, {"failure", no_reference_}};
    return RunBenchSetting(job_.work, runs_[run], job_.problem, *reference_, job_.measuring,
                           control.cancel);
  }

 private:
  Study EmptyStudy(const std::string& name) const {
    Study study;
    study.name = name;
    study.settings = job_.settings;
    study.files = job_.files;
    return study;
  }

  // Adds the reference of a run, unless an earlier run has it, and its id to the run's key.
  void AddReference(const BenchSetting& run, StudyCell* cell) {
    const std::string cloth = MaterialLabel(run.material) + " " + run.law + " " + run.model;
    if (references_.empty() || references_.back().cells.front().name != "reference of " + cloth) {
      references_.push_back(MakeReferenceStudy("reference of " + cloth, run));
      cell->work += references_.back().cells.front().work;
    }
    cell->input["reference"] = CellId(references_.back(), 0);
    reference_of_.push_back(references_.size() - 1);
  }

  Study MakeReferenceStudy(const std::string& name, const BenchSetting& run) const {
    const ReferenceOptions& options = job_.reference;
    Study study = EmptyStudy("bench_reference");
    study.settings = {{"drapefit", job_.settings.value("drapefit", "")},
                      {"work", ToString(job_.work)}};
    study.cells = {CheckedCell(
        name,
        {{"fine", NameWithoutFolder(options.fine)},
         {"coarse", NameWithoutFolder(options.coarse)},
         {"relax_mesh", NameWithoutFolder(options.relax_mesh)},
         {"backend", run.backend}},
        [&] {
          ReadMaterial(run.material, {NegativeEntries::kWarn});
          for (const std::string& mesh : {options.fine, options.coarse, options.relax_mesh})
            ParseMeshSpec(mesh);
        })};
    study.cells.front().work = GuessReferenceWork(job_);
    study.run = [this, run](std::size_t, const RunControl& control) {
      return FindReference(run, job_.problem, job_.reference, job_.work, control.cancel);
    };
    return study;
  }

  // Takes the reference of a run over or computes it; false when that was cancelled.
  bool TakeReference(std::size_t run, const RunControl& control) {
    const std::size_t wanted = reference_of_[run];
    if (found_ == wanted) return true;
    const Study& study = references_[wanted];
    const StudyOptions options = {.out = job_.out, .processes = true};
    const std::optional<json> found =
        RunStudy(study, options, {.cancel = control.cancel}).results.front();
    if (!found) return false;
    const std::string& name = study.cells.front().name;
    reference_.reset();
    if (found->contains("failure")) {
      no_reference_ = "no " + name + ": " + JsonInput(*found, name).At("failure").String() +
                      " (another start or mesh?)";
    } else {
      reference_ = ReadReference(*found, job_.reference, name);
    }
    found_ = wanted;
    return true;
  }

  // The image of a fit without images; false when drawing it was cancelled.
  bool DrawSilhouette(const RunControl& control) {
    if (!job_.fit.ground_truth || is_drawn_) return true;
    const ChildResult child = RunInChild(
        [&] {
          DrawGroundTruth(*job_.fit.ground_truth, job_.problem, job_.fit.data.images.front());
          return std::string();
        },
        control.cancel);
    is_drawn_ = !child.cancelled;
    return is_drawn_;
  }

  const BenchJob job_;
  const std::vector<BenchSetting> runs_;
  std::vector<std::string> folders_;       // of the files of each fit
  std::vector<Study> references_;          // of one cell each
  std::vector<std::size_t> reference_of_;  // each run
  // Of the run that is next: its reference, or why there is none.
  std::optional<std::size_t> found_;
  std::optional<BenchReference> reference_;
  std::string no_reference_;
  bool is_drawn_ = false;
};

}  // namespace

Study MakeBenchStudy(const BenchJob& job) {
  const auto bench = std::make_shared<Bench>(job);
  Study study = bench->MakeStudy();
  study.prepare = [bench](std::size_t run, const RunControl& control) {
    return bench->Prepare(run, control);
  };
  study.run = [bench](std::size_t run, const RunControl& control) {
    return bench->Run(run, control);
  };
  return study;
}

}  // namespace drape
