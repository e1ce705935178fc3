// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/hierarchical_samples.h"

#include <glog/logging.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// The rollouts of at most so many states are joined.
constexpr int kDrawsSideBySide = 128;
constexpr double kLeastStep = 0.125;  // share of the way to a point, in one part

}  // namespace

Eigen::MatrixXd HierarchicalModel::LogEntries(int specimen) const {
  Eigen::MatrixXd by_latent = Eigen::MatrixXd::Zero(kMaterialEntries, num_latents());
  const int n = num_fabric();
  by_latent.leftCols(n) = TyingMatrix(fabric) * LatentRoot().topLeftCorner(n, n);
  if (!has_specimens()) return by_latent;
  const int first = num_fabric() + 2 * specimen;
  by_latent.col(first).head(kStretchEntries).setConstant(specimen_stretch_sigma);
  by_latent.col(first + 1).tail(kBendEntries).setConstant(specimen_bend_sigma);
  return by_latent;
}

Eigen::MatrixXd HierarchicalModel::LatentRoot() const {
  const int n = num_fabric();
  Eigen::MatrixXd root = fabric_sigma * Eigen::MatrixXd::Identity(num_latents(), num_latents());
  if (fabric_root.size() > 0) root.topLeftCorner(n, n) = fabric_root;
  for (int i = n; i < num_latents(); ++i)
    root(i, i) = (i - n) % 2 == 0 ? specimen_stretch_sigma : specimen_bend_sigma;
  return root;
}

std::string HierarchicalModel::NameFor(int latent) const {
  if (latent < num_fabric()) return drape::NameFor(fabric, latent);
  const int k = latent - num_fabric();
  return "specimen " + std::to_string(k / 2 + 1) + (k % 2 == 0 ? " stretch" : " bend");
}

struct HierarchicalSamples::SampleState {
  SampleState(Backend* backend, std::shared_ptr<const MaterialParametrisation> map,
              const SpecimenDrapes& specimen, const OutlineResidualOptions& options)
      : parametrisation(std::move(map)),
        outlines(backend, parametrisation.get(), &specimen.observations, specimen.starts, options) {
  }

  void SetPoint(const Eigen::VectorXd& u) {
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), outlines.num_parameters()) = u;
  }
  // On the backend of a task, which lives for the call only.
  void Run(Backend* backend, const Eigen::VectorXd& u, bool with_jacobians, double least_step) {
    outlines.Rebind(backend);
    if (!outlines.has_accepted() && !with_jacobians) {
      SetPoint(u);
      outlines.PrepareForEvaluation(false, true);
      valid = outlines.all_valid();
      point = u;
      return;
    }
    // Derivatives are computed at the end of the way, not on it.
    if (outlines.has_accepted() && (point.size() == 0 || u != point)) {
      if (trial_start) outlines.Restore(*std::exchange(trial_start, std::nullopt));
      valid = FollowTo(u, least_step);
    }
    point = u;
    if (!with_jacobians || (outlines.has_accepted() && !valid)) return;
    trial_start.reset();
    SetPoint(u);
    outlines.PrepareForEvaluation(true, true);
    valid = outlines.all_valid();
  }
  // Moves straight from the last point with valid drapes, in parts if they are lost at once. Until
  // derivatives are computed at its end, the way belongs to a trial: the next trial starts where it
  // started.
  bool FollowTo(const Eigen::VectorXd& u, double least_step) {
    const Eigen::VectorXd from = outlines.accepted().theta;
    for (double done = 0.0, step = 1.0; step >= least_step;) {
      SetPoint(done + step < 1.0 ? (from + (done + step) * (u - from)).eval() : u);
      outlines.PrepareForEvaluation(false, true);
      if (!outlines.all_valid()) {
        step /= 2;
        continue;
      }
      done += step;
      if (done >= 1.0) return true;
      if (!trial_start) trial_start = outlines.accepted();
      outlines.PrepareForEvaluation(true, true);
      if (!outlines.all_valid()) return false;
    }
    return false;
  }
  // As found, shape [num_residuals()], and if not null the derivatives, row-major.
  void CopyTo(double* residual, double* jacobian) const {
    for (int i = 0; i < outlines.num_observations(); ++i, residual += outlines.num_angles()) {
      CHECK(outlines.Residuals(i, residual));
      if (jacobian == nullptr) continue;
      outlines.CopyJacobian(i, 0, outlines.num_parameters(), jacobian);
      jacobian += std::ptrdiff_t{outlines.num_angles()} * outlines.num_parameters();
    }
  }
  // Extrapolates by the Jacobian at the last point with valid drapes.
  Eigen::VectorXd ExtrapolatedResidual() const {
    return outlines.accepted().residual +
           outlines.accepted().jacobian * (point - outlines.accepted().theta);
  }
  int num_residuals() const { return outlines.num_observations() * outlines.num_angles(); }

  std::shared_ptr<const MaterialParametrisation> parametrisation;
  OutlineResiduals outlines;
  Eigen::VectorXd point;  // of the last Run
  bool valid = false;     // there
  // Where the way to it began, if it is only a trial that was followed in parts.
  std::optional<OutlineResiduals::Point> trial_start;
};

HierarchicalSamples::HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                                         const std::vector<SpecimenDrapes>& specimens,
                                         const OutlineResidualOptions& options, int draws,
                                         LostBranchPolicy policy)
    : backend_(backend),
      num_latents_(hierarchy.num_latents()),
      num_draws_(draws),
      specimens_(hierarchy.specimens),
      policy_(policy) {
  CHECK_EQ(specimens.size(), static_cast<std::size_t>(specimens_));
  for (int p = 0; p < specimens_; ++p)
    prototypes_.push_back(std::make_unique<SampleState>(
        backend, std::make_shared<TableParametrisation>(hierarchy.base, hierarchy.LogEntries(p)),
        specimens[p], options));
  for (int s = 0; s < draws; ++s)
    for (const auto& prototype : prototypes_)
      states_.push_back(std::make_unique<SampleState>(*prototype));
}

std::unique_ptr<HierarchicalSamples> HierarchicalSamples::Elementwise(
    Backend* backend, const MaterialField& base, const ElementScales& scales,
    const std::vector<SpecimenDrapes>& specimens, const OutlineResidualOptions& options, int draws,
    uint64_t seed, LostBranchPolicy policy) {
  CHECK(!specimens.empty());
  std::unique_ptr<HierarchicalSamples> all(new HierarchicalSamples());
  const Mesh& mesh = backend->model().mesh;
  all->backend_ = backend;
  all->num_latents_ = 2 * kMaterialEntries;
  all->num_draws_ = draws;
  all->specimens_ = static_cast<int>(specimens.size());
  all->element_ratio_ = scales.element_sigma / scales.mean_sigma;
  all->policy_ = policy;
  for (int i = 0; i < draws * all->specimens_; ++i) {
    const int sample = i / all->specimens_, specimen = i % all->specimens_;
    std::vector<FieldTerm> terms = CommonTerms(mesh, scales.mean_sigma);
    for (FieldTerm& term :
         NoiseTerms(mesh, scales.mean_sigma, SeedOfStream(seed, specimen) + sample))
      terms.push_back(std::move(term));
    all->states_.push_back(std::make_unique<SampleState>(
        backend,
        std::make_shared<FieldParametrisation>(base, mesh.num_faces(), mesh.num_hinges(),
                                               std::move(terms)),
        specimens[specimen], options));
  }
  return all;
}

HierarchicalSamples::~HierarchicalSamples() = default;

int HierarchicalSamples::num_residuals() const {
  int sum = 0;
  for (int p = 0; p < specimens_; ++p) sum += state(0, p).num_residuals();
  return sum;
}

double HierarchicalSamples::least_step() const {
  return policy_ == LostBranchPolicy::kRejectAtOnce ? 1.0 : kLeastStep;
}

void HierarchicalSamples::Prepare(const Eigen::MatrixXd& points, bool with_jacobians) {
  CHECK_EQ(points.rows(), num_latents_);
  CHECK_EQ(points.cols(), num_draws_);
  Eigen::MatrixXd scaled = points;
  if (is_elementwise()) scaled.bottomRows(kMaterialEntries) *= element_ratio_;
  RunBatched(*backend_, static_cast<int>(states_.size()), kDrawsSideBySide,
             [&](BatchingBackend& task) {
               states_[task.index()]->Run(&task, scaled.col(task.index() / specimens_),
                                          with_jacobians, least_step());
             });
}

bool HierarchicalSamples::Residuals(int draw, Eigen::VectorXd* residual,
                                    RowMatrix* jacobian) const {
  residual->resize(num_residuals());
  if (jacobian != nullptr) jacobian->resize(num_residuals(), num_latents_);
  int row = 0;
  for (int p = 0; p < specimens_; ++p) {
    const SampleState& each = state(draw, p);
    const int rows = each.num_residuals();
    if (each.valid) {
      each.CopyTo(residual->data() + row,
                  jacobian == nullptr ? nullptr : jacobian->row(row).data());
    } else if (policy_ == LostBranchPolicy::kExtrapolate && each.outlines.has_accepted()) {
      residual->segment(row, rows) = each.ExtrapolatedResidual();
      if (jacobian != nullptr) jacobian->middleRows(row, rows) = each.outlines.accepted().jacobian;
    } else {
      return false;
    }
    row += rows;
  }
  if (is_elementwise() && jacobian != nullptr)
    jacobian->rightCols(kMaterialEntries) *= element_ratio_;
  return true;
}

int HierarchicalSamples::num_extrapolated() const {
  int sum = 0;
  for (int s = 0; s < num_draws_; ++s) {
    int lost = 0;
    for (int p = 0; p < specimens_; ++p) lost += state(s, p).valid ? 0 : 1;
    sum += is_elementwise() ? lost : std::min(lost, 1);
  }
  return sum;
}

bool HierarchicalSamples::StartAt(const Eigen::VectorXd& u) {
  // The drapes of elementwise samples differ from the start by their noise.
  if (is_elementwise()) {
    Prepare(u.replicate(1, num_draws_), true);
    return std::all_of(states_.begin(), states_.end(),
                       [](const auto& each) { return each->outlines.has_accepted(); });
  }
  RunBatched(*backend_, specimens_, kDrawsSideBySide, [&](BatchingBackend& task) {
    prototypes_[task.index()]->Run(&task, u, true, least_step());
  });
  for (std::size_t i = 0; i < states_.size(); ++i)
    states_[i] = std::make_unique<SampleState>(*prototypes_[i % specimens_]);
  return std::all_of(prototypes_.begin(), prototypes_.end(),
                     [](const auto& each) { return each->outlines.has_accepted(); });
}

std::unique_ptr<HierarchicalSamples> HierarchicalSamples::WithSamples(
    int draws, LostBranchPolicy policy) const {
  CHECK(!prototypes_.empty()) << "samples of the hierarchy";
  std::unique_ptr<HierarchicalSamples> other(new HierarchicalSamples());
  other->backend_ = backend_;
  other->num_latents_ = num_latents_;
  other->num_draws_ = draws;
  other->policy_ = policy;
  other->specimens_ = specimens_;
  for (const auto& prototype : prototypes_)
    other->prototypes_.push_back(std::make_unique<SampleState>(*prototype));
  for (int i = 0; i < draws * specimens_; ++i)
    other->states_.push_back(std::make_unique<SampleState>(*prototypes_[i % specimens_]));
  return other;
}

std::vector<Eigen::VectorXd> HierarchicalSamples::Shapes(int draw) const {
  std::vector<Eigen::VectorXd> shapes;
  for (int p = 0; p < specimens_; ++p) {
    const OutlineResiduals& outlines = state(draw, p).outlines;
    for (int i = 0; i < outlines.num_observations(); ++i) shapes.push_back(outlines.shape(i));
  }
  return shapes;
}

RolloutCounts HierarchicalSamples::counts() const {
  RolloutCounts sum;
  for (const auto& each : states_) sum += each->outlines.counts();
  for (const auto& each : prototypes_) sum += each->outlines.counts();
  return sum;
}

}  // namespace drape
