// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/variational_fit.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// The numbers that Ceres changes: mean [P] and, unless only a mode is wanted, ln L_ii [P] and L_ij
// of the leading triangle by rows.
class Layout {
 public:
  Layout(int latents, const VariationalOptions& options)
      : latents_(latents),
        rank_(options.kind == SampleKind::kShared ? std::min(options.rank, latents) : 0),
        only_mean_(options.kind == SampleKind::kMode) {
    CHECK_GE(options.rank, 0);
  }
  int size() const { return only_mean_ ? latents_ : 2 * latents_ + rank_ * (rank_ - 1) / 2; }
  int latents() const { return latents_; }

  Eigen::VectorXd Pack(const GaussianPosterior& q) const {
    Eigen::VectorXd numbers(size());
    numbers.head(latents_) = q.mean;
    if (only_mean_) return numbers;
    numbers.segment(latents_, latents_) = q.factor.diagonal().array().log();
    ForEachBelow([&](int index, int i, int j) { numbers[index] = q.factor(i, j); });
    return numbers;
  }
  void Unpack(const double* numbers, GaussianPosterior* q) const {
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    q->mean = Vector(numbers, latents_);
    if (only_mean_) return;
    q->factor = Vector(numbers + latents_, latents_).array().exp().matrix().asDiagonal();
    ForEachBelow([&](int index, int i, int j) { q->factor(i, j) = numbers[index]; });
  }
  // visit(index, i, j) for each L_ij below the diagonal.
  template <class Visit>
  void ForEachBelow(const Visit& visit) const {
    int index = 2 * latents_;
    for (int i = 1; i < rank_; ++i)
      for (int j = 0; j < i; ++j) visit(index++, i, j);
  }

 private:
  int latents_, rank_;
  bool only_mean_;
};

// What all cost functions of one fit share, evaluated before Ceres calls them.
class Evaluation final : public ceres::EvaluationCallback {
 public:
  Evaluation(SampledResiduals& residuals, const GaussianPosterior& start,
             const VariationalOptions& options)
      : residuals_(residuals),
        layout_(start.size(), options),
        kind_(options.kind),
        posterior_(start),
        standard_(kind_ == SampleKind::kShared
                      ? BalancedSamples(start.size(), residuals.num_draws(), options.seed)
                      : Eigen::MatrixXd()),
        numbers_(layout_.Pack(start)) {}

  double* numbers() { return numbers_.data(); }
  const Layout& layout() const { return layout_; }
  const GaussianPosterior& posterior() const { return posterior_; }
  int num_draws() const { return residuals_.num_draws(); }
  // The rows of a draw, as Ceres sees them.
  int num_residuals() const {
    return std::min(residuals_.num_residuals(), residuals_.num_latents() + 1);
  }

  void PrepareForEvaluation(bool with_jacobians, bool) override {
    layout_.Unpack(numbers_.data(), &posterior_);
    if (with_jacobians && kind_ == SampleKind::kMode)
      information_ = Eigen::MatrixXd::Identity(posterior_.size(), posterior_.size());
    residuals_.Prepare(Points(), with_jacobians);
  }

  // r(u_s)/√S and its derivatives by the numbers, shape [num_residuals(), size()]. Of more
  // residuals than latent numbers it is [r, ∂r/∂u] = Q·U as U has it: their square, gradient and
  // JᵀJ.
  bool Copy(int draw, double* residual, double* jacobian) {
    const double weight = 1 / std::sqrt(double(num_draws()));
    Eigen::VectorXd r;
    RowMatrix by_latent;
    if (!residuals_.Residuals(draw, &r, jacobian == nullptr ? nullptr : &by_latent)) return false;
    Eigen::Map<Eigen::VectorXd> seen(residual, num_residuals());
    if (jacobian == nullptr) {
      if (r.size() == seen.size())
        seen = weight * r;
      else
        seen = weight * r.norm() * Eigen::VectorXd::Unit(seen.size(), 0);
      return true;
    }
    if (kind_ == SampleKind::kMode)
      information_ += weight * weight * by_latent.transpose() * by_latent;
    if (r.size() > seen.size()) Compress(r, by_latent);
    seen = weight * r;
    Chain(draw, weight * by_latent,
          Eigen::Map<RowMatrix>(jacobian, num_residuals(), layout_.size()));
    return true;
  }

  // Inverse of JᵀJ, with the prior's part of J, at the last point whose derivatives were computed:
  // after a solution this is it, since Ceres differentiates there alone. Not by ceres::Covariance:
  // it evaluates once more and ignores a failure of that (2.1), and of its algorithms DENSE_SVD
  // crashes or is wrong where many singular values are equal, as they are where the prior
  // dominates.
  Eigen::MatrixXd LaplaceCovariance() const {
    return information_.llt().solve(
        Eigen::MatrixXd::Identity(information_.rows(), information_.cols()));
  }

 private:
  Eigen::MatrixXd Points() const {
    if (kind_ == SampleKind::kShared) return posterior_.Draws(standard_);
    if (kind_ == SampleKind::kMode) return posterior_.mean.replicate(1, num_draws());
    Eigen::VectorXd point(2 * posterior_.size());
    point << posterior_.mean, posterior_.factor.diagonal();
    return point.replicate(1, num_draws());
  }

  static void Compress(Eigen::VectorXd& r, RowMatrix& by_latent) {
    const Eigen::Index latents = by_latent.cols();
    Eigen::MatrixXd both(r.size(), latents + 1);
    both << by_latent, r;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(both);
    const Eigen::MatrixXd upper = qr.matrixQR().topRows(latents + 1).triangularView<Eigen::Upper>();
    by_latent = upper.leftCols(latents);
    r = upper.col(latents);
  }

  void Chain(int draw, const RowMatrix& by_latent, Eigen::Map<RowMatrix> by_number) const {
    const int n = layout_.latents();
    const auto diagonal = posterior_.factor.diagonal();
    by_number.leftCols(n) = by_latent.leftCols(n);
    if (kind_ == SampleKind::kMode) return;
    if (kind_ == SampleKind::kElementwise) {
      by_number.middleCols(n, n) = by_latent.rightCols(n) * diagonal.asDiagonal();
      return;
    }
    const auto noise = standard_.col(draw);
    const RowMatrix turned = by_latent * posterior_.rotation;
    by_number.middleCols(n, n) = turned * diagonal.cwiseProduct(noise).asDiagonal();
    layout_.ForEachBelow(
        [&](int index, int i, int j) { by_number.col(index) = turned.col(i) * noise[j]; });
  }

  SampledResiduals& residuals_;
  Layout layout_;
  SampleKind kind_;
  GaussianPosterior posterior_;
  Eigen::MatrixXd standard_;
  Eigen::VectorXd numbers_;
  Eigen::MatrixXd information_;  // of the mode
};

class DrawCost final : public ceres::CostFunction {
 public:
  DrawCost(Evaluation* evaluation, int draw) : evaluation_(evaluation), draw_(draw) {
    set_num_residuals(evaluation->num_residuals());
    mutable_parameter_block_sizes()->push_back(evaluation->layout().size());
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    return evaluation_->Copy(draw_, residuals, jacobians == nullptr ? nullptr : jacobians[0]);
  }

 private:
  Evaluation* evaluation_;
  int draw_;
};

// KL(q ‖ prior) as squares: one residual for each number.
class DivergenceCost final : public ceres::CostFunction {
 public:
  explicit DivergenceCost(const Layout& layout) : latents_(layout.latents()) {
    set_num_residuals(layout.size());
    mutable_parameter_block_sizes()->push_back(layout.size());
  }
  bool Evaluate(double const* const* numbers, double* residuals,
                double** jacobians) const override {
    const int size = num_residuals();
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    if (with_jacobian) std::fill_n(jacobians[0], std::size_t{1} * size * size, 0.0);
    for (int i = 0; i < size; ++i) {
      double slope = 1.0;
      const bool is_deviation = i >= latents_ && i < 2 * latents_;
      residuals[i] = is_deviation ? SignedRoot(numbers[0][i], &slope) : numbers[0][i];
      if (with_jacobian) jacobians[0][std::size_t{1} * i * size + i] = slope;
    }
    return true;
  }

 private:
  int latents_;
};

// The rollouts of at most so many states are joined.
constexpr int kDrawsSideBySide = 128;
constexpr double kLeastStep = 0.125;  // share of the way to a point, in one part

}  // namespace

Eigen::MatrixXd GaussianPosterior::Draws(const Eigen::MatrixXd& standard) const {
  return (rotation * (factor * standard)).colwise() + mean;
}

Eigen::MatrixXd GaussianPosterior::Covariance() const {
  const Eigen::MatrixXd root = rotation * factor;
  return root * root.transpose();
}

double GaussianPosterior::DivergenceFromPrior() const {
  return 0.5 * (mean.squaredNorm() + factor.squaredNorm() - size()) -
         factor.diagonal().array().log().sum();
}

GaussianPosterior FromCovariance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  CHECK_EQ(covariance.rows(), mean.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return {mean, axes.eigenvectors(), axes.eigenvalues().cwiseSqrt().asDiagonal()};
}

Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd IndependentSamples(int size, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd draws(size, count);
  for (double& value : draws.reshaped()) value = SampleNormal(random);
  return draws;
}

Eigen::MatrixXd BalancedSamples(int size, int count, uint64_t seed) {
  CHECK(count >= 2 && count % 2 == 0) << count;
  const int half = count / 2, exact = std::min(size, half);
  Eigen::MatrixXd draws = IndependentSamples(size, half, seed);
  auto leading = draws.topRows(exact);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> moments(leading * leading.transpose() /
                                                               half);
  leading = (moments.operatorInverseSqrt() * leading).eval();
  Eigen::MatrixXd pairs(size, count);
  pairs << draws, -draws;
  return pairs;
}

double SignedRoot(double log_deviation, double* derivative) {
  const double rho = log_deviation;
  const double square = std::expm1(2 * rho) - 2 * rho;
  // Near 0 the difference cancels: √2·ρ·(1 + ρ/3 + ρ²/9 + …).
  constexpr double kSmall = 1e-4;
  if (std::abs(rho) < kSmall) {
    if (derivative != nullptr) *derivative = std::sqrt(2.0) * (1 + rho * (2.0 / 3 + rho / 3));
    return std::sqrt(2.0) * rho * (1 + rho * (1.0 / 3 + rho / 9));
  }
  const double root = std::copysign(std::sqrt(square), rho);
  if (derivative != nullptr) *derivative = std::expm1(2 * rho) / root;
  return root;
}

VariationalFit FitPosterior(SampledResiduals& residuals, const GaussianPosterior& start,
                            const VariationalOptions& options) {
  Evaluation evaluation(residuals, start, options);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluation;
  ceres::Problem problem(problem_options);
  for (int s = 0; s < evaluation.num_draws(); ++s)
    problem.AddResidualBlock(new DrawCost(&evaluation, s), nullptr, evaluation.numbers());
  problem.AddResidualBlock(new DivergenceCost(evaluation.layout()), nullptr, evaluation.numbers());
  const TrustRegionRun run = RunTrustRegion(problem, options.trust_region);
  VariationalFit fit;
  fit.termination = run.termination;
  fit.gaussian = start;
  if (options.kind == SampleKind::kMode && run.termination != FitTermination::kFailed)
    fit.gaussian = FromCovariance(start.mean, evaluation.LaplaceCovariance());
  evaluation.layout().Unpack(evaluation.numbers(), &fit.gaussian);
  fit.initial_cost = run.initial_cost;
  fit.cost = run.final_cost;
  fit.divergence = fit.gaussian.DivergenceFromPrior();
  if (!run.iterations.empty()) fit.iterations = run.iterations.back().iteration;
  fit.seconds = run.seconds;
  return fit;
}

Eigen::MatrixXd HierarchicalModel::LogEntries(int specimen) const {
  Eigen::MatrixXd by_latent = Eigen::MatrixXd::Zero(kMaterialEntries, num_latents());
  const int n = num_fabric();
  by_latent.leftCols(n) = TyingMatrix(fabric) * LatentRoot().topLeftCorner(n, n);
  if (!has_specimens() || specimen == kFabric) return by_latent;
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
  SampleState(std::shared_ptr<const MaterialParametrisation> map, std::vector<RolloutBlock> blocks,
              const ResidualOptions& options)
      : parametrisation(std::move(map)),
        outlines(parametrisation.get(), std::move(blocks), options) {}
  // One that another thread can run.
  static std::unique_ptr<SampleState> Copy(const SampleState& other) {
    auto copy = std::make_unique<SampleState>(other);
    copy->outlines.RenewOwnBackends();
    return copy;
  }

  void SetPoint(const Eigen::VectorXd& u) {
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), outlines.num_parameters()) = u;
  }
  // Runs on the backend of a task, which lives for the call only.
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
  // As found and scaled by the losses, shape [num_residuals()], and if not null the derivatives,
  // row-major.
  void CopyTo(double* residual, double* jacobian) const {
    for (int i = 0; i < outlines.num_blocks(); ++i) {
      CHECK(outlines.valid(i));
      const Eigen::Index rows = outlines.residual(i).size(), columns = outlines.num_parameters();
      Eigen::Map<Eigen::VectorXd> own(residual, rows);
      own = outlines.residual(i);
      residual += rows;
      if (jacobian == nullptr) {
        outlines.Weigh(i, own, nullptr);
        continue;
      }
      Eigen::MatrixXd derivatives = outlines.jacobian(i);
      Eigen::Ref<Eigen::MatrixXd> scaled = derivatives;
      outlines.Weigh(i, own, &scaled);
      Eigen::Map<RowMatrix>(jacobian, rows, columns) = derivatives;
      jacobian += rows * columns;
    }
  }
  // Extrapolates by the Jacobian at the last point with valid drapes.
  Eigen::VectorXd ExtrapolatedResidual() const {
    return outlines.accepted().residual +
           outlines.accepted().jacobian * (point - outlines.accepted().theta);
  }
  int num_residuals() const { return outlines.num_residuals(); }

  std::shared_ptr<const MaterialParametrisation> parametrisation;
  RolloutResiduals outlines;
  Eigen::VectorXd point;  // of the last Run
  bool valid = false;     // there
  // Where the way to it began, if it is only a trial that was followed in parts.
  std::optional<RolloutResiduals::Point> trial_start;
};

HierarchicalSamples::HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                                         const std::vector<SpecimenDrapes>& specimens,
                                         const ResidualOptions& options, int draws,
                                         LostBranchPolicy policy,
                                         std::vector<RolloutBlock> of_fabric)
    : backend_(backend),
      num_latents_(hierarchy.num_latents()),
      num_draws_(draws),
      specimens_(hierarchy.specimens),
      policy_(policy) {
  CHECK_EQ(specimens.size(), static_cast<std::size_t>(specimens_));
  const auto add = [&](int specimen, std::vector<RolloutBlock> blocks) {
    prototypes_.push_back(std::make_unique<SampleState>(
        std::make_shared<TableParametrisation>(hierarchy.base, hierarchy.LogEntries(specimen)),
        std::move(blocks), options));
  };
  for (int p = 0; p < specimens_; ++p)
    add(p, MakeBlocks(backend, specimens[p].observations, specimens[p].starts, options));
  if (!of_fabric.empty()) add(HierarchicalModel::kFabric, std::move(of_fabric));
  parts_ = static_cast<int>(prototypes_.size());
  for (int s = 0; s < draws; ++s)
    for (const auto& prototype : prototypes_) states_.push_back(SampleState::Copy(*prototype));
}

std::unique_ptr<HierarchicalSamples> HierarchicalSamples::Elementwise(
    Backend* backend, const MaterialField& base, const ElementScales& scales,
    const std::vector<SpecimenDrapes>& specimens, const ResidualOptions& options, int draws,
    uint64_t seed, LostBranchPolicy policy) {
  CHECK(!specimens.empty());
  std::unique_ptr<HierarchicalSamples> all(new HierarchicalSamples());
  const Mesh& mesh = backend->model().mesh;
  all->backend_ = backend;
  all->num_latents_ = 2 * kMaterialEntries;
  all->num_draws_ = draws;
  all->specimens_ = all->parts_ = static_cast<int>(specimens.size());
  all->element_ratio_ = scales.element_sigma / scales.mean_sigma;
  all->policy_ = policy;
  for (int i = 0; i < draws * all->specimens_; ++i) {
    const int sample = i / all->specimens_, specimen = i % all->specimens_;
    all->states_.push_back(std::make_unique<SampleState>(
        std::make_shared<FieldParametrisation>(
            base, mesh.num_faces(), mesh.num_hinges(),
            NoiseTerms(mesh, scales.mean_sigma, SeedOfStream(seed, specimen) + sample)),
        MakeBlocks(backend, specimens[specimen].observations, specimens[specimen].starts, options),
        options));
  }
  return all;
}

HierarchicalSamples::~HierarchicalSamples() = default;

int HierarchicalSamples::num_residuals() const {
  int sum = 0;
  for (int p = 0; p < parts_; ++p) sum += state(0, p).num_residuals();
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
               states_[task.index()]->Run(&task, scaled.col(task.index() / parts_), with_jacobians,
                                          least_step());
             });
}

bool HierarchicalSamples::Residuals(int draw, Eigen::VectorXd* residual,
                                    RowMatrix* jacobian) const {
  residual->resize(num_residuals());
  if (jacobian != nullptr) jacobian->resize(num_residuals(), num_latents_);
  int row = 0;
  for (int p = 0; p < parts_; ++p) {
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
    for (int p = 0; p < parts_; ++p) lost += state(s, p).valid ? 0 : 1;
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
  RunBatched(*backend_, parts_, kDrawsSideBySide, [&](BatchingBackend& task) {
    prototypes_[task.index()]->Run(&task, u, true, least_step());
  });
  for (std::size_t i = 0; i < states_.size(); ++i)
    states_[i] = SampleState::Copy(*prototypes_[i % parts_]);
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
  other->parts_ = parts_;
  for (const auto& prototype : prototypes_)
    other->prototypes_.push_back(SampleState::Copy(*prototype));
  for (int i = 0; i < draws * parts_; ++i)
    other->states_.push_back(SampleState::Copy(*prototypes_[i % parts_]));
  return other;
}

std::vector<Eigen::VectorXd> HierarchicalSamples::Shapes(int draw) const {
  std::vector<Eigen::VectorXd> shapes;
  for (int p = 0; p < specimens_; ++p) {
    const RolloutResiduals& outlines = state(draw, p).outlines;
    for (int i = 0; i < outlines.num_blocks(); ++i) shapes.push_back(outlines.shape(i));
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
