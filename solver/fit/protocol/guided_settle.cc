// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/guided_settle.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "physics/cloth/state.h"
#include "solver/fit/rollout_residuals.h"

namespace drape {
namespace {

// Shares of the time steps: under the full pull, and while it fades. The rest is free.
constexpr double kPulled = 0.4, kFading = 0.2;
// The furthest that one number pulls [m]: a depth jumps where the cloth leaves a pixel.
constexpr double kFurthest = 0.05;
constexpr int kSweeps = 16;
// Directions that see a vertex are independent above this share of the sum of their weights.
constexpr double kIndependent = 0.05;

// Directions in which a vertex is seen, by their weights, and how far it is off along them.
struct Seen {
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
  Eigen::Vector3d off = Eigen::Vector3d::Zero();

  bool any() const { return !directions.isZero(0.0); }
  void Add(const Eigen::Vector3d& direction, double weight, double distance) {
    directions += weight * direction * direction.transpose();
    off += weight * distance * direction;
  }
  Eigen::Vector3d Displacement() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(directions);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i)
      if (eigen.eigenvalues()[i] > kIndependent * directions.trace()) {
        const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
        sum += axis.dot(off) / eigen.eigenvalues()[i] * axis;
      }
    return sum;
  }
};

// The share of its way that each group of a sight goes, 1 without a loss: of a robust one, numbers
// that are further off than most count less, so that outliers hardly pull.
std::vector<double> ListShares(const Sight& sight, const Eigen::VectorXd& r) {
  const int group = sight.readouts.front()->group();
  std::vector<double> shares(r.size() / group, 1.0);
  if (sight.loss == nullptr) return shares;
  std::vector<double> squares;
  for (Eigen::Index row = 0; row < r.size(); row += group)
    squares.push_back((sight.data.segment(row, group) - r.segment(row, group)).squaredNorm());
  std::vector<double> sorted = squares;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (std::size_t i = 0; i < shares.size(); ++i)
    if (squares[i] > 0.0) shares[i] = *middle / (*middle + squares[i]);
  return shares;
}

// What each vertex has of a sight: all that a number reads go as far, along its gradient by them,
// as brings it to what was measured.
std::vector<Seen> ListSeen(const Sight& sight, const Eigen::VectorXd& x, int num_vertices) {
  std::vector<Seen> seen(num_vertices);
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  const Readout& readout = *sight.readouts.front();
  if (readout.reads_material() || !readout.Read(x, &r, &dr_dx)) return seen;
  const std::vector<double> shares = ListShares(sight, r);
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    std::map<int, Eigen::Vector3d> by_vertex;
    for (ReadoutJacobian::InnerIterator it(dr_dx, k); it; ++it)
      by_vertex.try_emplace(int(it.col() / 3), Eigen::Vector3d::Zero())
          .first->second[it.col() % 3] = it.value();
    double sum = 0.0;
    for (const auto& [vertex, gradient] : by_vertex) sum += gradient.norm();
    if (!(sum > 0.0)) continue;
    const double distance = shares[k / readout.group()] *
                            std::clamp((sight.data[k] - r[k]) / sum, -kFurthest, kFurthest);
    for (const auto& [vertex, gradient] : by_vertex)
      seen[vertex].Add(gradient.stableNormalized(), gradient.norm() / sum, distance);
  }
  return seen;
}

// Makes the columns of vertices that are not known the means of their neighbours: by Gauss and
// Seidel, there and back, so that what is known reaches far in a few sweeps.
void FillBetween(const Mesh& mesh, const std::vector<bool>& is_known, Eigen::Matrix3Xd& columns) {
  std::vector<std::vector<int>> neighbours(is_known.size());
  for (const Face& face : mesh.faces)
    for (int i = 0; i < 3; ++i)
      for (const int k : {1, 2})
        if (!is_known[face.vertex[i]])
          neighbours[face.vertex[i]].push_back(face.vertex[(i + k) % 3]);
  const auto count = static_cast<int>(neighbours.size());
  for (int i = 0; i < kSweeps * count; ++i) {
    const int v = i / count % 2 == 0 ? i % count : count - 1 - i % count;
    if (neighbours[v].empty()) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int other : neighbours[v]) sum += columns.col(other);
    columns.col(v) = sum / double(neighbours[v].size());
  }
}

}  // namespace

Eigen::VectorXd DisplacementTo(const ClothModel& model, const Sight& sight,
                               const Eigen::VectorXd& x) {
  const std::vector<Seen> seen = ListSeen(sight, x, model.mesh.num_vertices());
  std::vector<bool> is_known(seen.size(), false);
  Eigen::Matrix3Xd displacement = Eigen::Matrix3Xd::Zero(3, model.mesh.num_vertices());
  for (std::size_t v = 0; v < seen.size(); ++v) {
    is_known[v] = seen[v].any();
    if (is_known[v]) displacement.col(static_cast<Eigen::Index>(v)) = seen[v].Displacement();
  }
  for (const int held : model.held) is_known[held] = true;
  FillBetween(model.mesh, is_known, displacement);
  return displacement.reshaped();
}

SettledDrape SettleGuided(Backend& backend, const MaterialField& material, const State& start,
                          const Observation& observation, const SettleOptions& options) {
  const std::vector<Sight> sights = MakeSights(*observation.Measured(), backend.model());
  const int pulled = static_cast<int>(kPulled * options.steps.steps);
  const int fading = static_cast<int>(kFading * options.steps.steps);
  RolloutOptions one_step = options.steps;
  one_step.steps = 1;
  State state = start;
  for (int i = 0; i < pulled + fading; ++i) {
    const double share = std::min(1.0, double(pulled + fading - i) / (fading + 1));
    const Eigen::VectorXd x = state.x;
    for (const Sight& sight : sights)
      state.v += options.steps.h * share * (sight.is_contour ? kPullOfContours : kPullOfShapes) *
                 DisplacementTo(backend.model(), sight, x);
    const RolloutInput input{&material, &state};
    RolloutResult step = std::move(backend.Rollouts({&input, 1}, one_step, nullptr).front());
    if (step.status != RolloutStatus::kOk) return {.steps = step.status, .rest = {}};
    state = std::move(step.end);
  }
  SettleOptions free = options;
  free.steps.steps -= pulled + fading;
  state.v.setZero();
  return std::move(Settle(backend, material, {&state, 1}, free).front());
}

}  // namespace drape
