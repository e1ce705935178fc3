// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "solver/fit/observed/observation.h"
#include "solver/fit/parametrisation.h"
#include "solver/forward/settle.h"

namespace drape {

struct ResidualOptions {
  SolveMode solve_mode = SolveMode::kStatic;
  // kDynamic only; the staged fit also relaxes its initial guesses by these steps.
  RolloutOptions rollout = {.h = 0.1, .steps = 40};
  // kStatic only. A trial needs more iterations only near a bifurcation.
  EquilibriumOptions equilibrium = {.max_iterations = 30};
  double sigma_px = 0.5;  // standard deviation of an outline's radius
  // A trial is rejected without a rollout when the root mean square of the predicted change of its
  // residuals, times sigma_px, is larger [px]. The first evaluation has no prediction.
  double max_outline_change = 4.0;
  // A trial is rejected as another branch when a vertex is further from its linear prediction [m].
  double max_jump = 0.03;
};

template <MutableOrConst<ResidualOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [solve_mode, rollout, equilibrium, sigma_px, max_outline_change, max_jump] = options;
  visit(sigma_px, Field{.key = "sigma_px",
                        .doc = "standard deviation of the outline, in pixels of a published image "
                               "(1.39 mm) whatever the image's scale",
                        .unit = "px",
                        .range = {.least = 1e-4, .most = 1e4}});
  visit(solve_mode,
        Field{.key = "solve", .doc = "fit the equilibrium, or the shape after the settle steps"});
  visit(max_outline_change, Field{.key = "max_outline_change",
                                  .doc = "reject a step that is predicted to move the outline "
                                         "further",
                                  .unit = "px",
                                  .range = {.least = 0, .above_least = true}});
  visit(max_jump, Field{.key = "max_jump",
                        .doc = "reject a drape with a vertex further from its prediction: it is on "
                               "another branch",
                        .unit = "m",
                        .range = {.least = 0, .above_least = true}});
  visit(rollout.h, Field{.key = "settle_time_step",
                         .doc = "time step that relaxes an initial guess",
                         .unit = "s",
                         .range = {.least = 0, .most = 10, .above_least = true}});
  visit(rollout.steps, Field{.key = "settle_steps",
                             .doc = "number of time steps that relax an initial guess",
                             .range = {.least = 0, .most = 100000}});
  visit(equilibrium.max_iterations,
        Field{.key = "newton_iterations", .range = {.least = 1}, .is_option = false});
}

struct RolloutCounts {
  int rollouts = 0;
  int tangents = 0;  // of them, with derivatives
  int failed = 0;    // numerical failures
  int jumps = 0;     // rejected: branch jumps
  int capped = 0;    // rejected before: predicted outlines too far away; not among the rollouts

  RolloutCounts& operator+=(const RolloutCounts& other);
};

// A cloth under one material, and what is read of it.
struct RolloutBlock {
  struct Run {
    Backend* backend = nullptr;                    // blocks of one backend are run as one batch
    State start;                                   // no positions: from rest (SolveFromRest)
    std::shared_ptr<Backend> owned = {};           // of a run that has a backend of its own
    std::shared_ptr<const ClothModel> model = {};  // of `owned`
    double weight = 1.0;  // of its readings in those of the block, which are their sum
    int finer = 1;        // each time step of the block is so many of its own
  };
  std::vector<Run> runs;
  std::vector<Sight> sights;
  SolveMode solve_mode = SolveMode::kStatic;
  RolloutOptions rollout = {};          // kDynamic; Sight::frame is one of its frames
  EquilibriumOptions equilibrium = {};  // kStatic
  // The only equilibrium of its scene, or a motion: trials have no branch to leave. An equilibrium
  // that is not found near the last is sought from rest; a motion begins at its start each time.
  bool is_unique = false;
  // Its runs start as those of the block before, to scale, where they have no start of their own.
  bool starts_like_previous = false;
  // Makes the material under which the cloth is simulated from the fabric's; none: it is the same.
  std::function<MaterialField(const MaterialField&)> prepare = {};
  bool has_own_bend = false;  // the bend entries are those of `prepare` alone

  int num_residuals() const;
  int num_independent() const;  // of them (CountIndependent); without experiments all
};

// The same motion by `parts` time steps for each: its frames are at the same times.
RolloutOptions WithFinerSteps(RolloutOptions options, int parts);

// A run on a backend of its own, of one host thread.
RolloutBlock::Run OwnRun(std::shared_ptr<const ClothModel> model, State start = {},
                         const std::string& backend = "cpu");

// Evaluates the residuals of all blocks at one θ: one material. The runs of a backend are one batch
// before Ceres calls the cost functions. A block takes adjoints where it has fewer residuals than
// half the entries of a table, since tangents also predict shapes, or where each element has a
// table (SolveMode::kStatic only); else tangents, and where the density is free.
class RolloutResiduals : public ceres::EvaluationCallback {
 public:
  // Pointers outlive the object. Many drapes are stable, and the start of a run says which of them
  // is meant [METHODS, P13].
  RolloutResiduals(const MaterialParametrisation* parametrisation, std::vector<RolloutBlock> blocks,
                   const ResidualOptions& options);

  // Gives the runs of a copy backends of their own, where they own some, so that another thread can
  // evaluate it.
  void RenewOwnBackends();
  // Continues with another backend of the same model, which outlives the object, for all runs that
  // do not own theirs.
  void Rebind(Backend* backend);

  // The parameter block that the optimiser changes in place, shape [P].
  double* theta() { return theta_.data(); }
  int num_parameters() const { return static_cast<int>(theta_.size()); }
  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  const RolloutBlock& block(int i) const { return blocks_[i]; }
  int num_residuals() const { return first_row_.back(); }
  int first_row(int block) const { return first_row_[block]; }
  const MaterialParametrisation& parametrisation() const { return *parametrisation_; }
  const RolloutCounts& counts() const { return counts_; }

  void PrepareForEvaluation(bool with_jacobians, bool new_point) override;

  // Whether all drapes of the last evaluation were found, and on their branches.
  bool all_valid() const;
  // Whether the drapes of a block were.
  bool valid(int block) const { return evaluations_[block].valid; }
  // Residuals of a valid block at the last evaluation, shape [num_residuals() of it], and their
  // derivatives, where it had some, shape [num_residuals() of it, P].
  const Eigen::VectorXd& residual(int block) const { return evaluations_[block].residual; }
  const RowMatrix& jacobian(int block) const { return evaluations_[block].jacobian; }
  // ½ Σ residual² of a valid block, or of the losses.
  double cost(int block) const;
  // Scales its residuals, and their Jacobian if not null, by the losses (WeighByLoss); returns its
  // cost.
  double Weigh(int block, Eigen::Ref<Eigen::VectorXd> residual,
               Eigen::Ref<Eigen::MatrixXd>* jacobian) const;

  // The shape of the first run of a block at the last evaluation, valid or not [m], shape [3V].
  const Eigen::VectorXd& shape(int block) const { return evaluations_[block].runs.front().x; }
  // Its shapes that are seen: the frames, and the end [m], shape [3V] each.
  std::vector<Eigen::VectorXd> seen_shapes(int block) const {
    std::vector<Eigen::VectorXd> shapes = evaluations_[block].runs.front().frames;
    shapes.push_back(shape(block));
    return shapes;
  }

  // A point at which shapes and Jacobians were found.
  struct Point {
    Eigen::VectorXd theta;
    double cost = 0.0;  // ½ Σ residual², or of the losses
    // Shapes by block and run [m], shape [3V]; its derivative where found by tangents, shape [3V,
    // P].
    std::vector<std::vector<Eigen::VectorXd>> x;
    std::vector<std::vector<RowMatrix>> x_by_theta;
    // All blocks, shape [N], [N, P], scaled by their losses: half the squares are the cost.
    Eigen::VectorXd residual;
    Eigen::MatrixXd jacobian;
  };
  // The last one; empty before has_accepted().
  bool has_accepted() const { return !accepted_.x.empty(); }
  const Point& accepted() const { return accepted_; }
  // Where the first run of each block starts at the next evaluation.
  std::vector<State> starts() const;
  // Makes the drapes of the accepted point, or of the last evaluation, the starts.
  void StartFromAccepted();
  void RestartFromLastShapes();
  // Goes back to an earlier one.
  void Restore(Point point);

 private:
  struct RunResult {
    bool found = false;
    Eigen::VectorXd x;                            // shape at the end
    RowMatrix x_by_theta;                         // its derivative, where computed by tangents
    std::vector<Eigen::VectorXd> frames = {};     // shapes that are seen before
    std::vector<RowMatrix> frames_by_theta = {};  // as x_by_theta
  };
  struct Evaluation {
    bool valid = false;
    std::vector<RunResult> runs;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
  };
  // A run of a block.
  struct Place {
    int block = 0, run = 0;
  };
  // The runs that go to one backend together.
  using Batch = std::vector<Place>;

  const RolloutBlock::Run& run(const Place& place) const {
    return blocks_[place.block].runs[place.run];
  }
  RunResult& result(const Place& place) { return evaluations_[place.block].runs[place.run]; }
  // The material of a block at the point of the evaluation.
  const MaterialField& material(int block) const {
    return blocks_[block].prepare ? prepared_[block] : fabric_;
  }
  // Whether a block begins at its start in each evaluation.
  bool is_motion(int block) const {
    return blocks_[block].is_unique && blocks_[block].solve_mode == SolveMode::kDynamic;
  }
  bool by_tangents(int block) const;
  // ∂(log entries, numbers of DynamicsEntry, velocity at the start)/∂θ of a block, shape [49, P].
  Eigen::MatrixXd NumbersByTheta(int block) const;
  std::vector<Batch> ListBatches() const;
  std::vector<RolloutInput> MakeInputs(const Batch& batch, const std::vector<State>& starts) const;
  std::vector<State> ListDrapes(const Batch& batch) const;
  void ClearEvaluations();
  void Evaluate(bool with_jacobians);
  static RunResult TakeRollout(RolloutResult rollout);
  void RunDynamic(const Batch& batch, bool with_jacobians);
  void RunStatic(const Batch& batch, bool with_jacobians);
  State StaticStart(const Place& place, bool with_jacobians) const;
  State StartLikePrevious(const Place& place) const;
  void FindDerivatives(const Batch& batch);
  void FindTangents(const Batch& batch);
  void FindAdjoints(const Batch& batch);
  // Seeds by the residuals of a block from its shape; nothing where that cannot be read.
  std::optional<RowMatrix> AdjointSeeds(const Place& place) const;
  void AddAdjoint(int block, const MaterialGradient& gradient);
  void FillResidual(int block, bool with_jacobian);
  bool IsTooFar() const;
  bool LeftBranch(int block) const;
  void PredictShapes(const std::vector<Batch>& batches);
  void PredictByProducts(const Batch& batch, const MaterialField& accepted,
                         const MaterialField& direction);
  void Accept();
  bool EvaluatedHere() const;

  const MaterialParametrisation* parametrisation_;
  std::vector<RolloutBlock> blocks_;
  std::vector<int> first_row_;  // of each block, and the number of all rows
  ResidualOptions options_;
  bool frees_density_ = false;
  Eigen::VectorXd theta_, evaluated_theta_;
  MaterialField fabric_;                 // at the point of the evaluation
  std::vector<MaterialField> prepared_;  // of the blocks that prepare it
  std::vector<Evaluation> evaluations_;
  Point accepted_;
  // Shapes at θ, linearised at the accepted point, by block and run.
  std::vector<std::vector<Eigen::VectorXd>> predicted_x_;
  RolloutCounts counts_;
};

// Observations on one backend, a block each.
std::vector<RolloutBlock> MakeBlocks(Backend* backend, const std::vector<Observation>& observations,
                                     const std::vector<State>& starts,
                                     const ResidualOptions& options);
// Their residuals.
RolloutResiduals ObservationResiduals(Backend* backend,
                                      const MaterialParametrisation* parametrisation,
                                      const std::vector<Observation>& observations,
                                      const std::vector<State>& starts,
                                      const ResidualOptions& options);

}  // namespace drape
