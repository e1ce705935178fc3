// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/experiment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/mesh/mesh.h"

namespace drape {
namespace {

constexpr double kWaves = 5e-3;  // of a random start: root mean square around the hem [m]

}  // namespace

State MakeStart(const Experiment& experiment, const ClothModel& model, int number) {
  const Mesh& mesh = model.mesh;
  Eigen::VectorXd x = mesh.rest_x;
  if (number > 0) {
    const double support = SupportRadius(model.scene).value_or(0.0);
    Mesh centred = mesh;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    if (support == 0.0) {  // waves about the middle of the cloth, wherever it lies
      const Eigen::Map<const Eigen::Matrix3Xd> rest(mesh.rest_x.data(), 3, mesh.num_vertices());
      middle = 0.5 * (rest.rowwise().minCoeff() + rest.rowwise().maxCoeff());
    }
    centred.rest_x -= middle.replicate(mesh.num_vertices(), 1);
    x = ApplyStartShape(centred, support, RandomStartShape(static_cast<uint64_t>(number), kWaves)) +
        middle.replicate(mesh.num_vertices(), 1);
  } else if (experiment.start.size() > 0) {
    x = mesh.num_vertices() == experiment.mesh.num_vertices()
            ? experiment.start
            : ReadPositions(InterpolationWeights(experiment.mesh, mesh.uv, Extrapolation::kLinear),
                            experiment.start);
  }
  return {std::move(x), Eigen::VectorXd::Zero(model.num_dofs())};
}

std::vector<double> ListStarts(const Experiment& experiment) {
  const int count = experiment.random_starts + 1;
  std::vector<double> lifts;
  for (int number = 0; number < count; ++number) lifts.push_back((number + 1.0) / count);
  return lifts;
}

State StartAt(const Experiment& experiment, const ClothModel& model, double lift) {
  if (experiment.start_at)
    return {experiment.start_at(model, lift), Eigen::VectorXd::Zero(model.num_dofs())};
  const long number = std::lround(lift * (experiment.random_starts + 1)) - 1;
  return MakeStart(experiment, model, static_cast<int>(number));
}

std::vector<Sight> MakeSights(const Experiment& experiment, const ClothModel& model) {
  std::vector<Sight> sights;
  for (const Measurement& each : experiment.measurements) {
    int frame = -1;
    if (experiment.motion) {
      const std::vector<int>& frames = experiment.motion->frames;
      frame = static_cast<int>(std::find(frames.begin(), frames.end(), each.step) - frames.begin());
    }
    Sight sight{.readouts = {each.readout(model)},
                .data = each.data,
                .sigma = each.sigma,
                .loss = each.loss,
                .frame = frame,
                .num_telling = each.num_telling,
                .is_contour = each.is_contour};
    if (sight.data.size() == 0) sight.data.setZero(sight.readouts.front()->size());
    if (each.grid_error.size() > 0) sight.data -= each.grid_error;
    if (sight.num_telling == 0) sight.num_telling = sight.readouts.front()->num_independent();
    sights.push_back(std::move(sight));
  }
  return sights;
}

std::optional<Eigen::VectorXd> ReadResiduals(const Sight& sight, const MaterialField& material,
                                             const Eigen::VectorXd& x) {
  Eigen::VectorXd r;
  if (!sight.readouts.front()->ReadCloth(material, x, &r, nullptr, nullptr)) return std::nullopt;
  return ((r - sight.data) / sight.sigma).eval();
}

double WeighByLoss(const Sight& sight, Eigen::Ref<Eigen::VectorXd> residual,
                   Eigen::Ref<Eigen::MatrixXd>* jacobian) {
  if (sight.loss == nullptr) return 0.5 * residual.squaredNorm();
  constexpr double kZero = 1e-8;  // of s: below, ρ/s of each loss is 1, and its rounding is not
  const int group = sight.readouts.front()->group();
  double cost = 0.0;
  for (Eigen::Index row = 0; row < residual.size(); row += group) {
    auto r = residual.segment(row, group);
    const double s = r.squaredNorm();
    double rho[3];
    sight.loss->Evaluate(s, rho);
    cost += 0.5 * rho[0];
    if (s < kZero) continue;
    const double weight = std::sqrt(rho[0] / s);
    if (jacobian != nullptr) {
      auto rows = jacobian->middleRows(row, group);
      const Eigen::RowVectorXd along = r.transpose() * rows;  // ½ ∂s/∂θ
      rows *= weight;
      rows += r * ((rho[1] - rho[0] / s) / (weight * s) * along);
    }
    r *= weight;
  }
  return cost;
}

std::optional<double> Misfit(const Experiment& experiment, const ClothModel& model,
                             const MaterialField& material, const Eigen::VectorXd& x) {
  double cost = 0.0;
  Eigen::Index count = 0;
  for (const Sight& sight : MakeSights(experiment, model)) {
    std::optional<Eigen::VectorXd> residual = ReadResiduals(sight, material, x);
    if (!residual) return std::nullopt;
    cost += WeighByLoss(sight, *residual, nullptr);
    count += sight.num_telling;
  }
  return std::sqrt(2.0 * cost / static_cast<double>(count));
}

int CountIndependent(const Sight& sight) {
  return sight.is_contour ? std::min(kContourNumbers, sight.num_telling) : sight.num_telling;
}

Experiment ForIntervals(Experiment experiment) {
  const double of_mesh = experiment.mesh_factor, of_step = experiment.step_factor;
  for (Measurement& each : experiment.measurements) {
    const double telling = each.num_telling > 0 ? each.num_telling : double(each.data.size());
    each.sigma *= std::sqrt(of_mesh * of_mesh + of_step * of_step - 1.0);
    if (each.is_contour) each.sigma *= std::sqrt(std::max(1.0, telling / kContourNumbers));
  }
  return experiment;
}

double EnlargeSigma(double misfit, int count) {
  const double chance = 1.0 + 2.0 / std::sqrt(2.0 * count);
  return EnlargeByCommon(std::max(0.0, misfit * misfit - chance * chance), count);
}

double EnlargeByCommon(double squares, int count) {
  constexpr double kShared = 12.0;  // numbers that errors in common have: two for each of six folds
  return std::sqrt(1.0 + squares * std::max(1.0, count / kShared));
}

int CountResiduals(const Experiment& experiment, const ClothModel& model) {
  Eigen::Index count = 0;
  for (const Sight& sight : MakeSights(experiment, model)) count += sight.num_telling;
  return static_cast<int>(count);
}

}  // namespace drape
