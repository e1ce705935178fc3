// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "losses/camera/camera.h"
#include "losses/readout/device_readout.h"
#include "losses/silhouette/soft_silhouette.h"
#include "physics/mesh/mesh.h"
#include "physics/simulation/readout.h"

namespace drape {

// The radial profile r(θ) of the hem [px] at num_angles angles (OutlineFromMesh) [MODEL, M47]. Read
// returns false where an angle is missing.
class OutlineReadout final : public Readout {
 public:
  // cameras: one for each rollout, or one for all. `mesh` must outlive the object.
  OutlineReadout(const Mesh& mesh, std::vector<Camera> cameras, int num_angles);
  int size() const override { return num_angles_; }
  bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override;
  const DeviceReadout* device(std::size_t i) const override;

 private:
  const Mesh& mesh_;
  std::vector<Camera> cameras_;
  int num_angles_;
  std::vector<DeviceReadout> device_;
};

// The coverage of each pixel in [0, 1] (RenderSoft), row-major, K = height·width [MODEL, M48].
class SilhouetteReadout final : public Readout {
 public:
  // cameras: one for each rollout, or one for all; their images have one size. `mesh` must outlive
  // the object.
  SilhouetteReadout(const Mesh& mesh, std::vector<Camera> cameras,
                    const SoftSilhouetteOptions& options);
  int size() const override { return cameras_[0].width * cameras_[0].height; }
  bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override;
  const DeviceReadout* device(std::size_t i) const override;

 private:
  const Mesh& mesh_;
  std::vector<Camera> cameras_;
  SoftSilhouetteOptions options_;
  std::vector<DeviceReadout> device_;
};

}  // namespace drape
