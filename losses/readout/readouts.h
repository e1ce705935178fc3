// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <string>

#include "losses/camera/camera.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/mesh/mesh.h"

namespace drape {

// ∂r/∂x, shape [K, 3V].
using ReadoutJacobian = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The numbers that a loss reads from a shape of a cloth.
class Readout {
 public:
  virtual ~Readout() = default;
  // K, which is the same for all shapes.
  virtual int size() const = 0;
  // Rows that belong together under a robust loss: 3 of a point, 1 of a number.
  virtual int group() const { return 1; }
  // Computes r(x) of a shape x [m], shape [3V], in shape [K], and its Jacobian unless dr_dx is
  // null. Returns false where the shape cannot be read. May be called from several threads at a
  // time.
  [[nodiscard]] virtual bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                                  ReadoutJacobian* dr_dx) const = 0;
};

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

// The shape itself [m], K = 3V.
class PositionReadout final : public Readout {
 public:
  explicit PositionReadout(const Mesh& mesh) : size_(static_cast<int>(mesh.rest_x.size())) {}
  int size() const override { return size_; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  int size_;
};

// The shape features of the vertical projection [MODEL, M49], K = kNumShapeFeatures: the
// features of its outline at 360 angles from the axis. Read returns false where an angle is
// missing.
class FeatureReadout final : public Readout {
 public:
  // `mesh` must outlive the object.
  FeatureReadout(const Mesh& mesh, const DrapeDiscs& discs);
  int size() const override { return kNumShapeFeatures; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  DrapeDiscs discs_;
  Camera above_;
  OutlineReadout outline_;
};

// The coverage of each pixel in [0, 1] (RenderSoft), row-major, K = height·width [MODEL, M48].
class SilhouetteReadout final : public Readout {
 public:
  // `mesh` must outlive the object.
  SilhouetteReadout(const Mesh& mesh, const Camera& camera, const SoftSilhouetteOptions& options);
  int size() const override { return camera_.width * camera_.height; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  const Mesh& mesh_;
  Camera camera_;
  SoftSilhouetteOptions options_;
};

// What is read of every drape of a batch.
struct ReadoutChoice {
  std::string of = "positions";  // or "outline", "features", "silhouette": the readouts above
  Camera camera;                 // of outline and silhouette
  int num_angles = 360;          // of outline
  double half_width = 1.0;       // of silhouette [px]
};
// Throws InputError for an unknown name, an invalid camera and numbers that are not positive.
// `mesh` must outlive the result.
std::unique_ptr<Readout> MakeReadout(const ReadoutChoice& choice, const Mesh& mesh,
                                     const DrapeDiscs& discs);

}  // namespace drape
