// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/camera.h"
#include "losses/outline/outline.h"
#include "losses/readout/readout.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Readouts of the hem as it is seen from above.

// The radial profile r(θ) of the hem [px] at num_angles angles (OutlineFromMesh) [MODEL, M47]. Read
// returns false where an angle is missing.
class OutlineReadout final : public Readout {
 public:
  // `mesh` must outlive the object.
  OutlineReadout(const Mesh& mesh, const Camera& camera, int num_angles);
  int size() const override { return num_angles_; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  const Mesh& mesh_;
  Camera camera_;
  int num_angles_;
};

// The vertical projection of the hem: its radial profile r(θ) [m] from the axis at 360 angles,
// K = 360. Read returns false where an angle is missing.
class ProjectionReadout final : public Readout {
 public:
  // `mesh` must outlive the object.
  ProjectionReadout(const Mesh& mesh, const DrapeDiscs& discs);
  int size() const override { return outline_.size(); }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  Camera above_;
  OutlineReadout outline_;
};

// The shape features of the vertical projection [MODEL, M49], K = kNumShapeFeatures. Read returns
// false where an angle is missing.
class FeatureReadout final : public Readout {
 public:
  // `mesh` must outlive the object.
  FeatureReadout(const Mesh& mesh, const DrapeDiscs& discs)
      : discs_(discs), profile_(mesh, discs) {}
  int size() const override { return kNumShapeFeatures; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  DrapeDiscs discs_;
  ProjectionReadout profile_;
};

// The fold spectrum: amplitudes [m] of the modes 1 … K of the vertical projection (ComputeMode),
// which a turn of the drape does not change. A mode of amplitude zero, which has no derivative, has
// zero here. Read returns false where an angle is missing.
class SpectrumReadout final : public Readout {
 public:
  // num_modes: 1 … 179. `mesh` must outlive the object.
  SpectrumReadout(const Mesh& mesh, const DrapeDiscs& discs, int num_modes);
  int size() const override { return num_modes_; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  int num_modes_;
  ProjectionReadout profile_;
};

}  // namespace drape
