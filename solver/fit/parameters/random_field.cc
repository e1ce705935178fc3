// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/random_field.h"

#include <Spectra/MatOp/SymShiftInvert.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/mesh/interpolation.h"

namespace drape {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Eigen::VectorXd VertexAreas(const Mesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_vertices());
  for (const Face& face : mesh.faces)
    for (const int v : face.vertex) areas[v] += face.area / 3;
  return areas;
}

}  // namespace

Sparse LaplaceStiffness(const Mesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Face& face : mesh.faces) {
    const Eigen::Matrix<double, 2, 3> gradients = BarycentricGradients(mesh, face);
    const Eigen::Matrix3d element = face.area * gradients.transpose() * gradients;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        entries.emplace_back(face.vertex[i], face.vertex[j], element(i, j));
  }
  Sparse stiffness(mesh.num_vertices(), mesh.num_vertices());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return stiffness;
}

LaplaceModes FindLaplaceModes(const Mesh& mesh, int count) {
  CHECK(count >= 1 && count < mesh.num_vertices() - 1) << count;
  constexpr int kMaxRestarts = 1000;
  constexpr double kTolerance = 1e-10;
  const Eigen::VectorXd areas = VertexAreas(mesh);
  const double area = areas.sum();
  const Sparse stiffness = LaplaceStiffness(mesh);
  Sparse mass(areas.size(), areas.size());
  for (int i = 0; i < areas.size(); ++i) mass.insert(i, i) = areas[i];
  using ShiftInvert = Spectra::SymShiftInvert<double, Eigen::Sparse, Eigen::Sparse>;
  using Product = Spectra::SparseSymMatProd<double>;
  ShiftInvert inverse(stiffness, mass);
  Product product(mass);
  const int subspace = std::min<int>(mesh.num_vertices(), std::max(2 * count + 1, 20));
  // The lowest eigenvalue is 0: shift below it, by less than the first that is not.
  Spectra::SymGEigsShiftSolver<ShiftInvert, Product, Spectra::GEigsMode::ShiftInvert> lanczos(
      inverse, product, count, subspace, -1.0 / area);
  lanczos.init();
  lanczos.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance,
                  Spectra::SortRule::SmallestAlge);
  CHECK(lanczos.info() == Spectra::CompInfo::Successful) << "modes of the Laplacian";
  LaplaceModes modes{lanczos.eigenvalues().cwiseMax(0.0), lanczos.eigenvectors()};
  for (auto mode : modes.vectors.colwise()) {
    Eigen::Index largest;
    mode.cwiseAbs().maxCoeff(&largest);
    mode *= std::copysign(std::sqrt(area / mode.cwiseAbs2().dot(areas)), mode[largest]);
  }
  return modes;
}

Eigen::VectorXd MaternDeviations(const Eigen::VectorXd& eigenvalues, const MaternOptions& options) {
  CHECK_GT(options.length, 0.0);
  const double kappa_squared = 2.0 / (options.length * options.length);
  const Eigen::VectorXd deviations = (kappa_squared + eigenvalues.array()).inverse();
  return options.sigma / deviations.norm() * deviations;
}

}  // namespace drape
