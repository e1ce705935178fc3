// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/halve_edges.h"

#include <gtest/gtest.h>

#include "physics/mesh/mesh_spec.h"

namespace drape {
namespace {

TEST(HalveEdges, MakesFourFacesOfEachAndKeepsTheVertices) {
  for (const char* spec : {"strip:0.3x0.1x6", "disc:300"}) {
    const Mesh mesh = ParseMeshSpec(spec), halved = HalveEdges(mesh);
    const int old = mesh.num_vertices();
    EXPECT_EQ(halved.num_faces(), 4 * mesh.num_faces()) << spec;
    EXPECT_EQ(halved.num_vertices(), old + static_cast<int>(ListEdges(mesh).size()));
    EXPECT_EQ(halved.uv.leftCols(old), mesh.uv);
    EXPECT_EQ(halved.rest_x.head(3 * old), mesh.rest_x);
    for (int f = 0; f < halved.num_faces(); ++f)
      EXPECT_NEAR(halved.faces[f].area, mesh.faces[f / 4].area / 4, 1e-15);
    ASSERT_EQ(halved.boundary_loops.size(), mesh.boundary_loops.size());
    EXPECT_EQ(halved.boundary_loops[0].size(), 2 * mesh.boundary_loops[0].size());
    double longest = 0.0, before = 0.0;
    for (const RestEdge& edge : ListEdges(halved)) longest = std::max(longest, edge.rest_length);
    for (const RestEdge& edge : ListEdges(mesh)) before = std::max(before, edge.rest_length);
    EXPECT_NEAR(longest, before / 2, 1e-12);
  }
}

}  // namespace
}  // namespace drape
