// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"
#include "solver/fit/outline_residuals.h"
#include "solver/posterior/variational/variational_fit.h"

namespace drape {

// The hierarchy [METHODS, P30], on a log scale and in units of the prior:
// what is common to a fabric, then what a specimen of it differs by. Given the branch of each
// drape, which its start says.
struct HierarchicalModel {
  MaterialField base;  // the prior's median: one table
  ParameterTying fabric = ParameterTying::kEntries;
  double fabric_sigma = 1.0;  // prior standard deviation of each log factor of the fabric
  // Of the log factors of a specimen on all stretch, on all bend entries; 0: specimens are alike.
  double specimen_stretch_sigma = 0.0, specimen_bend_sigma = 0.0;
  int specimens = 1;

  int num_fabric() const { return static_cast<int>(TyingMatrix(fabric).cols()); }
  bool has_specimens() const { return specimen_stretch_sigma > 0.0 || specimen_bend_sigma > 0.0; }
  int num_latents() const { return num_fabric() + (has_specimens() ? 2 * specimens : 0); }
  // ∂(log entries of a specimen)/∂u, shape [39, num_latents()].
  Eigen::MatrixXd LogEntries(int specimen) const;
  // "bend[2][4]", "specimen 3 bend".
  std::string NameFor(int latent) const;
};

// What a draw gives whose drape leaves its branch, or is not found, on the way to its point.
enum class LostBranchPolicy {
  kRefuse,        // nothing: Copy says so, and the optimiser shortens its step for all draws
  kRefuseAtOnce,  // the same, but the way is not tried in parts: an optimiser of one draw does that
  kTangent        // residuals that go on straight from the last point where the drape stood
};

// Outlines of all specimens as residuals of draws of the hierarchy: (r − r_image)/σ of each target,
// specimen by specimen. Each draw follows its own drapes from trial to trial (OutlineResiduals), in
// halved steps where it is lost at once; all rollouts of an evaluation go to the backend together.
class HierarchicalSamples final : public SampledResiduals {
 public:
  // targets[p]: of specimen p, with their drapes as starts. The backend outlives the object.
  HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                      const std::vector<std::vector<Observation>>& targets,
                      const OutlineResidualOptions& options, int draws,
                      LostBranchPolicy beyond = LostBranchPolicy::kRefuse);
  // As [Gong 2024]: each face and hinge has a draw of its own, exp(μ + σ·ε) times the base for
  // each entry, and u = (μ, σ), shape [78], in units of `sigma`. One specimen.
  static std::unique_ptr<HierarchicalSamples> Elementwise(
      Backend* backend, const MaterialField& base, double sigma,
      const std::vector<Observation>& targets, const OutlineResidualOptions& options, int draws,
      uint64_t seed, LostBranchPolicy beyond = LostBranchPolicy::kRefuse);
  ~HierarchicalSamples() override;

  int num_latents() const override { return num_latents_; }
  int num_residuals() const override;
  int num_draws() const override { return num_draws_; }
  void Prepare(const Eigen::MatrixXd& points, bool with_jacobians) override;
  [[nodiscard]] bool Copy(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const override;

  // Takes the drapes from the targets' starts to those of u, shape [num_latents()], for all draws
  // at once: they then are predicted from there. False when these are not stable.
  [[nodiscard]] bool StartAt(const Eigen::VectorXd& u);
  // Other draws of the same residuals, whose drapes are predicted from those of StartAt.
  std::unique_ptr<HierarchicalSamples> WithSamples(int draws, LostBranchPolicy beyond) const;
  // Draws of the last Prepare with a drape that did not stand.
  int num_extrapolated() const;
  // The drapes of a draw as last prepared, specimen by specimen.
  std::vector<Eigen::VectorXd> Shapes(int draw) const;
  RolloutCounts counts() const;

 private:
  struct SampleState;  // a draw of one specimen
  HierarchicalSamples() = default;
  const SampleState& cell(int draw, int specimen) const {
    return *cells_[draw * specimens_ + specimen];
  }
  double least_step() const;  // of the way to a point, as a share

  Backend* backend_ = nullptr;
  int num_latents_ = 0, num_draws_ = 0, specimens_ = 1;
  LostBranchPolicy beyond_ = LostBranchPolicy::kRefuse;
  std::vector<std::unique_ptr<SampleState>> prototypes_;  // of each specimen, at StartAt
  std::vector<std::unique_ptr<SampleState>> cells_;       // draw by draw
};

}  // namespace drape
