// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "losses/readout/readout.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

// Readouts of a cloth at rest on its scene.

// The force that handles exert on the cloth together, along K axes [N]: Σ k_h·(x_rest − x)·axis,
// the weight of a cloth that hangs from them.
class HandleForceReadout final : public Readout {
 public:
  // vertices: held ones. axes: of length 1, shape [3, K].
  HandleForceReadout(const ClothModel& model, const std::vector<int>& vertices,
                     const Eigen::Matrix3Xd& axes);
  int size() const override { return static_cast<int>(jacobian_.rows()); }
  int group() const override { return size(); }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  ReadoutJacobian jacobian_;
  Eigen::VectorXd at_zero_;
};

// Natural frequencies of small vibrations without damping and air [Hz] [MODEL, M67]: of the lowest
// modes, counted from 1, in the order of `modes`. An unstable mode has −√(−ω²)/2π. Where two
// frequencies meet, their modes change places and the derivative jumps. Read needs the cloth and
// returns false, ReadCloth does where the iteration does not converge.
class FrequencyReadout final : public Readout {
 public:
  // modes: not empty, each 1 … 3V − 1. `model` must outlive the object.
  FrequencyReadout(const ClothModel& model, std::vector<int> modes);
  int size() const override { return static_cast<int>(modes_.size()); }
  bool reads_material() const override { return true; }
  bool Read(const Eigen::VectorXd&, Eigen::VectorXd*, ReadoutJacobian*) const override {
    return false;
  }
  bool ReadCloth(const MaterialField& material, const Eigen::VectorXd& x, Eigen::VectorXd* r,
                 ReadoutJacobian* dr_dx, MaterialJacobian* dr_dp) const override;

 private:
  StepSolver solver_;
  std::vector<int> modes_;
};

}  // namespace drape
