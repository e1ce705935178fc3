// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_study.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "losses/camera/camera.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/silhouette/silhouette.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/observed/observation.h"
#include "solver/job/fit_input.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMetreInMillimetres = 1e3;

FitSpec MakeSpec(const BenchSetting& setting, FitSpec spec) {
  spec.law = ParseName<LawKind>(setting.law, "axis 'law'");
  spec.mesh = setting.mesh;
  spec.backend = setting.backend;
  spec.threads = setting.threads;
  spec.stages.residuals.solve_mode = ParseName<SolveMode>(setting.integrator, "axis 'solve'");
  spec.stages.residuals.rollout.h = setting.h;
  spec.stages.residuals.rollout.steps = setting.steps();
  const bool has_fields = setting.model.starts_with("heterogeneous");
  spec.model =
      has_fields ? FitModel::kHeterogeneous : ParseName<FitModel>(setting.model, "axis 'model'");
  spec.fields.basis =
      setting.model == "heterogeneous_modes" ? FieldBasis::kModes : FieldBasis::kElements;
  spec.posterior.draws = setting.draws;
  return spec;
}

struct HeldOutImage {
  GrayImage silhouette;
  Camera camera;
};
HeldOutImage ReadHeldOut(const std::string& file, const CameraInput& input,
                         const DrapeDiscs& discs) {
  HeldOutImage image{ReadSilhouette(file).image, {}};
  image.camera = MakeCamera(input, image.silhouette, discs, file);
  return image;
}

// Mean squared error of the fitted drapes on the images held out, each turned to fit best.
double HeldOutScore(const std::string& folder, const std::vector<std::string>& held_out,
                    const CameraInput& input) {
  double sum = 0.0;
  int pairs = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    if (file.path().extension() != ".obj") continue;
    const std::string fitted = file.path().string();
    const ObjSurface surface = ReadObjSurface(fitted);
    for (const std::string& image : held_out) {
      const DrapeDiscs discs = FindDiscs({}, {fitted, image});
      const auto [silhouette, camera] = ReadHeldOut(image, input, discs);
      sum += CompareDrapes(ObserveSurface(surface, camera, discs, fitted),
                           ObserveImage(silhouette, camera, discs, image), camera)
                 .aligned.mse;
      ++pairs;
    }
  }
  return pairs > 0 ? sum / pairs : std::nan("");
}

json ReadScores(const std::string& folder) {
  const std::string path = folder + "/summary.json";
  const json file = ReadJsonFile(path);
  const JsonInput mean = JsonInput(file, path).At("mean_settled");
  return {{"outline_px", mean.At("profile_rms_px").Number()},
          {"mse", mean.At("mse").Number()},
          {"hausdorff_mm", kMetreInMillimetres * mean.At("outline_hausdorff_m").Number()}};
}

FitData MakeData(const BenchSetting& setting, FitData data) {
  data.material = setting.material;
  return data;
}

// Reads all that the fit will read. Throws InputError for a file or a setting that a fit cannot
// have.
void CheckBenchFit(const BenchSetting& setting, const FitBenchOptions& options) {
  if (setting.integrator == "hybrid")
    throw InputError("axis 'solve'", "found hybrid, expected dynamic or static for a fit");
  if (setting.integrator == "dynamic" && setting.model != "homogeneous")
    throw InputError("axis 'solve'",
                     "found dynamic with model " + setting.model + ", expected static");
  if (IsDistribution(setting) && setting.draws % 2 != 0)
    throw InputError("axis 'draws'",
                     "found " + std::to_string(setting.draws) + ", expected an even number");
  for (const std::string& image : options.held_out)
    ReadHeldOut(image, options.spec.observation.camera, FindDiscs({}, {image}));
  if (options.ground_truth) {
    ReadMaterial(options.ground_truth->material, {NegativeEntries::kWarn});
    ParseMeshSpec(options.ground_truth->mesh);
    return;
  }
  FitSpec spec = MakeSpec(setting, options.spec);
  spec.backend = "cpu";  // a device that this process opens is lost to those that it forks
  ReadFitInput(spec, MakeData(setting, options.data));
}

// Writes the silhouette of a drape as a PNG. Throws InputError where there is no drape.
void DrawGroundTruth(const BenchSetting& setting, const BenchProblem& problem,
                     const std::string& path) {
  SettingSolver solver(setting, problem, nullptr);
  const BenchDrape drape = solver.Run(BenchWork::kForward);
  if (drape.status != "ok")
    throw InputError("option 'ground_truth'",
                     "no silhouette: " + drape.status + ", expected a drape");
  constexpr int kSupersample = 4;
  WritePng(Rasterize(solver.mesh(), drape.x, Camera(), kSupersample), path);
}

// Runs one fit in this process with its files in an empty `folder`: seconds, and errors from its
// summary.json, after it has settled.
json RunBenchFit(const BenchSetting& setting, const FitBenchOptions& options,
                 const std::string& folder, const std::atomic<bool>* cancel) {
  fs::remove_all(folder);  // of a run that was stopped
  fs::create_directories(folder);
  FitJobResult fit;
  const RunTimes times = TimeRuns(
      [&] {
        fit = RunFitJob(
            MakeSpec(setting, options.spec), MakeData(setting, options.data),
            {.out = folder, .checkpoint = folder + "/checkpoint.json", .log = folder + "/fit.log"},
            {.cancel = cancel});
      },
      1, 0.0);
  json result = {{"status", fit.fitted ? "ok" : "nothing fitted"},
                 {"seconds", times.wall.front()},
                 {"cpu_seconds", times.cpu.front()},
                 {"repeats", 1},
                 {"vertices", ParseMeshSpec(setting.mesh).num_vertices()}};
  if (!fit.fitted) return result;
  result.update(ReadScores(folder));
  if (!options.held_out.empty())
    result["held_out_mse"] =
        HeldOutScore(folder, options.held_out, options.spec.observation.camera);
  return result;
}

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
      cell.names = {{"material", MaterialLabel(run.material)},
                    {"mesh", NameWithoutFolder(run.mesh)}};
      cell.input.update({{"material", NameInKey(run.material)}, {"mesh", NameInKey(run.mesh)}});
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
    const std::array cloth = {run.material, run.law, run.model};
    if (references_.empty() || last_cloth_ != cloth) {
      references_.push_back(MakeReferenceStudy(
          "reference of " + MaterialLabel(run.material) + " " + run.law + " " + run.model, run));
      last_cloth_ = cloth;
      cell->work += references_.back().cells.front().work;
    }
    cell->input["reference"] = CellId(references_.back(), 0);
    reference_of_.push_back(references_.size() - 1);
  }

  Study MakeReferenceStudy(const std::string& name, const BenchSetting& run) const {
    const ReferenceOptions& options = job_.reference;
    Study study = EmptyStudy("bench_reference");
    study.settings = {{"work", ToString(job_.work)}};
    study.cells = {CheckedCell(
        name,
        {{"material", NameInKey(run.material)},
         {"law", run.law},
         {"model", run.model},
         {"fine", NameInKey(options.fine)},
         {"coarse", NameInKey(options.coarse)},
         {"relax_mesh", NameInKey(options.relax_mesh)},
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
  std::array<std::string, 3> last_cloth_;  // of the last of these
  std::vector<std::size_t> reference_of_;  // each run
  // The reference of the run that is next, or why there is none.
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
