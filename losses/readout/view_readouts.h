// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "losses/camera/view.h"
#include "losses/readout/readout.h"
#include "losses/silhouette/silhouette.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Readouts of pictures from any side. Only the cloth itself hides cloth: what a support or a person
// hides is to be left out of the data.

// The coverage of each pixel in [0, 1] (RenderSoft), row-major, K = height·width [MODEL, M48].
class SilhouetteReadout final : public Readout {
 public:
  // view: a Camera is one that looks straight down. `mesh` must outlive the object.
  SilhouetteReadout(const Mesh& mesh, const View& view, const SoftSilhouetteOptions& options);
  int size() const override { return view_.camera.width * view_.camera.height; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  const Mesh& mesh_;
  View view_;
  SoftSilhouetteOptions options_;
};

// The depth [m] of the first surface at the centres of N pixels, K = N (FindVisible, DepthOrigin).
//
// Where a pixel sees no cloth it reads `background`, what a camera would measure there: the table,
// or, where the cloth alone was measured, a depth behind all of it. The derivative is exact for the
// face that is seen; where another face or the background comes into sight, the depth jumps as a
// measured one does, and no derivative tells of it. A robust loss bounds what few such pixels do;
// far from the solution, where they are many, a fit to the points of the map (PointCloudReadout),
// which is continuous, has to come first.
class DepthReadout final : public Readout {
 public:
  // pixels: row·width + column. `mesh` must outlive the object.
  DepthReadout(const Mesh& mesh, const View& view, std::vector<int> pixels, double background);
  int size() const override { return static_cast<int>(pixels_.size()); }
  // Returns false when x is not finite or not in front of the camera.
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  // ∂depth/∂(corners of the face) in the frame of the camera, columns.
  Eigen::Matrix3d DepthByCorners(const Eigen::VectorXd& seen, const SurfaceHit& hit) const;

  const Mesh& mesh_;
  View view_;
  std::vector<int> pixels_;
  double background_;
};

}  // namespace drape
