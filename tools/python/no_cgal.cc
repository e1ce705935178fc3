// SPDX-License-Identifier: Apache-2.0
// What the module has in place of the parts of the libraries that use CGAL: they would bring GMP
// and MPFR. Nothing that it offers reaches them; Simulator refuses contact of the cloth with
// itself.
#include <glog/logging.h>

#include "losses/metrics/hausdorff.h"
#include "physics/mesh/self_intersection.h"
#include "physics/mesh/triangulate.h"

namespace drape {
namespace {

[[noreturn]] void LeftOut() { LOG(FATAL) << "the Python module leaves CGAL out"; }

}  // namespace

std::vector<std::array<int, 3>> Triangulate(const Eigen::Matrix2Xd&,
                                            const std::vector<std::pair<int, int>>&) {
  LeftOut();
}
void MoveToCentroids(const std::vector<std::array<int, 3>>&, int, Eigen::Matrix2Xd&) { LeftOut(); }
std::vector<int> SpatialOrder(const Eigen::Matrix2Xd&) { LeftOut(); }
std::vector<std::pair<int, int>> FindSelfIntersections(const std::vector<std::array<int, 3>>&,
                                                       const Eigen::VectorXd&, int) {
  LeftOut();
}
int CountSelfIntersections(const Mesh&, const Eigen::VectorXd&) { LeftOut(); }
double HausdorffOfPolygons(const Eigen::Matrix2Xd&, const Eigen::Matrix2Xd&, double) { LeftOut(); }
double HausdorffOfMeshes(const Mesh&, const Eigen::VectorXd&, const Mesh&, const Eigen::VectorXd&,
                         const std::string&, double) {
  LeftOut();
}
double HausdorffOfSurfaces(const ObjSurface&, const ObjSurface&, const std::string&, double) {
  LeftOut();
}

}  // namespace drape
