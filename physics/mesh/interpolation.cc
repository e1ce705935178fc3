// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/interpolation.h"

#include <limits>
#include <vector>

namespace drape {
namespace {

Eigen::Vector3d Barycentric(const Mesh& mesh, const Face& face, const Eigen::Vector2d& point) {
  Eigen::Vector3d coordinates;
  const Eigen::Matrix<double, 2, 3> gradients = BarycentricGradients(mesh, face);
  for (int i = 0; i < 3; ++i)
    coordinates[i] = 1 + gradients.col(i).dot(point - mesh.uv.col(face.vertex[i]));
  return coordinates;
}

// The face in which the smallest coordinate of a point is largest: that which holds it, if one
// does.
int NearestFace(const Mesh& mesh, const Eigen::Vector2d& point) {
  int nearest = 0;
  double best = -std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.num_faces() && best < 0; ++f) {
    const double inside = Barycentric(mesh, mesh.faces[f], point).minCoeff();
    if (inside <= best) continue;
    best = inside;
    nearest = f;
  }
  return nearest;
}

}  // namespace

Eigen::Matrix<double, 2, 3> BarycentricGradients(const Mesh& mesh, const Face& face) {
  Eigen::Matrix<double, 2, 3> gradients;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d edge =
        mesh.uv.col(face.vertex[(i + 2) % 3]) - mesh.uv.col(face.vertex[(i + 1) % 3]);
    gradients.col(i) = Eigen::Vector2d(-edge.y(), edge.x()) / (2 * face.area);
  }
  return gradients;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> InterpolationWeights(const Mesh& mesh,
                                                                  const Eigen::Matrix2Xd& points,
                                                                  Extrapolation beyond) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < points.cols(); ++i) {
    const Face& face = mesh.faces[NearestFace(mesh, points.col(i))];
    Eigen::Vector3d weights = Barycentric(mesh, face, points.col(i));
    if (beyond == Extrapolation::kNearest)
      weights = weights.cwiseMax(0.0) / weights.cwiseMax(0.0).sum();
    for (int k = 0; k < 3; ++k) entries.emplace_back(i, face.vertex[k], weights[k]);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> weights(points.cols(), mesh.num_vertices());
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

Eigen::VectorXd ReadPositions(const Eigen::SparseMatrix<double, Eigen::RowMajor>& weights,
                              const Eigen::VectorXd& x) {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const Points read = weights * Eigen::Map<const Points>(x.data(), x.size() / 3, 3);
  return Eigen::Map<const Eigen::VectorXd>(read.data(), read.size());
}

}  // namespace drape
