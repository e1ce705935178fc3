// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/fit/lab/lab_measurement.h"
#include "solver/fit/lab/strip_simulation.h"
#include "solver/fit/parameters/parametrisation.h"

namespace drape {

// All points of the laboratory measurement of a fit, measurement by measurement: the strips that
// compute them.
class StripResiduals {
 public:
  StripResiduals(std::vector<LabMeasurement> measurements, const Law& law);
  // Shares meshes; starts from the present shapes of the strips.
  StripResiduals Clone() const;

  const std::vector<LabMeasurement>& measurements() const { return measurements_; }
  int num_points() const { return static_cast<int>(strips_.size()); }

  // (computed − read)/σ of each point, shape [N], and, if not null, its derivative by θ, shape
  // [N, P]. The parametrisation is one of a single table. False where a strip has no stable
  // equilibrium.
  [[nodiscard]] bool Evaluate(const MaterialParametrisation& parametrisation,
                              const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                              RowMatrix* jacobian);
  // The readings that a material gives [°] or [1], shape [N]. False as above.
  [[nodiscard]] bool Compute(const MaterialField& material, Eigen::VectorXd* readings,
                             RowMatrix* by_log_entry = nullptr);

 private:
  StripResiduals() = default;

  std::vector<LabMeasurement> measurements_;
  std::vector<StripSimulation> strips_;
  std::vector<bool> first_of_measurement_;  // of each strip
};

}  // namespace drape
