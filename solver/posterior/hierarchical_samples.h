// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"
#include "solver/fit/outline_residuals.h"
#include "solver/posterior/variational_fit.h"

namespace drape {

// The hierarchy [METHODS, P30], on a log scale and in units of the prior: what specimens of a
// fabric have in common, then how each of them differs. The branch of each drape is given, by its
// start.
struct HierarchicalModel {
  MaterialField base;  // the prior's median: one table
  ParameterTying fabric = ParameterTying::kEntries;
  double fabric_sigma = 1.0;  // prior standard deviation of each log factor of the fabric
  // Prior standard deviations of a specimen's log factors on all stretch and on all bend entries;
  // 0: specimens are alike.
  double specimen_stretch_sigma = 0.0, specimen_bend_sigma = 0.0;
  int specimens = 1;
  // Instead of fabric_sigma: R, and R·Rᵀ is the prior covariance of the fabric's log factors; shape
  // [num_fabric(), num_fabric()] or empty.
  Eigen::MatrixXd fabric_root = {};

  int num_fabric() const { return static_cast<int>(TyingMatrix(fabric).cols()); }
  bool has_specimens() const { return specimen_stretch_sigma > 0.0 || specimen_bend_sigma > 0.0; }
  int num_latents() const { return num_fabric() + (has_specimens() ? 2 * specimens : 0); }
  // ∂(log entries of a specimen)/∂u, shape [39, num_latents()].
  Eigen::MatrixXd LogEntries(int specimen) const;
  // Log factors of the fabric and of its specimens by u, shape [num_latents(), num_latents()].
  Eigen::MatrixXd LatentRoot() const;
  // "bend[2][4]", "specimen 3 bend".
  std::string NameFor(int latent) const;
};

// What happens to a sample whose drape leaves its branch, or is not found, on the way to its point.
enum class LostBranchPolicy {
  kReject,        // it has no residuals, and the optimiser shortens its step for all samples
  kRejectAtOnce,  // the same, without smaller steps: an optimiser of one sample takes them itself
  kExtrapolate    // its residuals are linear from the last point with a valid drape
};

// The drapes of one specimen: what was seen, and where each starts.
struct SpecimenDrapes {
  std::vector<Observation> observations;
  std::vector<State> starts;
};

// Outlines of all specimens as residuals of samples of the hierarchy: (r − r_image)/σ of each
// observation, specimen by specimen. Each sample follows its own drapes from trial to trial
// (OutlineResiduals), in halved steps where they are lost at once; all rollouts of an evaluation go
// to the backend together.
class HierarchicalSamples final : public SampledResiduals {
 public:
  // The backend and the specimens' observations outlive the object.
  HierarchicalSamples(Backend* backend, const HierarchicalModel& hierarchy,
                      const std::vector<SpecimenDrapes>& specimens,
                      const OutlineResidualOptions& options, int draws,
                      LostBranchPolicy policy = LostBranchPolicy::kReject);
  // Model bdp [Gong 2024], [METHODS, P33]: each face and hinge of each specimen has a sample of its
  // own, exp(m + s·ε) times the base for each of the 39 entries, with
  //   m = mean_sigma · u[0, 39), s = element_sigma · u[39, 78),
  // so u, shape [78], has the units of the priors of m and of s. Specimens share m and s, not their
  // noise ε, which depends on (seed, sample, specimen) alone.
  struct ElementScales {
    double mean_sigma = 1.0, element_sigma = 0.3;
  };
  static std::unique_ptr<HierarchicalSamples> Elementwise(
      Backend* backend, const MaterialField& base, const ElementScales& scales,
      const std::vector<SpecimenDrapes>& specimens, const OutlineResidualOptions& options,
      int draws, uint64_t seed, LostBranchPolicy policy = LostBranchPolicy::kReject);
  ~HierarchicalSamples() override;

  int num_latents() const override { return num_latents_; }
  int num_residuals() const override;
  int num_draws() const override { return num_draws_; }
  void Prepare(const Eigen::MatrixXd& points, bool with_jacobians) override;
  [[nodiscard]] bool Residuals(int draw, Eigen::VectorXd* residual,
                               RowMatrix* jacobian) const override;

  // Takes the drapes from the starts to those of u, shape [num_latents()], for all samples at once;
  // they are then predicted from there. False when these are not stable.
  [[nodiscard]] bool StartAt(const Eigen::VectorXd& u);
  // Other samples of the same residuals, whose drapes are predicted from those of StartAt.
  std::unique_ptr<HierarchicalSamples> WithSamples(int draws, LostBranchPolicy policy) const;
  // The number of samples of the last Prepare with a drape that is not valid; of elementwise ones,
  // over all specimens.
  int num_extrapolated() const;
  // The drapes of a sample as last prepared, specimen by specimen.
  std::vector<Eigen::VectorXd> Shapes(int draw) const;
  RolloutCounts counts() const;

 private:
  struct SampleState;  // of one specimen
  HierarchicalSamples() = default;
  const SampleState& state(int draw, int specimen) const {
    return *states_[draw * specimens_ + specimen];
  }
  bool is_elementwise() const { return prototypes_.empty(); }
  double least_step() const;  // of the way to a point, as a share

  Backend* backend_ = nullptr;
  int num_latents_ = 0, num_draws_ = 0, specimens_ = 1;
  double element_ratio_ = 1.0;  // element_sigma / mean_sigma
  LostBranchPolicy policy_ = LostBranchPolicy::kReject;
  std::vector<std::unique_ptr<SampleState>>
      prototypes_;  // of each specimen, at StartAt; elementwise: none
  std::vector<std::unique_ptr<SampleState>> states_;  // sample by sample
};

}  // namespace drape
