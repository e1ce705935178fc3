// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/mechanical_test.h"
#include "solver/parametrisation.h"
#include "solver/tested_strip.h"

namespace drape {

// All points of the mechanical tests of a fit, test by test: the strips that compute them.
class StripReadings {
 public:
  StripReadings(std::vector<MechanicalTest> tests, const Law& law);
  // Shares meshes; goes on from the present shapes of the strips.
  StripReadings Clone() const;

  const std::vector<MechanicalTest>& tests() const { return tests_; }
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
  StripReadings() = default;

  std::vector<MechanicalTest> tests_;
  std::vector<TestedStrip> strips_;
  std::vector<bool> first_of_test_;  // of each strip
};

}  // namespace drape
