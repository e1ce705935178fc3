// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/wrap.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <iterator>

namespace drape {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = std::array<int, 3>;
using Eigen::Vector3d;

// Two edges and the normal.
Eigen::Matrix3d Frame(const Eigen::VectorXd& x, const Triangle& t) {
  Eigen::Matrix3d frame;
  frame.col(0) = Vertex(x, t[1]) - Vertex(x, t[0]);
  frame.col(1) = Vertex(x, t[2]) - Vertex(x, t[0]);
  frame.col(2) = frame.col(0).cross(frame.col(1)).normalized();
  return frame;
}

Point ToPoint(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

using Shapes = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Shapes::const_iterator>>>;

Kernel::Triangle_3 Shape(const Eigen::VectorXd& x, const Triangle& t) {
  return {ToPoint(Vertex(x, t[0])), ToPoint(Vertex(x, t[1])), ToPoint(Vertex(x, t[2]))};
}

}  // namespace

ObjSurface Wrap(const ObjSurface& surface) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  using Mesh = CGAL::Surface_mesh<Point>;
  std::vector<Point> points;
  for (Eigen::Index i = 0; i < surface.x.size(); i += 3)
    points.push_back(ToPoint(surface.x.segment<3>(i)));
  std::vector<std::vector<std::size_t>> faces;
  for (const Triangle& t : surface.triangles) faces.emplace_back(t.begin(), t.end());
  pmp::repair_polygon_soup(points, faces);
  pmp::orient_polygon_soup(points, faces);
  Mesh mesh, wrapped;
  pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
  pmp::stitch_borders(mesh);
  std::vector<Mesh::Halfedge_index> holes;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(holes));
  for (const auto hole : holes) pmp::triangulate_hole(mesh, hole, CGAL::Emptyset_iterator());
  CGAL::alpha_wrap_3(mesh, kWrapGap, kWrapOffset, wrapped);
  ObjSurface result{Eigen::VectorXd(3 * wrapped.number_of_vertices()), {}};
  for (const auto v : wrapped.vertices())
    for (int k = 0; k < 3; ++k) result.x[3 * v.idx() + k] = wrapped.point(v)[k];
  for (const auto f : wrapped.faces()) {
    auto corner = result.triangles.emplace_back().begin();
    for (const auto v : wrapped.vertices_around_face(wrapped.halfedge(f)))
      *corner++ = static_cast<int>(v.idx());
  }
  return result;
}

Follower::Follower(const ObjSurface& surface, const Eigen::VectorXd& points)
    : place_(3, points.size() / 3) {
  Shapes shapes;
  std::vector<Triangle> kept;
  for (const Triangle& t : surface.triangles) {
    const Eigen::Matrix3d frame = Frame(surface.x, t);
    if (!(frame.determinant() > 1e-12)) continue;  // [m²]
    kept.push_back(t);
    shapes.push_back(Shape(surface.x, t));
  }
  const Tree tree(shapes.cbegin(), shapes.cend());
  for (Eigen::Index i = 0; i < place_.cols(); ++i) {
    const Vector3d p = points.segment<3>(3 * i);
    const Triangle& t = kept[tree.closest_point_and_primitive(ToPoint(p)).second - shapes.cbegin()];
    triangles_.push_back(t);
    place_.col(i) = Frame(surface.x, t).inverse() * (p - Vertex(surface.x, t[0]));
  }
}

Eigen::VectorXd Follower::At(const Eigen::VectorXd& x) const {
  Eigen::VectorXd points(place_.size());
  for (Eigen::Index i = 0; i < place_.cols(); ++i)
    points.segment<3>(3 * i) =
        Vertex(x, triangles_[i][0]) + Frame(x, triangles_[i]) * place_.col(i);
  return points;
}

double PressIn(ObjSurface& surface) {
  constexpr double kThick = .04;  // thinner parts, as fingers and ears, keep their shape [m]
  constexpr double kFar = 10;     // [m]
  constexpr double kHead = .84;   // of the height: lips and ears above keep their shape
  const auto heights = surface.x.reshaped(3, surface.x.size() / 3).row(2);
  const double head = (1 - kHead) * heights.minCoeff() + kHead * heights.maxCoeff();
  Shapes shapes;
  Eigen::Matrix3Xd normal = Eigen::Matrix3Xd::Zero(3, surface.x.size() / 3);
  for (const Triangle& t : surface.triangles) {
    shapes.push_back(Shape(surface.x, t));
    const Eigen::Matrix3d frame = Frame(surface.x, t);
    for (const int i : t) normal.col(i) += frame.col(0).cross(frame.col(1));
  }
  normal.colwise().normalize();
  const Tree tree(shapes.cbegin(), shapes.cend());
  Eigen::VectorXd pressed = surface.x;
  double most = 0;
  std::vector<Shapes::const_iterator> met;
  for (int i = 0; i < normal.cols(); ++i) {
    const Vector3d p = Vertex(surface.x, i), n = normal.col(i);
    if (p.z() > head) continue;
    // Measures along `way` how far off the next face is that vertex i is not part of, `reach` for
    // none, and by how many faces it leaves a part more than it enters one.
    const auto meet = [&](const Vector3d& from, const Vector3d& way, double reach) {
      met.clear();
      tree.all_intersected_primitives(Kernel::Segment_3(ToPoint(from), ToPoint(p + reach * way)),
                                      std::back_inserter(met));
      std::pair<double, int> found(reach, 0);
      for (const auto shape : met) {
        const Triangle& t = surface.triangles[shape - shapes.cbegin()];
        if (std::find(t.begin(), t.end(), i) != t.end()) continue;
        const Vector3d facing = Frame(surface.x, t).col(2);
        found.first =
            std::min(found.first, (Vertex(surface.x, t[0]) - p).dot(facing) / way.dot(facing));
        found.second += facing.dot(way) > 0 ? 1 : -1;
      }
      return found;
    };
    const Vector3d under = p - 1e-6 * n;  // where other parts touch the surface from outside
    const double behind = meet(under, -n, kPartGap).first;
    const bool inside = behind < kPartGap && meet(p, n, kFar).second > 0;  // of another part
    const double gap = inside ? -behind : meet(p, n, kPartGap).first;
    if (gap == kPartGap || (!inside && meet(under, -n, kThick).first < kThick)) continue;
    const double press = (kPartGap - gap) / 2;
    pressed.segment<3>(3 * i) -= press * n;
    most = std::max(most, press);
  }
  surface.x = pressed;
  return most;
}

Eigen::VectorXd Contract(const ObjSurface& surface, double length) {
  constexpr double kLargest = 10;  // of a cotangent: slivers pull no more than that
  const auto count = surface.x.size() / 3;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(count);
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const Vector3d u = Vertex(surface.x, b) - Vertex(surface.x, a),
                     v = Vertex(surface.x, c) - Vertex(surface.x, a);
      const double doubled = std::max(1e-12, u.cross(v).norm());  // area [m²]
      const double pull = length * length / 2 * std::clamp(u.dot(v) / doubled, 0.0, kLargest);
      mass[a] += doubled / 6;
      for (const auto& [i, j] : {std::pair(b, c), {c, b}}) {
        entries.emplace_back(i, i, pull);
        entries.emplace_back(i, j, -pull);
      }
    }
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, std::max(mass[i], 1e-12));
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::MatrixXd x = surface.x.reshaped(3, count).transpose();
  const Eigen::MatrixXd solved = solver.solve(mass.asDiagonal() * x);
  return solved.transpose().reshaped();
}

double SmoothStep(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

}  // namespace drape
