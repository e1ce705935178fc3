// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/work_precision.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "physics/mesh/interpolation.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/forward/random_drapes.h"
#include "solver/studies/bench/cases/run_times.h"
#include "solver/studies/bench/richardson.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr double kMillimetres = 1e3;  // a metre

constexpr StoredFormat kReferenceFormat = {"drapefit-bench-reference", 1};

constexpr double kSameOutline = 1e-9;  // [m]

double Rms(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.size()));
}

std::vector<double> Numbers(const auto& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

json DrapeJson(const BenchDrape& drape) {
  return {{"status", drape.status},
          {"x", Numbers(drape.x)},
          {"outline", Numbers(drape.outline)},
          {"gradient", Numbers(drape.gradient)},
          {"jacobian", Numbers(drape.jacobian)}};
}

// Of that size, or none.
Eigen::VectorXd ReadDerivative(const JsonInput& input, int size) {
  return input.ExpectArray().Size() == 0 ? Eigen::VectorXd() : input.Vector(size);
}

BenchDrape ReadDrape(const JsonInput& input, const Mesh& mesh, const std::string& mesh_name) {
  input.ExpectKeys({"status", "x", "outline", "gradient", "jacobian"});
  BenchDrape drape;
  drape.status = input.At("status").String();
  if (drape.status != "ok")
    throw NoReference(input.Name(), "the drape on " + mesh_name + " is '" + drape.status + "'");
  drape.x = input.At("x").Vector(static_cast<int>(mesh.rest_x.size()));
  drape.outline = input.At("outline").Vector(kBranchAngles);
  Eigen::VectorXd outline;
  if (!DrapeOutline(mesh, drape.x, &outline) ||
      !((outline - drape.outline).cwiseAbs().maxCoeff() <= kSameOutline))
    throw InputError(input.Name(),
                     "the outline is not that of x, expected a file as it was written");
  drape.gradient = ReadDerivative(input.At("gradient"), kMaterialEntries);
  const Eigen::VectorXd entries =
      ReadDerivative(input.At("jacobian"), kBenchAngles * kMaterialEntries);
  drape.jacobian = Eigen::Map<const RowMatrix>(entries.data(), entries.size() / kMaterialEntries,
                                               kMaterialEntries);
  return drape;
}

double CircleRadius(double area) { return std::sqrt(area / std::numbers::pi); }

// Folds may turn about the support, at next to no energy, so outlines are turned to match.
bool IsOnBranch(const Eigen::VectorXd& reference, const Eigen::VectorXd& outline,
                double branch_mm) {
  const double apart = MatchOutlines(reference, outline, OutlineFreedom::kRotation).rms;
  return kMillimetres * apart <= branch_mm && CountFolds(reference) == CountFolds(outline);
}

double RelativeError(const auto& found, const auto& reference) {
  return (found - reference).norm() / reference.norm();
}

// Median and spread of one measure of all runs.
void FillTimes(const std::vector<double>& times, int batch, BenchMeasure median,
               BenchMeasure spread, BenchRecord* record) {
  (*record)[median] = MedianTime(times) / batch;
  (*record)[spread] = TimeSpread(times) / batch;
}

}  // namespace

Eigen::VectorXd BenchReference::PositionsAt(const Eigen::Matrix2Xd& points) const {
  const auto read = [&](const Mesh& mesh, const BenchDrape& drape) {
    return ReadPositions(InterpolationWeights(mesh, points, Extrapolation::kLinear), drape.x);
  };
  return Extrapolate<Eigen::VectorXd>(read(fine_mesh, fine), read(coarse_mesh, coarse), ratio,
                                      order);
}

Eigen::VectorXd BenchReference::outline() const {
  return Extrapolate(fine.outline, coarse.outline, ratio, order);
}

double BenchReference::area() const {
  return Extrapolate(ProfileArea(fine.outline), ProfileArea(coarse.outline), ratio, order);
}

Eigen::VectorXd BenchReference::gradient() const {
  return Extrapolate(fine.gradient, coarse.gradient, ratio, order);
}

RowMatrix BenchReference::jacobian() const {
  return Extrapolate(fine.jacobian, coarse.jacobian, ratio, order);
}

BenchRecord BenchReference::ErrorEstimate(BenchWork work) const {
  BenchRecord record;
  record[kVertices] = fine_mesh.num_vertices();
  MeasureErrors(*this, fine_mesh, fine, work, &record);
  return record;
}

std::string ReferenceText(const BenchSetting& setting, const BenchProblem& problem,
                          const ReferenceOptions& options, BenchWork work,
                          const std::atomic<bool>* cancel) {
  BenchSetting at_rest = setting;
  at_rest.integrator = "static";
  at_rest.h = options.h;
  at_rest.relax_time = options.relax_seconds;
  at_rest.tolerance = 1e-9;
  at_rest.mode = work == BenchWork::kJacobian ? "tangent" : "adjoint";
  at_rest.batch = 1;
  BenchProblem relaxed_on_coarse = problem;
  relaxed_on_coarse.coarse_mesh = options.relax_mesh;
  json text;
  for (const auto& [name, mesh] : {std::pair("fine", options.fine), {"coarse", options.coarse}}) {
    at_rest.mesh = mesh;
    text[name] = DrapeJson(SettingSolver(at_rest, relaxed_on_coarse, cancel).Run(work));
  }
  return StoredJsonText(kReferenceFormat, text);
}

BenchReference ParseReference(const std::string& text, const ReferenceOptions& options,
                              const std::string& where) {
  const json file = ParseStoredJson(text, where, kReferenceFormat);
  const JsonInput input(file, where);
  input.ExpectKeys({"fine", "coarse"});
  BenchReference reference;
  reference.fine_mesh = ParseMeshSpec(options.fine);
  reference.coarse_mesh = ParseMeshSpec(options.coarse);
  reference.fine = ReadDrape(input.At("fine"), reference.fine_mesh, options.fine);
  reference.coarse = ReadDrape(input.At("coarse"), reference.coarse_mesh, options.coarse);
  reference.ratio = std::sqrt(static_cast<double>(reference.fine_mesh.num_vertices()) /
                              reference.coarse_mesh.num_vertices());
  reference.order = options.order;
  if (!(reference.ratio > 1))
    throw InputError("option 'reference'", "found " + options.fine + " after " + options.coarse +
                                               ", expected a finer mesh");
  return reference;
}

void MeasureErrors(const BenchReference& reference, const Mesh& mesh, const BenchDrape& drape,
                   BenchWork work, BenchRecord* record) {
  const Eigen::VectorXd outline = reference.outline();
  if (drape.outline.size() > 0) {
    (*record)[kVertexMm] = kMillimetres * VertexDistance(drape.x, reference.PositionsAt(mesh.uv));
    (*record)[kOutlineMm] = kMillimetres * Rms(drape.outline, outline);
    const double area = reference.area();
    (*record)[kRadiusMm] =
        kMillimetres * std::abs(CircleRadius(ProfileArea(drape.outline)) - CircleRadius(area));
    (*record)[kDrapeCoefficient] = DrapeCoefficient(ProfileArea(drape.outline), DrapeDiscs());
    (*record)[kDrapeCoefficientError] =
        std::abs((*record)[kDrapeCoefficient] - DrapeCoefficient(area, DrapeDiscs()));
    (*record)[kFolds] = CountFolds(drape.outline);
  }
  if (work == BenchWork::kGradient && drape.gradient.size() > 0)
    (*record)[kDerivativeError] = RelativeError(drape.gradient, reference.gradient());
  if (work == BenchWork::kJacobian && drape.jacobian.size() > 0)
    (*record)[kDerivativeError] = RelativeError(drape.jacobian, reference.jacobian());
}

BenchRecord RunBenchSetting(BenchWork work, const BenchSetting& setting,
                            const BenchProblem& problem, const BenchReference& reference,
                            const MeasuringOptions& options, const std::atomic<bool>* cancel) {
  const double begin = WallSeconds();
  SettingSolver solver(setting, problem, cancel);
  BenchRecord record;
  record[kVertices] = solver.mesh().num_vertices();
  record[kSetupSeconds] = WallSeconds() - begin;
  BenchDrape drape;
  const RunTimes times =
      TimeRuns([&] { drape = solver.Run(work); }, options.repeats, options.seconds);
  record[kRepeats] = static_cast<double>(times.wall.size());
  FillTimes(times.wall, setting.batch, kWallSeconds, kWallSpread, &record);
  FillTimes(times.cpu, setting.batch, kCpuSeconds, kCpuSpread, &record);
  record.status = drape.status;
  if (!record.ok()) return record;
  if (drape.x.size() == 0) {  // a gradient alone comes back from the steps
    const Eigen::VectorXd gradient = drape.gradient;
    drape = solver.Run(BenchWork::kForward);
    drape.gradient = gradient;
  }
  MeasureErrors(reference, solver.mesh(), drape, work, &record);
  const RestMeasure rest = solver.MeasureRest(drape.x);
  record[kForceResidual] = rest.residual;
  record[kDriftMm] = kMillimetres * rest.drift;
  if (!IsOnBranch(reference.fine.outline, drape.outline, options.branch_mm)) {
    record.status = kRunOnOtherBranch;
  } else if (!rest.IsAtRest()) {
    record.status = kRunNotAtRest;
  }
  return record;
}

}  // namespace drape
