// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_drape.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/outline/outline.h"
#include "losses/readout/readouts.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/statics/statics.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/forward/random_drapes.h"
#include "solver/studies/runner/study.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

// One thread runs the drapes of a batch one after the other.
bool RunsBatches(const BenchSetting& setting) {
  return setting.backend != "cpu" || setting.threads > 1;
}

// Each run with each value of an axis, or with the first one where it does not have the axis.
template <class Value>
void Multiply(const std::vector<Value>& values, Value BenchSetting::*member,
              std::vector<BenchSetting>* runs,
              const std::function<bool(const BenchSetting&)>& has_axis = nullptr) {
  std::vector<BenchSetting> product;
  for (const BenchSetting& run : *runs)
    for (const Value& value : values) {
      product.push_back(run);
      product.back().*member = value;
      if (has_axis && !has_axis(run)) break;
    }
  *runs = std::move(product);
}

double CpuSeconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// The fields of "heterogeneous_modes": one draw, the same on each mesh.
constexpr int kFieldModes = 8, kFieldSeed = 1, kFieldVertices = 300;
constexpr MaternOptions kField = {.length = 0.04, .sigma = 0.3};

// Log factors of a smooth random field at points of the cloth, shape [N].
Eigen::VectorXd LogFactors(const Eigen::Matrix2Xd& points) {
  const Mesh disc = MakeDisc({.target_vertices = kFieldVertices});
  const LaplaceModes modes = FindLaplaceModes(disc, kFieldModes);
  Eigen::VectorXd weights = MaternDeviations(modes.eigenvalues, kField);
  std::mt19937_64 random(kFieldSeed);
  for (double& weight : weights) weight *= SampleNormal(random);
  return InterpolationWeights(disc, points) * (modes.vectors * weights);
}

template <class Table>
void Scale(std::vector<Table>* tables, const Eigen::VectorXd& log_factors) {
  for (std::size_t e = 0; e < tables->size(); ++e) {
    double* entries = reinterpret_cast<double*>(&(*tables)[e]);
    for (std::size_t k = 0; k < sizeof(Table) / sizeof(double); ++k)
      entries[k] *= std::exp(log_factors[static_cast<Eigen::Index>(e)]);
  }
}

MaterialField MakeField(const std::string& model, MaterialField field, const Mesh& mesh) {
  if (model == "homogeneous") return field;
  field.stretch.resize(mesh.num_faces(), field.stretch[0]);
  field.bend.resize(mesh.num_hinges(), field.bend[0]);
  if (model == "heterogeneous_modes") {
    Scale(&field.stretch, LogFactors(FaceCentres(mesh)));
    Scale(&field.bend, LogFactors(HingeCentres(mesh)));
  }
  return field;
}

Eigen::VectorXd LossObservation() {
  return Eigen::VectorXd::Constant(kBenchAngles, kBenchLossRadius * Camera().pixels_per_metre());
}

// A drape read on another mesh is stretched at first, and Newton alone may not converge from it.
constexpr int kPreStartSteps = 20;

constexpr char kNoDerivative[] = "no derivative";

}  // namespace

std::shared_ptr<const ClothModel> MakeBenchModel(const std::string& mesh, const Law& law) {
  return std::make_shared<ClothModel>(
      ParseMeshSpec(mesh, {.round_to_float = !law.rejects_negative_entries()}), CusickScene(), law);
}

int BenchSetting::steps() const {
  return std::max(1, static_cast<int>(std::lround(relax_time / h)));
}

ordered_json ListAxes(const BenchSetting& setting) {
  ordered_json axes = {{"material", MaterialLabel(setting.material)},
                       {"law", setting.law},
                       {"model", setting.model}};
  if (IsDistribution(setting)) axes["draws"] = setting.draws;
  axes.update({{"mesh", NameWithoutFolder(setting.mesh)},
               {"solve", setting.integrator},
               {"time_step", setting.h},
               {"relax_time", setting.relax_time},
               {"tolerance", setting.tolerance},
               {"mode", setting.mode},
               {"backend", setting.backend},
               {"threads", setting.threads}});
  if (RunsBatches(setting)) axes["batch"] = setting.batch;
  return axes;
}

std::string RunName(BenchWork work, const BenchSetting& setting) {
  const ordered_json axes = ListAxes(setting), defaults = ListAxes(BenchSetting());
  std::string name = ToString(work);
  for (const auto& [axis, value] : axes.items())
    if (!defaults.contains(axis) || defaults.at(axis) != value)
      name += " " + axis + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
  return name;
}

bool IsDistribution(const BenchSetting& setting) {
  return setting.model == "bdp" || setting.model == "bayes";
}

std::vector<BenchSetting> ListRuns(BenchWork work, const BenchAxes& axes) {
  std::vector<BenchSetting> runs(1);
  Multiply(axes.material, &BenchSetting::material, &runs);
  Multiply(axes.law, &BenchSetting::law, &runs);
  Multiply(axes.model, &BenchSetting::model, &runs);
  Multiply(axes.draws, &BenchSetting::draws, &runs, IsDistribution);
  Multiply(axes.mesh, &BenchSetting::mesh, &runs);
  Multiply(axes.integrator, &BenchSetting::integrator, &runs);
  Multiply(axes.h, &BenchSetting::h, &runs);
  Multiply(axes.relax_time, &BenchSetting::relax_time, &runs);
  Multiply(axes.tolerance, &BenchSetting::tolerance, &runs);
  if (work == BenchWork::kGradient || work == BenchWork::kJacobian)
    Multiply(axes.mode, &BenchSetting::mode, &runs);
  Multiply(axes.backend, &BenchSetting::backend, &runs);
  Multiply(axes.threads, &BenchSetting::threads, &runs);
  Multiply(axes.batch, &BenchSetting::batch, &runs, RunsBatches);
  std::set<std::string> names;
  for (const BenchSetting& run : runs)
    if (const std::string name = RunName(work, run); !names.insert(name).second)
      throw InputError("axes", "found two runs '" + name +
                                   "', expected different values of each axis, and materials and "
                                   "meshes whose files have different names");
  return runs;
}

double WallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RunTimes TimeRuns(const std::function<void()>& run, int repeats, double seconds) {
  RunTimes times;
  const double clock = WallSeconds();
  do {
    const double wall = WallSeconds(), cpu = CpuSeconds();
    run();
    times.wall.push_back(WallSeconds() - wall);
    times.cpu.push_back(CpuSeconds() - cpu);
  } while (static_cast<int>(times.wall.size()) < repeats && WallSeconds() - clock < seconds);
  return times;
}

double MedianTime(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  const std::size_t n = times.size();
  return 0.5 * (times[(n - 1) / 2] + times[n / 2]);
}

double TimeSpread(const std::vector<double>& times) {
  const auto [least, most] = std::minmax_element(times.begin(), times.end());
  return *most - *least;
}

SettingSolver::SettingSolver(const BenchSetting& setting, const BenchProblem& problem,
                             const std::atomic<bool>* cancel)
    : setting_(setting), problem_(problem), cancel_(cancel) {
  const Law law = MakeLaw(setting.law);
  const auto model = MakeBenchModel(setting.mesh, law);
  const MaterialField homo = ReadMaterial(setting.material, ReadingPolicy(law)).field;
  material_ = MakeField(setting.model, homo, model->mesh);
  backend_ = MakeBackend(setting.backend, model, setting.threads);
  readout_ = std::make_unique<OutlineReadout>(mesh(), Camera(), kBenchAngles);
  if (setting.integrator != "static") return;
  const auto coarse = MakeBenchModel(problem.coarse_mesh, law);
  coarse_material_ = MakeField(setting.model, homo, coarse->mesh);
  coarse_ = MakeBackend(setting.backend, coarse, 1);
  from_coarse_ = InterpolationWeights(coarse->mesh, mesh().uv, Extrapolation::kLinear);
}

State SettingSolver::Seed(const Mesh& mesh) const {
  return {ApplyStartShape(mesh, DrapeDiscs().support, problem_.seed),
          Eigen::VectorXd::Zero(mesh.rest_x.size())};
}

RolloutOptions SettingSolver::Steps() const {
  return {.h = setting_.h, .steps = setting_.steps(), .cancel = cancel_};
}

SettleOptions SettingSolver::Settling() const {
  return {.steps = Steps(),
          .solve_mode = is_dynamic() ? SolveMode::kDynamic : SolveMode::kStatic,
          .equilibrium = {.tolerance = setting_.tolerance, .cancel = cancel_}};
}

std::vector<RolloutInput> SettingSolver::Batch(const State& state) const {
  return std::vector<RolloutInput>(setting_.batch, {&material_, &state});
}

BenchDrape SettingSolver::Seen(const std::string& status, Eigen::VectorXd x) const {
  BenchDrape drape{.status = status, .x = std::move(x)};
  if (status != "ok") return drape;
  if (!DrapeOutline(mesh(), drape.x, &drape.outline)) drape.status = "no outline";
  return drape;
}

RolloutStatus SettingSolver::StartFromCoarse(State* start) {
  const State seed = Seed(coarse_->model().mesh);
  const SettledDrape coarse = Settle(*coarse_, coarse_material_, {&seed, 1}, Settling()).front();
  if (coarse.steps != RolloutStatus::kOk) return coarse.steps;
  start->x = ReadPositions(from_coarse_, coarse.rest.x);
  start->v = Eigen::VectorXd::Zero(start->x.size());
  return RolloutStatus::kOk;
}

BenchDrape SettingSolver::DrapeAlone() {
  State start;
  SettleOptions settling = Settling();
  if (coarse_ != nullptr) {
    const RolloutStatus status = StartFromCoarse(&start);
    if (status != RolloutStatus::kOk) return {.status = ToString(status)};
    settling.steps.steps = kPreStartSteps;
  } else {
    start = Seed(mesh());
  }
  SettledDrape drape = std::move(Settle(*backend_, Batch(start), settling).front());
  if (drape.steps != RolloutStatus::kOk) return {.status = ToString(drape.steps)};
  const std::string status =
      drape.IsUsable(settling.solve_mode) ? "ok" : ToString(drape.rest.status);
  return Seen(status, std::move(drape.rest.x));
}

BenchDrape SettingSolver::StepTangents() {
  const State seed = Seed(mesh());
  const std::vector<const MaterialField*> weights(setting_.batch, &material_);
  const TangentResult tangent = backend_->Tangents(Batch(seed), weights, Steps()).front();
  BenchDrape drape = Seen(ToString(tangent.rollout.status), tangent.rollout.end.x);
  if (tangent.rollout.status == RolloutStatus::kOk)
    AddReadout(tangent.rollout.end.x, tangent.dx, &drape);
  return drape;
}

bool SettingSolver::AddReadout(const Eigen::VectorXd& x, const RowMatrix& dx, BenchDrape* drape) {
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  if (!readout_->Read(x, &r, &dr_dx)) return false;
  drape->jacobian = dr_dx * dx;
  drape->gradient = drape->jacobian.transpose() * (r - LossObservation());
  return true;
}

BenchDrape SettingSolver::StepAdjoint(bool of_loss) {
  const State seed = Seed(mesh());
  std::vector<Recording> recordings;
  const auto batch = Batch(seed);
  const RolloutResult end = backend_->Rollouts(batch, Steps(), &recordings).front();
  BenchDrape drape{.status = ToString(end.status)};
  if (!of_loss) drape = Seen(drape.status, end.end.x);
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  if (drape.status != "ok" || !readout_->Read(end.end.x, &r, &dr_dx)) return drape;
  const RowMatrix dL_dx = of_loss ? RowMatrix(dr_dx.transpose() * (r - LossObservation()))
                                  : RowMatrix(dr_dx.transpose());
  const std::vector<RowMatrix> seeds(batch.size(), dL_dx);
  const AdjointResult adjoint = backend_->Adjoints(batch, recordings, seeds, Steps()).front();
  if (adjoint.status != RolloutStatus::kOk) return {.status = ToString(adjoint.status)};
  const RowMatrix gradients = adjoint.material.Contract(material_);
  if (of_loss) {
    drape.gradient = gradients;
  } else {
    drape.jacobian = gradients.transpose();
  }
  return drape;
}

void SettingSolver::AddTangents(const State& rest, BenchDrape* drape) {
  const std::vector<const MaterialField*> weights(setting_.batch, &material_);
  const RowMatrix dx = backend_->EquilibriumTangents(Batch(rest), weights).front();
  if (dx.size() == 0 || !AddReadout(rest.x, dx, drape)) drape->status = kNoDerivative;
}

void SettingSolver::AddAdjoint(const State& rest, bool of_loss, BenchDrape* drape) {
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  drape->status = kNoDerivative;
  if (!readout_->Read(rest.x, &r, &dr_dx)) return;
  const RowMatrix seed = of_loss ? RowMatrix(dr_dx.transpose() * (r - LossObservation()))
                                 : RowMatrix(dr_dx.transpose());
  const std::vector<RowMatrix> seeds(setting_.batch, seed);
  const auto adjoint = backend_->EquilibriumAdjoints(Batch(rest), seeds).front();
  if (!adjoint) return;
  const RowMatrix gradients = adjoint->Contract(material_);
  if (of_loss) {
    drape->gradient = gradients;
  } else {
    drape->jacobian = gradients.transpose();
  }
  drape->status = "ok";
}

BenchDrape SettingSolver::Differentiate(BenchWork work) {
  const bool by_tangents = setting_.mode == "tangent";
  const bool of_loss = work == BenchWork::kGradient;
  if (is_dynamic()) return by_tangents ? StepTangents() : StepAdjoint(of_loss);
  BenchDrape drape = DrapeAlone();
  if (drape.status != "ok") return drape;
  const State rest{drape.x, Eigen::VectorXd::Zero(drape.x.size())};
  if (by_tangents) {
    AddTangents(rest, &drape);
  } else {
    AddAdjoint(rest, of_loss, &drape);
  }
  return drape;
}

RestMeasure SettingSolver::MeasureRest(const Eigen::VectorXd& x) {
  const NudgedDrape nudged = Nudge(*backend_, material_, x, {.cancel = cancel_});
  return {.residual = ForceResidual(backend_->model(), material_, x),
          .drift = nudged.status == EquilibriumStatus::kStable
                       ? nudged.drift
                       : std::numeric_limits<double>::infinity()};
}

BenchDrape SettingSolver::Run(BenchWork work) {
  return work == BenchWork::kForward ? DrapeAlone() : Differentiate(work);
}

}  // namespace drape
