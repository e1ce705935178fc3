// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "solver/posterior/samples/hierarchical_samples.h"

namespace drape {

// Model bdp [Gong 2024], [METHODS, P33], as residuals: each face and hinge of each specimen has a
// sample of its own, exp(m + s·ε) times the base for each of the 39 entries, with
//   m = mean_sigma · u[0, 39), s = element_sigma · u[39, 78),
// so u has the units of the priors of m and of s. Specimens share m and s, not their noise ε,
// which depends on (seed, sample, specimen) alone.
class ElementwiseSamples final : public SampledResiduals {
 public:
  struct Scales {
    double mean_sigma = 1.0, element_sigma = 0.3;
  };
  // The backend and the specimens' observations outlive the object.
  ElementwiseSamples(Backend* backend, const MaterialField& base, const Scales& scales,
                     const std::vector<SpecimenDrapes>& specimens,
                     const OutlineResidualOptions& options, int draws, uint64_t seed,
                     LostBranchPolicy policy = LostBranchPolicy::kReject);

  int num_latents() const override { return 2 * kMaterialEntries; }
  int num_residuals() const override;
  int num_draws() const override { return specimens_[0]->num_draws(); }
  // Specimen by specimen: the samples of one are a batch.
  void Prepare(const Eigen::MatrixXd& points, bool with_jacobians) override;
  [[nodiscard]] bool Residuals(int draw, Eigen::VectorXd* residual,
                               RowMatrix* jacobian) const override;

  // Takes all drapes from the starts to those of u, shape [78]; they are then predicted from there.
  // False when one is not stable.
  [[nodiscard]] bool StartAt(const Eigen::VectorXd& u);
  // The number of samples of the last Prepare, over all specimens, with a drape that is not valid.
  int num_extrapolated() const;
  RolloutCounts counts() const;

 private:
  Eigen::MatrixXd InUnitsOfMeans(Eigen::MatrixXd points) const;

  double ratio_;  // element_sigma / mean_sigma
  std::vector<std::unique_ptr<HierarchicalSamples>> specimens_;
};

}  // namespace drape
