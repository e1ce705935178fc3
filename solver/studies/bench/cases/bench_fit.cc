// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_fit.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/camera/camera.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/silhouette/silhouette.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/observation.h"
#include "solver/job/fit_input.h"
#include "solver/studies/bench/cases/run_times.h"

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

}  // namespace

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

}  // namespace drape
