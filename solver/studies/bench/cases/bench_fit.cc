// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_fit.h"

#include <glog/logging.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/camera/camera.h"
#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/silhouette/silhouette.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/observation.h"
#include "solver/job/fit_input.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr double kMillimetres = 1e3;

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

// Of the files of one fit.
std::string FolderName(const BenchSetting& setting) {
  std::string name = CheckpointKey(BenchWork::kFit, setting);
  for (char& c : name)
    if (c == ' ' || c == '/' || c == ':' || c == '=') c = '_';
  return name;
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

void ReadScores(const std::string& folder, BenchRecord* record) {
  const std::string path = folder + "/summary.json";
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput mean = JsonInput(file, path).At("mean_settled");
  (*record)[kOutlinePx] = mean.At("profile_rms_px").Number();
  (*record)[kMse] = mean.At("mse").Number();
  (*record)[kHausdorffMm] = kMillimetres * mean.At("outline_hausdorff_m").Number();
}

}  // namespace

void CheckBenchFit(const BenchSetting& setting) {
  if (setting.integrator == "hybrid")
    throw InputError("axis 'solve'", "found hybrid, expected dynamic or static for a fit");
  if (setting.integrator == "dynamic" && setting.model != "homogeneous")
    throw InputError("axis 'solve'",
                     "found dynamic with model " + setting.model + ", expected static");
  if (IsDistribution(setting) && setting.draws % 2 != 0)
    throw InputError("axis 'draws'",
                     "found " + std::to_string(setting.draws) + ", expected an even number");
  CheckNameLength(setting.material, FolderName(setting));
}

void CheckBenchImages(const FitBenchOptions& options) {
  std::vector<Observation> images;
  if (!options.ground_truth)
    for (const std::string& image : options.data.images)
      images.push_back(ReadImageObservation(image, options.spec.observation));
  CheckNames(images);
  for (const std::string& image : options.held_out)
    ReadHeldOut(image, options.spec.observation.camera, FindDiscs({}, {image}));
}

std::string RenderGroundTruth(const BenchSetting& setting, const BenchProblem& problem) {
  SettingSolver solver(setting, problem, nullptr);
  const BenchDrape drape = solver.Run(BenchWork::kForward);
  if (drape.status != "ok")
    throw InputError("option 'ground_truth'",
                     "no silhouette: " + drape.status + ", expected a drape");
  constexpr int kSupersample = 4;
  const std::vector<float> coverage =
      Rasterize(solver.mesh(), drape.x, Camera(), kSupersample).coverage;
  return {reinterpret_cast<const char*>(coverage.data()), coverage.size() * sizeof(float)};
}

void WriteGroundTruth(const std::string& rendered, const std::string& path) {
  GrayImage image(Camera().width, Camera().height);
  CHECK_EQ(rendered.size(), image.coverage.size() * sizeof(float));
  std::memcpy(image.coverage.data(), rendered.data(), rendered.size());
  WritePng(image, path);
}

BenchRecord RunBenchFit(const BenchSetting& setting, const FitBenchOptions& options,
                        const std::string& folder, const std::atomic<bool>* cancel) {
  const std::string files = folder + "/" + FolderName(setting);
  fs::create_directories(files);
  BenchRecord record;
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  FitData data = options.data;
  data.material = setting.material;
  const FitJobResult result =
      RunFitJob(MakeSpec(setting, options.spec), data,
                {.out = files, .checkpoint = files + "/checkpoint.json", .log = files + "/fit.log"},
                {.cancel = cancel});
  record[kWallSeconds] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  record[kCpuSeconds] = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  record[kRepeats] = 1;
  record[kVertices] = ParseMeshSpec(setting.mesh).num_vertices();
  record.status = result.fitted ? "ok" : "nothing fitted";
  if (!result.fitted) return record;
  ReadScores(files, &record);
  if (!options.held_out.empty())
    record[kHeldOutMse] = HeldOutScore(files, options.held_out, options.spec.observation.camera);
  return record;
}

}  // namespace drape
