// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_problem.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "losses/outline/shape_features.h"
#include "losses/silhouette/raster.h"
#include "physics/cloth/start_shape.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/statics/modes.h"
#include "physics/util/errors.h"
#include "solver/fit/parameters/coupled_table.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/fit_checkpoint.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/settle.h"
#include "solver/studies/optimisers/drape_function.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// The silhouette of a fabric's drape at rest from a random start.
GrayImage TwinImage(const OptimiserBenchmarkOptions& options, const MaterialField& fabric,
                    int seed) {
  constexpr int kSupersample = 4;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(options.twin_mesh),
                                                        CusickScene(options.spec.contact),
                                                        MakeLaw(options.spec.law));
  State start = model->RestState();
  start.x = ApplyStartShape(model->mesh, DrapeDiscs().support,
                            RandomStartShape(static_cast<uint64_t>(seed), options.twin_hem_rms));
  const auto backend = MakeCpuBackend(model, 1);
  const SettledDrape drape =
      std::move(Settle(*backend, fabric, {&start, 1}, {.steps = {.h = 0.1}}).front());
  if (!drape.IsUsable(SolveMode::kStatic))
    throw InputError("twin_seed", std::to_string(seed) +
                                      " gives a twin that does not come to rest, expected another");
  return Rasterize(model->mesh, drape.rest.x, Camera(), kSupersample);
}

BenchmarkImage MakeTwin(const OptimiserBenchmarkOptions& options, int index) {
  const std::string& file = options.twins[index];
  const Material fabric = ReadMaterial(file);
  const int seed = options.twin_seed + index;
  BenchmarkImage twin{MaterialLabel(file) + "_" + std::to_string(seed), {}, true};
  twin.data.images = {options.out + "/twins/" + twin.name + ".png"};
  twin.data.material = options.material;
  twin.data.density = fabric.field.density;
  return twin;
}

// Reads what the problems are made of, before a folder is made for them.
void CheckFiles(const OptimiserBenchmarkOptions& options, const std::vector<std::string>& images) {
  for (const std::string& twin : options.twins) ReadMaterial(twin);
  for (const std::string& image : images) ReadImageObservation(image, options.spec.observation);
  std::vector<std::string> starts = options.image_materials;
  if (!options.twins.empty()) starts.push_back(options.material);
  for (const std::string& start : starts) ReadMaterial(start, {NegativeEntries::kWarn});
  for (const std::string& mesh : {options.twin_mesh, options.mesh, options.coarse_mesh})
    ParseMeshSpec(mesh);
}

void RequireDistinct(const std::vector<BenchmarkImage>& images) {
  std::set<std::string> names;
  for (const BenchmarkImage& image : images)
    if (!names.insert(image.name).second)
      throw InputError(
          "images", "a second problem of the name '" + image.name + "', expected distinct names");
}

double RmsPx(const FitInput& input, const Eigen::VectorXd& x) {
  return OutlineRms(input.fine.model->mesh, x, input.problem.observations.front())
      .value_or(std::numeric_limits<double>::infinity());
}

void Recheck(const FitInput& input, Backend& backend, const MaterialField& material,
             BenchmarkRecord* record) {
  record->coupling = LargestSquaredCoupling(material.stretch.front());
  record->rms_px = record->settled_rms_px = RmsPx(input, record->shape);
  StepSolver solver(input.fine.model);
  const Eigen::VectorXd lowest = LowestEigenvalues(solver, material, record->shape, 1);
  if (lowest.size() > 0) record->stiffness = lowest[0];
  const NudgedDrape nudged = Nudge(backend, material, record->shape, {});
  record->settled_rms_px = RmsPx(input, nudged.x);
  record->drift = nudged.drift;
}

}  // namespace

std::vector<double> ReportedBudgets(const OptimiserBenchmarkOptions& options) {
  std::set<double> budgets = {options.optimiser.budget};
  for (const double checkpoint : options.checkpoints)
    if (checkpoint < options.optimiser.budget) budgets.insert(checkpoint);
  return {budgets.begin(), budgets.end()};
}

std::vector<BenchmarkImage> ListBenchmarkImages(const OptimiserBenchmarkOptions& options) {
  std::vector<BenchmarkImage> images;
  std::vector<std::string> files;
  for (const std::string& text : options.images)
    for (std::string& file : ExpandImages(text)) files.push_back(std::move(file));
  CheckFiles(options, files);
  for (std::size_t i = 0; i < options.twins.size(); ++i)
    images.push_back(MakeTwin(options, static_cast<int>(i)));
  const std::size_t materials = options.image_materials.size();
  if (!files.empty() && materials != 1 && materials != files.size())
    throw InputError("image_materials", "found " + std::to_string(materials) +
                                            ", expected one for all or one for each of the " +
                                            std::to_string(files.size()) + " images");
  for (std::size_t i = 0; i < files.size(); ++i) {
    BenchmarkImage image{fs::path(files[i]).stem().string(), {}, false};
    image.data.images = {files[i]};
    image.data.material = options.image_materials[materials == 1 ? 0 : i];
    images.push_back(std::move(image));
  }
  RequireDistinct(images);
  return images;
}

void RenderTwins(const OptimiserBenchmarkOptions& options) {
  for (std::size_t i = 0; i < options.twins.size(); ++i) {
    const int index = static_cast<int>(i);
    const std::string path = MakeTwin(options, index).data.images.front();
    if (fs::exists(path)) continue;
    fs::create_directories(options.out + "/twins");
    const MaterialField fabric = ReadMaterial(options.twins[i]).field;
    WritePng(TwinImage(options, fabric, options.twin_seed + index), path);
  }
}

BenchmarkStart FindBenchmarkStart(const OptimiserBenchmarkOptions& options,
                                  const BenchmarkImage& image, const std::atomic<bool>* cancel) {
  FitSpec spec = options.spec;
  if (image.is_twin) spec.observation.camera = {};  // the one that rendered it
  spec.mesh = options.mesh;
  spec.search_mesh = options.mesh;  // the race itself is on one mesh
  spec.coarse_mesh = options.coarse_mesh;
  spec.simpler_models = false;
  spec.stages.candidates_per_round = {1};
  spec.stages.iterations = {0};
  spec.stages.parameters = ParameterTying::kScales;
  BenchmarkStart start{spec, image.data, ReadFitInput(spec, image.data), {}};
  const std::string path = options.out + "/runs/" + image.name + ".start.json";
  const std::string key = CheckpointKey(spec, image.data, start.input);
  StagedFitState state =
      ReadCheckpoint(path, key, start.input.problem, spec.stages).value_or(StagedFitState());
  if (Best(state) == nullptr) {
    StagedFitControl control;
    control.cancel = cancel;
    state = RunStagedFit(start.input.problem, spec.stages, {}, control);
    if (cancel != nullptr && cancel->load()) return start;
    WriteCheckpoint(path, key, state);
  }
  if (Best(state) != nullptr) start.candidate = *Best(state);
  return start;
}

BenchmarkRecord RunMethod(const BenchmarkStart& start, const OptimiserBenchmarkOptions& options,
                          const BenchmarkJob& job, const std::atomic<bool>* cancel) {
  const FitInput& input = start.input;
  const StagedFitOptions& stages = start.spec.stages;
  const std::unique_ptr<Backend> backend = MakeCpuBackend(input.fine.model, 1);
  const TableParametrisation parametrisation(
      start.candidate.base,
      ParseName<ParameterTying>(std::to_string(job.parameters), "num_parameters"));
  DrapeFunction function(
      backend.get(), &parametrisation, &input.problem.observations, AtRest(start.candidate.shapes),
      CandidateFitter(input.problem, stages, *backend, cancel, 0).MakeResidualOptions(),
      stages.prior_sigma,
      FindOptimiser(job.method).derivatives ? BranchRule::kFollow : BranchRule::kAny);
  OptimiserOptions optimiser = options.optimiser;
  optimiser.published_rates = PublishedAdamRates(parametrisation.base(), parametrisation.tie());
  optimiser.seed = job.seed;
  optimiser.cancel = cancel;
  BenchmarkRecord record;
  record.parameters = job.parameters;
  record.seed = job.seed;
  record.run = RunOptimiser(job.method, function, optimiser);
  if (function.best_shapes().empty() || record.run.cancelled) return record;
  record.shape = function.best_shapes().front();
  Recheck(input, *backend, parametrisation.Material(record.run.theta), &record);
  return record;
}

Eigen::VectorXd PublishedAdamRates(const MaterialField& material, const Eigen::MatrixXd& tie) {
  constexpr double kStretchRate = 1e-14, kBendRate = 3e-6;
  Eigen::VectorXd rates = Eigen::VectorXd::Zero(tie.cols());
  for (Eigen::Index i = 0; i < tie.cols(); ++i) {
    double entries = 0.0, rate = 0.0;
    for (int entry = 0; entry < kMaterialEntries; ++entry) {
      const bool stretch = entry < kStretchEntries;
      const double value = stretch ? material.stretch[0].entries()[entry]
                                   : material.bend[0].entries()[entry - kStretchEntries];
      entries += tie(entry, i) * value;
      rate += tie(entry, i) * (stretch ? kStretchRate : kBendRate);
    }
    rates[i] = rate / entries;
  }
  return rates;
}

}  // namespace drape
