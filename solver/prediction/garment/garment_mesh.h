// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {

// A garment ready to be sewn: one mesh of all panels, which seams join by pairs of vertices.
struct GarmentMesh {
  // The panels lie side by side along x, 50 mm apart, in the order of the pattern: uv are the
  // pattern's coordinates plus a shift in x of each panel, and rest_x is (uv, 0). So no two
  // vertices have the same place in the cloth, and directions to the weft are as drawn. A panel
  // shares no vertex with another: there is no hinge across a seam, which folds freely.
  Mesh mesh;
  Eigen::VectorXd start_x;  // before sewing, around the body [m], shape [3V]
  // Pairs of vertices that a seam joins, sorted, each once.
  std::vector<std::pair<int, int>> stitches;
  struct HeldRing {
    std::string name;
    std::vector<int> vertices;  // ascending
    bool held_by_pelvis;
  };
  std::vector<HeldRing> rings;
  std::vector<int> panel_begin;  // the first vertex of each panel, and the number of all
};

// Meshes each panel with relaxed, unstructured, nearly equilateral triangles with edges of about
// `edge` [m], 0.002 … 0.1: the same method as MakeDisc, with the vertices of the outline fixed at
// equal distances. (Refinement by a Delaunay mesher would add vertices to one side of a seam.) Both
// edges of a seam have as many vertices, from the mean of their lengths. A build returns the same
// result bit for bit on every run.
//
// Measured on the three shipped garments with edges of 12 mm: 5,387 to 9,258 vertices in 0.3 to
// 0.8 s on one core, no angle below 22°.
//
// Throws InputError that names `where`, the pattern's file, for an edge length out of range, more
// than 1,000,000 vertices, and panels too narrow for that edge length. The pattern has no problem
// (FindProblem).
GarmentMesh MakeGarmentMesh(const Pattern& pattern, double edge,
                            const std::string& where = "garment");

// Throws InputError that names `where` and the panel if seams lay two faces on one another, which
// contact cannot part: one of the wrong direction does so near a corner.
void CheckSeams(const GarmentMesh& garment, const Pattern& pattern, const std::string& where);

// A garment as one cloth under gravity, ready to be worn: the vertices that a stitch joins are one.
struct SewnGarment {
  // Faces and hinges are those of the panels in their rest state. The panels do not fit together
  // flat, so mesh.rest_x is the start, and there are no boundary loops.
  std::shared_ptr<const ClothModel> model = {};
  Eigen::VectorXd start_x = {};          // shape [3V]: joined vertices begin in the middle [m]
  std::vector<int> vertex_of;            // of each vertex of the GarmentMesh
  std::vector<int> held_by_pelvis = {};  // vertices of its rings, ascending
};

SewnGarment Sew(const GarmentMesh& garment, const Law& law);

}  // namespace drape
