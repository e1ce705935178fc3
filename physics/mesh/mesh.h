// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <string>
#include <vector>

namespace drape {

// One triangle [MODEL, M1]. It is plain data: the device kernels read the same struct.
struct Face {
  int vertex[3];           // counter-clockwise in material (UV) space
  double area;             // rest area det(Dm)/2 [m²]
  double inverse_rest[4];  // Dm⁻¹, row-major [1/m]: F = Ds·Dm⁻¹
};

// One interior edge with its two triangles [MODEL, M2]. Face 0 traverses the edge from n0 to n1.
struct Hinge {
  int vertex[4];  // n0, n1, vertex opposite in face 0, vertex opposite in face 1
  int face[2];
  double rest_length;  // l [m]
  double rest_area;    // over which it bends, A0 + A1 [m²]
  double direction;    // edge direction to the weft, 0 = 0°, 1 = 45°, 2 = 90°, in [0, 2]
};

// Triangle mesh of a cloth that is flat in its rest state. Vectors over the mesh are node-major: x0
// y0 z0 x1 … A mesh is not changed after BuildMesh has returned it.
struct Mesh {
  Eigen::VectorXd rest_x;  // rest positions in the world [m], shape [3V]
  Eigen::Matrix2Xd uv;     // material coordinates (weft, warp) [m], shape [2, V]
  std::vector<Face> faces;
  std::vector<Hinge> hinges;
  std::vector<std::vector<int>> boundary_loops;  // vertex indices, cloth on the left; longest first

  int num_vertices() const { return static_cast<int>(uv.cols()); }
  int num_faces() const { return static_cast<int>(faces.size()); }
  int num_hinges() const { return static_cast<int>(hinges.size()); }
};

// Builds faces, hinges and boundary from the rest positions [m], shape [3V], the material
// coordinates [m], shape [2, V], and the triangles, which index the columns of `uv`. Throws
// InputError (prefix `where`, then "face K" with K counted from 1) for an index out of range, a
// repeated corner, a UV area that is zero or negative, duplicate faces, non-manifold edges, an edge
// that its two faces traverse in the same direction, a non-manifold boundary, a vertex without a
// face, and coordinates that are not finite.
Mesh BuildMesh(const Eigen::VectorXd& rest_x, const Eigen::Matrix2Xd& uv,
               const std::vector<std::array<int, 3>>& triangles, const std::string& where);

// The corners of the faces, in their order: indices of vertices, shape [F].
std::vector<std::array<int, 3>> ListTriangles(const Mesh& mesh);

// An edge with its length in the rest state [m] and the area that it stands for, a third of those
// of its faces [m²].
struct RestEdge {
  int vertex[2];  // ascending
  double rest_length, area;
};
// All edges of a mesh, ascending by their vertices.
std::vector<RestEdge> ListEdges(const Mesh& mesh);

// Positions of the elements in material space (uv) [m]: the centroids of the faces, shape [2, F],
// and the midpoints of the hinge edges, shape [2, E].
Eigen::Matrix2Xd FaceCentres(const Mesh& mesh);
Eigen::Matrix2Xd HingeCentres(const Mesh& mesh);

// Whether two meshes are of one flat cloth: their areas and their reach from the origin agree to
// 3 %, which coarse polygons lack of a round cloth.
bool IsSameCloth(const Mesh& a, const Mesh& b);

// Fields of one mesh read at the points of another, by their places in the flat cloth.

// Gradients of the three barycentric coordinates of a face [1/m], columns.
Eigen::Matrix<double, 2, 3> BarycentricGradients(const Mesh& mesh, const Face& face);

// A field outside the cloth, where another mesh of its outer boundary extends further.
enum class Extrapolation {
  kNearest,  // as at the edge of the nearest triangle: no weight is negative
  kLinear    // from the nearest triangle: exact for a linear field
};

// Rows of weights that read a field of the vertices of `mesh` at points, shape [2, N], in its plane
// (uv) [m]: linear in the triangle that holds the point, of the nearest one for a point outside.
// Shape [N, V].
Eigen::SparseMatrix<double, Eigen::RowMajor> InterpolationWeights(
    const Mesh& mesh, const Eigen::Matrix2Xd& points,
    Extrapolation beyond = Extrapolation::kNearest);

// Positions [m] of one mesh, shape [3V], read at points of the cloth by weights [N, V]
// (InterpolationWeights): shape [3N].
Eigen::VectorXd ReadPositions(const Eigen::SparseMatrix<double, Eigen::RowMajor>& weights,
                              const Eigen::VectorXd& x);

}  // namespace drape
