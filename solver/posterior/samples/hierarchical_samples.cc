// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/samples/hierarchical_samples.h"

#include <glog/logging.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "solver/fit/parameters/field_parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// Rollouts of so many cells are joined at most.
constexpr int kSideBySide = 128;
constexpr double kLeastStep = 0.125;  // share of the way to a point, in one part

}  // namespace

Eigen::MatrixXd HierarchicalModel::LogEntries(int specimen) const {
  Eigen::MatrixXd by_latent = Eigen::MatrixXd::Zero(kMaterialEntries, num_latents());
  by_latent.leftCols(num_fabric()) = fabric_sigma * TyingMatrix(fabric);
  if (!has_specimens()) return by_latent;
  const int first = num_fabric() + 2 * specimen;
  by_latent.col(first).head(kStretchEntries).setConstant(specimen_stretch_sigma);
  by_latent.col(first + 1).tail(kBendEntries).setConstant(specimen_bend_sigma);
  return by_latent;
}

std::string HierarchicalModel::NameFor(int latent) const {
  if (latent < num_fabric()) return drape::NameFor(fabric, latent);
  const int k = latent - num_fabric();
  return "specimen " + std::to_string(k / 2 + 1) + (k % 2 == 0 ? " stretch" : " bend");
}

struct HierarchicalSamples::SampleState {
  SampleState(Backend* backend, std::shared_ptr<const MaterialParametrisation> map,
              std::vector<Observation> starts, const OutlineResidualOptions& options)
      : parametrisation(std::move(map)),
        targets(std::move(starts)),
        batch(backend, parametrisation.get(), &targets, options) {}
  SampleState(const SampleState& other)
      : parametrisation(other.parametrisation),
        targets(other.targets),
        batch(other.batch),
        point(other.point),
        stands(other.stands),
        home(other.home) {}

  void SetPoint(const Eigen::VectorXd& u) {
    Eigen::Map<Eigen::VectorXd>(batch.theta(), batch.num_parameters()) = u;
  }
  // On the backend of a task, which lives for the call only.
  void Run(Backend* backend, const Eigen::VectorXd& u, bool with_jacobians, double least_step) {
    batch.Move(backend, &targets);
    if (!batch.has_accepted() && !with_jacobians) {
      SetPoint(u);
      batch.PrepareForEvaluation(false, true);
      stands = batch.all_valid();
      point = u;
      return;
    }
    // Derivatives are taken where a drape has been followed to, not on the way there.
    if (batch.has_accepted() && (point.size() == 0 || u != point)) {
      if (home) batch.Restore(*std::exchange(home, std::nullopt));
      stands = FollowTo(u, least_step);
    }
    point = u;
    if (!with_jacobians || (batch.has_accepted() && !stands)) return;
    home.reset();
    SetPoint(u);
    batch.PrepareForEvaluation(true, true);
    stands = batch.all_valid();
  }
  // Straight from the last point where the drapes stood, in parts where they are lost at once.
  // Until derivatives are asked for at its end, the way is a trial's: the next one starts where it
  // did.
  bool FollowTo(const Eigen::VectorXd& u, double least_step) {
    const Eigen::VectorXd from = batch.accepted().theta;
    for (double done = 0.0, step = 1.0; step >= least_step;) {
      SetPoint(done + step < 1.0 ? (from + (done + step) * (u - from)).eval() : u);
      batch.PrepareForEvaluation(false, true);
      if (!batch.all_valid()) {
        step /= 2;
        continue;
      }
      done += step;
      if (done >= 1.0) return true;
      if (!home) home = batch.accepted();
      batch.PrepareForEvaluation(true, true);
      if (!batch.all_valid()) return false;
    }
    return false;
  }
  // As found, shape [num_residuals()], and if not null the derivatives, row-major.
  void CopyTo(double* residual, double* jacobian) const {
    for (int i = 0; i < batch.num_targets(); ++i, residual += batch.num_angles()) {
      CHECK(batch.Copy(i, residual));
      if (jacobian == nullptr) continue;
      batch.CopyJacobian(i, 0, batch.num_parameters(), jacobian);
      jacobian += std::ptrdiff_t{batch.num_angles()} * batch.num_parameters();
    }
  }
  // By the tangent at the last point where the drapes stood.
  Eigen::VectorXd ResidualBeyond() const {
    return batch.accepted().residual + batch.accepted().jacobian * (point - batch.accepted().theta);
  }
  int num_residuals() const { return batch.num_targets() * batch.num_angles(); }

  std::shared_ptr<const MaterialParametrisation> parametrisation;
  std::vector<Observation> targets;
  OutlineResiduals batch;
  Eigen::VectorXd point;  // of the last Run
  bool stands = false;    // there
  // Where the way to it began, if it is only a trial that was followed in parts.
  std::optional<OutlineResiduals::Point> home;
};

HierarchicalSamples::HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                                         const std::vector<std::vector<Observation>>& targets,
                                         const OutlineResidualOptions& options, int draws,
                                         LostBranchPolicy beyond)
    : backend_(backend),
      num_latents_(hierarchy.num_latents()),
      num_draws_(draws),
      specimens_(hierarchy.specimens),
      beyond_(beyond) {
  CHECK_EQ(targets.size(), static_cast<std::size_t>(specimens_));
  for (int p = 0; p < specimens_; ++p)
    prototypes_.push_back(std::make_unique<SampleState>(
        backend, std::make_shared<TableParametrisation>(hierarchy.base, hierarchy.LogEntries(p)),
        targets[p], options));
  for (int s = 0; s < draws; ++s)
    for (const auto& prototype : prototypes_)
      cells_.push_back(std::make_unique<SampleState>(*prototype));
}

std::unique_ptr<HierarchicalSamples> HierarchicalSamples::Elementwise(
    Backend* backend, const MaterialField& base, double sigma,
    const std::vector<Observation>& targets, const OutlineResidualOptions& options, int draws,
    uint64_t seed, LostBranchPolicy beyond) {
  std::unique_ptr<HierarchicalSamples> all(new HierarchicalSamples());
  const Mesh& mesh = backend->model().mesh;
  all->backend_ = backend;
  all->num_latents_ = 2 * kMaterialEntries;
  all->num_draws_ = draws;
  all->beyond_ = beyond;
  for (int s = 0; s < draws; ++s) {
    std::vector<FieldTerm> terms = CommonTerms(mesh, sigma);
    for (FieldTerm& term : NoiseTerms(mesh, sigma, seed + s)) terms.push_back(std::move(term));
    all->cells_.push_back(std::make_unique<SampleState>(
        backend,
        std::make_shared<FieldParametrisation>(base, mesh.num_faces(), mesh.num_hinges(),
                                               std::move(terms)),
        targets, options));
  }
  return all;
}

HierarchicalSamples::~HierarchicalSamples() = default;

int HierarchicalSamples::num_residuals() const {
  int sum = 0;
  for (int p = 0; p < specimens_; ++p) sum += cell(0, p).num_residuals();
  return sum;
}

double HierarchicalSamples::least_step() const {
  return beyond_ == LostBranchPolicy::kRefuseAtOnce ? 1.0 : kLeastStep;
}

void HierarchicalSamples::Prepare(const Eigen::MatrixXd& points, bool with_jacobians) {
  CHECK_EQ(points.rows(), num_latents_);
  CHECK_EQ(points.cols(), num_draws_);
  RunBatched(*backend_, static_cast<int>(cells_.size()), kSideBySide, [&](BatchingBackend& task) {
    cells_[task.index()]->Run(&task, points.col(task.index() / specimens_), with_jacobians,
                              least_step());
  });
}

bool HierarchicalSamples::Copy(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const {
  residual->resize(num_residuals());
  if (jacobian != nullptr) jacobian->resize(num_residuals(), num_latents_);
  int row = 0;
  for (int p = 0; p < specimens_; ++p) {
    const SampleState& each = cell(draw, p);
    const int rows = each.num_residuals();
    if (each.stands) {
      each.CopyTo(residual->data() + row,
                  jacobian == nullptr ? nullptr : jacobian->row(row).data());
    } else if (beyond_ == LostBranchPolicy::kTangent && each.batch.has_accepted()) {
      residual->segment(row, rows) = each.ResidualBeyond();
      if (jacobian != nullptr) jacobian->middleRows(row, rows) = each.batch.accepted().jacobian;
    } else {
      return false;
    }
    row += rows;
  }
  return true;
}

int HierarchicalSamples::num_extrapolated() const {
  int sum = 0;
  for (int s = 0; s < num_draws_; ++s) {
    bool stands = true;
    for (int p = 0; p < specimens_; ++p) stands &= cell(s, p).stands;
    sum += stands ? 0 : 1;
  }
  return sum;
}

bool HierarchicalSamples::StartAt(const Eigen::VectorXd& u) {
  // Noise of their own makes the drapes of elementwise draws differ from the start.
  if (prototypes_.empty()) {
    Prepare(u.replicate(1, num_draws_), true);
    return std::all_of(cells_.begin(), cells_.end(),
                       [](const auto& each) { return each->batch.has_accepted(); });
  }
  RunBatched(*backend_, specimens_, kSideBySide, [&](BatchingBackend& task) {
    prototypes_[task.index()]->Run(&task, u, true, least_step());
  });
  for (std::size_t i = 0; i < cells_.size(); ++i)
    cells_[i] = std::make_unique<SampleState>(*prototypes_[i % specimens_]);
  return std::all_of(prototypes_.begin(), prototypes_.end(),
                     [](const auto& each) { return each->batch.has_accepted(); });
}

std::unique_ptr<HierarchicalSamples> HierarchicalSamples::WithSamples(
    int draws, LostBranchPolicy beyond) const {
  CHECK(!prototypes_.empty()) << "draws of the hierarchy";
  std::unique_ptr<HierarchicalSamples> other(new HierarchicalSamples());
  other->backend_ = backend_;
  other->num_latents_ = num_latents_;
  other->num_draws_ = draws;
  other->beyond_ = beyond;
  other->specimens_ = specimens_;
  for (const auto& prototype : prototypes_)
    other->prototypes_.push_back(std::make_unique<SampleState>(*prototype));
  for (int i = 0; i < draws * specimens_; ++i)
    other->cells_.push_back(std::make_unique<SampleState>(*prototypes_[i % specimens_]));
  return other;
}

std::vector<Eigen::VectorXd> HierarchicalSamples::Shapes(int draw) const {
  std::vector<Eigen::VectorXd> shapes;
  for (int p = 0; p < specimens_; ++p) {
    const OutlineResiduals& batch = cell(draw, p).batch;
    for (int i = 0; i < batch.num_targets(); ++i) shapes.push_back(batch.shape(i));
  }
  return shapes;
}

RolloutCounts HierarchicalSamples::counts() const {
  RolloutCounts sum;
  for (const auto& each : cells_) sum += each->batch.counts();
  for (const auto& each : prototypes_) sum += each->batch.counts();
  return sum;
}

}  // namespace drape
