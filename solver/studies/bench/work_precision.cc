// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/work_precision.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/forward/random_drapes.h"
#include "solver/studies/bench/bench_drape.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr double kMillimetres = 1e3;  // a metre

double Rms(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.size()));
}

json DrapeJson(const BenchDrape& drape) {
  return {{"x", drape.x},
          {"gradient", drape.gradient},
          {"jacobian", drape.jacobian.reshaped<Eigen::RowMajor>()}};
}

// Reads a derivative of that size, or none.
Eigen::VectorXd ReadDerivative(const JsonInput& input, int size) {
  return input.ExpectArray().Size() == 0 ? Eigen::VectorXd() : input.Vector(size);
}

BenchDrape ReadDrape(const JsonInput& input, const Mesh& mesh) {
  BenchDrape drape{.status = "ok", .x = input.At("x").Vector(static_cast<int>(mesh.rest_x.size()))};
  if (!DrapeOutline(mesh, drape.x, &drape.outline)) input.At("x").Fail("a drape with an outline");
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

// Median and spread of the times of all runs.
void AddTimes(const std::vector<double>& times, int batch, const std::string& median,
              const std::string& spread, json* result) {
  (*result)[median] = MedianTime(times) / batch;
  (*result)[spread] = TimeSpread(times) / batch;
}

double SizeRatio(const Mesh& fine, const Mesh& coarse) {
  return std::sqrt(static_cast<double>(fine.num_vertices()) / coarse.num_vertices());
}

// The errors of a drape against a reference, as RunBenchSetting gives them.
json MeasureErrors(const BenchReference& reference, const Mesh& mesh, const BenchDrape& drape,
                   BenchWork work) {
  json errors = json::object();
  if (drape.outline.size() > 0) {
    const double area = ProfileArea(drape.outline), limit = reference.area();
    const double dc = DrapeCoefficient(area, DrapeDiscs());
    errors = {{"vertex_mm", kMillimetres * VertexDistance(drape.x, reference.PositionsAt(mesh.uv))},
              {"outline_mm", kMillimetres * Rms(drape.outline, reference.outline())},
              {"radius_mm", kMillimetres * std::abs(CircleRadius(area) - CircleRadius(limit))},
              {"dc", dc},
              {"dc_error", std::abs(dc - DrapeCoefficient(limit, DrapeDiscs()))},
              {"folds", CountFolds(drape.outline)}};
  }
  if (work == BenchWork::kGradient && drape.gradient.size() > 0)
    errors["derivative_error"] = RelativeError(drape.gradient, reference.gradient());
  if (work == BenchWork::kJacobian && drape.jacobian.size() > 0)
    errors["derivative_error"] = RelativeError(drape.jacobian, reference.jacobian());
  return errors;
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

void CheckReference(const ReferenceOptions& options) {
  if (!(SizeRatio(ParseMeshSpec(options.fine), ParseMeshSpec(options.coarse)) > 1))
    throw InputError("option 'reference'", "found " + options.fine + " after " + options.coarse +
                                               ", expected a finer mesh");
}

json FindReference(const BenchSetting& setting, const BenchProblem& problem,
                   const ReferenceOptions& options, BenchWork work,
                   const std::atomic<bool>* cancel) {
  constexpr double kTimeStep = 0.05, kRelaxSeconds = 10.0;
  BenchSetting at_rest = setting;
  at_rest.integrator = "static";
  at_rest.h = kTimeStep;
  at_rest.relax_time = kRelaxSeconds;
  at_rest.tolerance = 1e-9;
  at_rest.mode = work == BenchWork::kJacobian ? "tangent" : "adjoint";
  at_rest.batch = 1;
  BenchProblem relaxed_on_coarse = problem;
  relaxed_on_coarse.coarse_mesh = options.relax_mesh;
  json found;
  for (const auto& [name, mesh] : {std::pair("fine", options.fine), {"coarse", options.coarse}}) {
    at_rest.mesh = mesh;
    const BenchDrape drape = SettingSolver(at_rest, relaxed_on_coarse, cancel).Run(work);
    if (drape.status != "ok")
      return {{"failure", "the drape on " + mesh + " is '" + drape.status + "'"}};
    found[name] = DrapeJson(drape);
  }
  return found;
}

BenchReference ReadReference(const json& found, const ReferenceOptions& options,
                             const std::string& where) {
  const JsonInput input(found, where);
  BenchReference reference;
  reference.fine_mesh = ParseMeshSpec(options.fine);
  reference.coarse_mesh = ParseMeshSpec(options.coarse);
  reference.fine = ReadDrape(input.At("fine"), reference.fine_mesh);
  reference.coarse = ReadDrape(input.At("coarse"), reference.coarse_mesh);
  reference.ratio = SizeRatio(reference.fine_mesh, reference.coarse_mesh);
  reference.order = options.order;
  return reference;
}

json RunBenchSetting(BenchWork work, const BenchSetting& setting, const BenchProblem& problem,
                     const BenchReference& reference, const MeasuringOptions& options,
                     const std::atomic<bool>* cancel) {
  const double begin = WallSeconds();
  SettingSolver solver(setting, problem, cancel);
  json result = {{"vertices", solver.mesh().num_vertices()},
                 {"setup_seconds", WallSeconds() - begin}};
  BenchDrape drape;
  const RunTimes times =
      TimeRuns([&] { drape = solver.Run(work); }, options.repeats, options.seconds);
  result["repeats"] = times.wall.size();
  AddTimes(times.wall, setting.batch, "seconds", "seconds_spread", &result);
  AddTimes(times.cpu, setting.batch, "cpu_seconds", "cpu_spread", &result);
  result["status"] = drape.status;
  if (drape.status != "ok") return result;
  if (drape.x.size() == 0) {  // a gradient alone comes back from the steps
    const Eigen::VectorXd gradient = drape.gradient;
    drape = solver.Run(BenchWork::kForward);
    drape.gradient = gradient;
  }
  result.update(MeasureErrors(reference, solver.mesh(), drape, work));
  result["reference_errors"] = MeasureErrors(reference, reference.fine_mesh, reference.fine, work);
  const RestMeasure rest = solver.MeasureRest(drape.x);
  result["force_residual"] = rest.residual;
  result["drift_mm"] = kMillimetres * rest.drift;
  if (!IsOnBranch(reference.fine.outline, drape.outline, options.branch_mm)) {
    result["status"] = "other branch";
  } else if (!rest.IsAtRest()) {
    result["status"] = "not at rest";
  }
  return result;
}

}  // namespace drape
