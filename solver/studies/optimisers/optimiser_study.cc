// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser_study.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "cuda/make_backend.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/random_drapes.h"
#include "solver/forward/settle.h"
#include "solver/job/fit_checkpoint.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The options under which any drape counts, however far from the prediction.
ResidualOptions AnyBranch(ResidualOptions options) {
  options.max_outline_change = options.max_jump = std::numeric_limits<double>::infinity();
  return options;
}

// A silhouette with its start tables.
struct Image {
  std::string name;
  FitData data;
  std::vector<ReadRecord::File> files = {};  // that a twin was drawn from
};

// A run of one method on an image.
struct Job {
  int parameters = 0;  // free numbers
  std::string method;
  int seed = 0;  // 0 where the method draws no random numbers
};

std::string RunName(const Image& image, const Job& job) {
  const std::string seed = job.seed == 0 ? "" : ".seed" + std::to_string(job.seed);
  return image.name + "_" + std::to_string(job.parameters) + "." + job.method + seed;
}

ParameterTying FreeNumbers(int parameters) {
  return ParseName<ParameterTying>(std::to_string(parameters), "option 'num_parameters'");
}

template <class T>
bool HasTwice(const std::vector<T>& values) {
  return std::set<T>(values.begin(), values.end()).size() < values.size();
}

void CheckOptions(const OptimiserStudyOptions& options) {
  if (options.twins.empty() && options.images.empty())
    throw InputError("twins", "is empty like images, expected at least one problem");
  for (const int count : options.parameters) FreeNumbers(count);
  if (HasTwice(options.parameters))
    throw InputError("num_parameters", "has one number twice, expected distinct ones");
  for (const std::string& name : options.methods) FindOptimiser(name);
  if (HasTwice(options.methods))
    throw InputError("methods", "names one twice, expected distinct names");
}

// The jobs of each image.
std::vector<Job> ListJobs(const OptimiserStudyOptions& options) {
  std::vector<std::string> methods = options.methods;
  if (methods.empty())
    for (const OptimiserMethod& method : OptimiserMethods())
      if (method.by_default) methods.push_back(method.name);
  std::vector<Job> jobs;
  for (const int parameters : options.parameters)
    for (const std::string& method : methods) {
      const bool random = FindOptimiser(method).random;
      for (int i = 0; i < (random ? options.seeds : 1); ++i)
        jobs.push_back({parameters, method, random ? options.optimiser.seed + i : 0});
    }
  return jobs;
}

// The silhouette of a fabric's drape at rest from a random start.
GrayImage TwinImage(const OptimiserStudyOptions& options, const MaterialField& fabric, int seed) {
  constexpr int kSupersample = 4;
  constexpr double kHemRms = 5e-3;  // of the starts [m]
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(options.twin_mesh),
                                                        CusickScene(options.spec.contact),
                                                        MakeLaw(options.spec.law));
  const State start = RandomStart(*model, seed, kHemRms);
  const auto backend = MakeCpuBackend(model, 1);
  const SettledDrape drape =
      std::move(Settle(*backend, fabric, {&start, 1}, {.steps = {.h = 0.1}}).front());
  if (!drape.IsUsable(SolveMode::kStatic))
    throw InputError("twin_seed", std::to_string(seed) +
                                      " gives a twin that does not come to rest, expected another");
  return Rasterize(model->mesh, drape.rest.x, Camera(), kSupersample);
}

std::string TwinName(const std::string& material, int seed) {
  return MaterialLabel(material) + "_" + std::to_string(seed);
}

// Their silhouettes are OUT/twins/<fabric>_<seed>.png, written unless the cells are only listed.
std::vector<Image> ListTwins(const OptimiserStudyOptions& options) {
  std::vector<Image> twins;
  int seed = options.twin_seed;
  for (const std::string& file : options.twins) {
    const ReadRecord record;
    const MaterialField fabric = ReadMaterial(file).field;
    Image twin{TwinName(file, seed), {}};
    const std::string folder = options.study.out + "/twins";
    twin.data.images = {folder + "/" + twin.name + ".png"};
    twin.data.material = options.material;
    twin.data.density = fabric.density;
    if (!options.study.list) {
      fs::create_directories(folder);
      WritePng(TwinImage(options, fabric, seed), twin.data.images.front());
    }
    twin.files = record.files();
    twins.push_back(std::move(twin));
    ++seed;
  }
  return twins;
}

std::vector<Image> ListSilhouettes(const OptimiserStudyOptions& options) {
  std::vector<std::string> files;
  for (const std::string& text : options.images)
    for (std::string& file : ExpandImages(text)) files.push_back(std::move(file));
  const std::vector<std::string>& materials = options.image_materials;
  if (!files.empty() && materials.size() != 1 && materials.size() != files.size())
    throw InputError("image_fabrics", "found " + std::to_string(materials.size()) +
                                          ", expected one for all or one for each of the " +
                                          std::to_string(files.size()) + " images");
  std::vector<Image> images;
  for (std::size_t i = 0; i < files.size(); ++i) {
    Image image{fs::path(files[i]).stem().string(), {}};
    image.data.images = {files[i]};
    image.data.material = materials[materials.size() == 1 ? 0 : i];
    images.push_back(std::move(image));
  }
  return images;
}

// Reads what the problems are made of, before a folder is made for them.
void CheckFiles(const OptimiserStudyOptions& options, const std::vector<Image>& silhouettes) {
  for (const Image& image : silhouettes) {
    ReadImageObservation(image.data.images.front(), options.spec.observation);
    ReadMaterial(image.data.material, {NegativeEntries::kWarn});
  }
  int seed = options.twin_seed;
  for (const std::string& twin : options.twins) {
    ReadMaterial(twin);
    CheckNameLength(twin, "start_" + TwinName(twin, seed++) + ".json");
  }
  if (!options.twins.empty()) ReadMaterial(options.material, {NegativeEntries::kWarn});
  for (const std::string& mesh : {options.twin_mesh, options.mesh, options.coarse_mesh})
    ParseMeshSpec(mesh);
  if (options.study.list) return;
  MakeBackend(options.spec.backend,
              std::make_shared<const ClothModel>(ParseMeshSpec(options.mesh),
                                                 CusickScene(options.spec.contact),
                                                 MakeLaw(options.spec.law)),
              1);
  CheckSearchScript(options.methods, options.optimiser);
  for (const char* result : {"compare_optimisers.json", "report.md", "runs.csv"})
    if (fs::exists(options.study.out)) CheckReplaceable(options.study.out + "/" + result);
}

FitSpec MakeSpec(const OptimiserStudyOptions& options) {
  FitSpec spec = options.spec;
  spec.mesh = options.mesh;
  spec.search_mesh = options.mesh;  // the race itself is on one mesh
  spec.coarse_mesh = options.coarse_mesh;
  spec.simpler_models = false;
  spec.stages.candidates_per_round = {1};
  spec.stages.iterations = {0};
  spec.stages.parameters = ParameterTying::kScales;
  return spec;
}

// An image with the initial guess that all methods start from, found when it is first needed.
class Problem {
 public:
  Problem(const OptimiserStudyOptions& options, const Image& image)
      : options_(options),
        spec_(MakeSpec(options)),
        input_(ReadFitInput(spec_, image.data)),
        key_(CheckpointKey(spec_, image.data, input_)) {}

  const std::string& key() const { return key_; }

  // Nothing when it was cancelled.
  std::optional<json> Run(const Job& job, const std::atomic<bool>* cancel) {
    if (!FindStart(cancel)) return std::nullopt;
    if (!start_->valid()) return json{{"failure", "no initial guess comes to rest"}};
    const std::unique_ptr<Backend> backend = MakeCpuBackend(input_.fine.model, 1);
    const TableParametrisation parametrisation(start_->base, FreeNumbers(job.parameters));
    DrapeFunction function(
        backend.get(), &parametrisation, input_.problem.observations, AtRest(start_->shapes),
        CandidateFitter(input_.problem, spec_.stages, *backend, cancel, 0).MakeResidualOptions(),
        spec_.stages.prior_sigma, !FindOptimiser(job.method).derivatives);
    OptimiserOptions optimiser = options_.optimiser;
    optimiser.published_rates = PublishedAdamRates(parametrisation.base(), parametrisation.tie());
    optimiser.seed = job.seed;
    optimiser.cancel = cancel;
    const OptimiserRun run = RunOptimiser(job.method, function, optimiser);
    if (run.cancelled) return std::nullopt;
    json result = ToJson(run);
    if (function.best_shapes().empty()) return result;
    result.update(
        Recheck(*backend, parametrisation.Material(run.theta), function.best_shapes().front()));
    return result;
  }

 private:
  // False when it was cancelled.
  bool FindStart(const std::atomic<bool>* cancel) {
    const std::scoped_lock lock(mutex_);
    if (start_) return true;
    StagedFitControl control;
    control.cancel = cancel;
    const StagedFitState state = RunStagedFit(input_.problem, spec_.stages, {}, control);
    if (cancel != nullptr && cancel->load()) return false;
    const FitCandidate* best = Best(state);
    start_ = best == nullptr ? FitCandidate() : *best;
    input_.problem.observations = LaidObservations(input_.problem, *start_);
    return true;
  }

  static json ToJson(const OptimiserRun& run) {
    json trace = json::array();
    for (const TracePoint& point : run.trace)
      trace.push_back({point.spent, point.seconds, point.cost});
    return {{"end", run.end},
            {"trace", trace},
            {"theta", run.theta},
            {"spent", run.spent},
            {"cpu_s", run.seconds},
            {"jacobian_cpu_s", run.jacobian_seconds},
            {"function_cpu_s", run.function_seconds},
            {"evaluations", run.evaluations},
            {"jacobians", run.jacobians},
            {"failed", run.failed}};
  }

  double RmsPx(const MaterialField& material, const Eigen::VectorXd& x) const {
    return Misfit(*input_.problem.observations.front().Measured(), *input_.fine.model, material, x)
        .value_or(std::numeric_limits<double>::infinity());
  }

  // What the drape of least cost is: its outline error, also where it comes to rest when nudged,
  // its stiffness, and its coordinates in micrometres.
  json Recheck(Backend& backend, const MaterialField& material,
               const Eigen::VectorXd& shape) const {
    constexpr double kMicrometre = 1e-6;
    StepSolver solver(input_.fine.model);
    const Eigen::VectorXd lowest = LowestEigenvalues(solver, material, shape, 1);
    const NudgedDrape nudged = Nudge(backend, material, shape, {});
    std::vector<int> coordinates;
    for (const double x : shape)
      coordinates.push_back(static_cast<int>(std::lround(x / kMicrometre)));
    return {{"rms_px", RmsPx(material, shape)},
            {"settled_rms_px", RmsPx(material, nudged.x)},
            {"drift_m", nudged.drift},
            {"coupling", LargestSquaredCoupling(material.stretch.front())},
            {"lowest_eigenvalue", lowest.size() > 0 ? lowest[0] : 0.0},
            {"shape_um", coordinates}};
  }

  const OptimiserStudyOptions& options_;
  const FitSpec spec_;
  FitInput input_;
  const std::string key_;
  std::mutex mutex_;
  std::optional<FitCandidate> start_;  // without shapes where no guess settles into a stable drape
};

}  // namespace

DrapeFunction::DrapeFunction(Backend* backend, const MaterialParametrisation* parametrisation,
                             std::vector<Observation> observations,
                             const std::vector<State>& starts, const ResidualOptions& options,
                             double prior_sigma, bool any_branch)
    : backend_(backend),
      observations_(std::move(observations)),
      options_(options),
      outlines_(ObservationResiduals(backend, parametrisation, observations_, starts,
                                     any_branch ? AnyBranch(options) : options)),
      prior_sigma_(prior_sigma) {}

void DrapeFunction::RefineFromBest() {
  if (best_shapes_.empty()) return;
  outlines_ = ObservationResiduals(backend_, &outlines_.parametrisation(), observations_,
                                   AtRest(best_shapes_), options_);
}

int DrapeFunction::num_residuals() const { return outlines_.num_residuals() + size(); }

bool DrapeFunction::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                             RowMatrix* jacobian) {
  Eigen::Map<Eigen::VectorXd>(outlines_.theta(), size()) = theta;
  const int capped = outlines_.counts().capped;
  outlines_.PrepareForEvaluation(false, true);
  cost_units_ = outlines_.counts().capped > capped ? 0.0 : 1.0;
  // A Jacobian starts from the drape of the trial, which must be valid for it.
  if (outlines_.all_valid() && jacobian != nullptr) outlines_.PrepareForEvaluation(true, false);
  if (!outlines_.all_valid()) return false;
  residual->resize(num_residuals());
  for (int i = 0; i < outlines_.num_blocks(); ++i)
    residual->segment(outlines_.first_row(i), outlines_.residual(i).size()) = outlines_.residual(i);
  residual->tail(size()) = theta / prior_sigma_;
  Keep(0.5 * residual->squaredNorm());
  if (jacobian == nullptr) return true;
  jacobian->setZero(num_residuals(), size());
  jacobian->topRows(outlines_.num_residuals()) = outlines_.accepted().jacobian;
  jacobian->bottomRows(size()).diagonal().setConstant(1.0 / prior_sigma_);
  return true;
}

void DrapeFunction::Keep(double cost) {
  if (!(cost < best_cost_)) return;
  best_cost_ = cost;
  best_shapes_.resize(outlines_.num_blocks());
  for (int i = 0; i < outlines_.num_blocks(); ++i) best_shapes_[i] = outlines_.shape(i);
}

Study MakeOptimiserStudy(const OptimiserStudyOptions& options) {
  CheckOptions(options);
  CheckShare(options.study);
  const std::vector<Job> jobs = ListJobs(options);
  std::vector<Image> silhouettes = ListSilhouettes(options);
  CheckFiles(options, silhouettes);
  std::vector<Image> images = ListTwins(options);
  images.insert(images.end(), silhouettes.begin(), silhouettes.end());
  Study study;
  study.name = "compare_optimisers";
  study.settings = {{"budget_rollouts", options.optimiser.budget},
                    {"jacobian_cost_units", options.optimiser.jacobian_cost_units}};
  const auto problems = std::make_shared<std::vector<std::unique_ptr<Problem>>>();
  std::set<std::string> names;
  for (const Image& image : images) {
    if (!names.insert(image.name).second)
      throw InputError(
          "images", "a second problem of the name '" + image.name + "', expected distinct names");
    StudyCell cell;
    if (!options.study.list) {
      cell = CheckedCell(image.name, {},
                         [&] { problems->push_back(std::make_unique<Problem>(options, image)); });
      cell.files.insert(cell.files.end(), image.files.begin(), image.files.end());
      cell.input = {{"fit", Sha256(problems->back()->key())}};
    }
    for (const Job& job : jobs) {
      cell.name = RunName(image, job);
      cell.names["problem"] = image.name + "_" + std::to_string(job.parameters);
      cell.input["num_parameters"] = job.parameters;
      cell.input["method"] = job.method;
      cell.input["seed"] = job.seed;
      study.cells.push_back(cell);
    }
  }
  study.run = [problems, jobs](std::size_t cell, const RunControl& control) {
    return (*problems)[cell / jobs.size()]->Run(jobs[cell % jobs.size()], control.cancel);
  };
  return study;
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
