// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/readout/readout.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Readouts of places on the cloth.

// The shape itself [m], K = 3V: also a registered mesh, a marker at each vertex.
class PositionReadout final : public Readout {
 public:
  explicit PositionReadout(const Mesh& mesh) : size_(static_cast<int>(mesh.rest_x.size())) {}
  int size() const override { return size_; }
  int group() const override { return 3; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  int size_;
};

// Rows of weights of the vertices that read N places, shape [N, V]. They sum to 1.
using PlaceWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Places by their material coordinates (weft, warp) [m], shape [2, N], which are the same places on
// every mesh of the cloth: linear in the face that holds them. A hem that a mesh cuts short is
// continued by the nearest face, by up to a tenth of its height. Throws InputError (prefix `where`)
// that names a place farther off the cloth, counted from 1.
PlaceWeights WeightsOfPlaces(const Mesh& mesh, const Eigen::Matrix2Xd& material,
                             const std::string& where);
// Vertices, counted from 0. Throws InputError (prefix `where`) for one that the mesh has not.
PlaceWeights WeightsOfVertices(const Mesh& mesh, const std::vector<int>& vertices,
                               const std::string& where);

// The coordinates [m] of N places on the cloth, K = 3N. Read returns false when x is not finite.
class MarkerReadout final : public Readout {
 public:
  explicit MarkerReadout(const PlaceWeights& weights);
  int size() const override { return static_cast<int>(jacobian_.rows()); }
  int group() const override { return 3; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  ReadoutJacobian jacobian_;
};

// How far the tip, the mean of some vertices, is along a direction, over a length, K = 1: the
// stretch of a strip that is held where this is zero, by its rest length (strip method). Read
// returns false when the tip is not finite.
class TipReadout final : public Readout {
 public:
  // along: of length 1; length [m].
  TipReadout(std::vector<int> tip, const Eigen::Vector3d& along, double length);
  int size() const override { return 1; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  std::vector<int> tip_;
  Eigen::Vector3d along_;
  double length_;
};

// The angle [°] below the horizontal of the chord from a clamp to the tip, the mean of some
// vertices, in the vertical plane of a horizontal direction, K = 1 [ASTM D1388]. Read returns false
// when the tip is not finite or on the clamp.
class AngleReadout final : public Readout {
 public:
  // clamp [m]; along: horizontal, of length 1.
  AngleReadout(std::vector<int> tip, const Eigen::Vector3d& clamp, const Eigen::Vector3d& along);
  int size() const override { return 1; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  std::vector<int> tip_;
  Eigen::Vector3d clamp_, along_;
};

}  // namespace drape
