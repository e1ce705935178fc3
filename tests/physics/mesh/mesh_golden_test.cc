// SPDX-License-Identifier: Apache-2.0
// Compares with the mesh of the reference simulator on a published disc (golden/README.md).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

const std::string kShared = DRAPE_SHARED_DIR;

#define SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "test data is absent: " << (path)

TEST(MeshGolden, HingesAndAreasAreThoseOfTheReference) {
  const std::string golden_path = kShared + "/golden/force_circle1_cotton_blue.json";
  const std::string disc_path = kShared + "/cusick/mesh_in/circle1.obj";
  SKIP_WITHOUT(golden_path);
  SKIP_WITHOUT(disc_path);
  const auto golden = nlohmann::json::parse(std::ifstream(golden_path));
  const Mesh mesh = ReadObj(disc_path, {.round_to_float = true});
  const auto& hinges = golden.at("edge_nodes_faces");
  ASSERT_EQ(mesh.hinges.size(), hinges.size());
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    const Hinge& h = mesh.hinges[e];
    EXPECT_EQ(
        nlohmann::json({h.vertex[0], h.vertex[1], h.vertex[2], h.vertex[3], h.face[0], h.face[1]}),
        hinges[e]);
    const double l = golden.at("l")[e], ldaa = golden.at("ldaa")[e];
    EXPECT_NEAR(h.rest_length, l, 1e-14 * l);
    EXPECT_NEAR(h.rest_length / h.rest_area, ldaa, 1e-13 * ldaa);
  }
  ASSERT_EQ(mesh.faces.size(), golden.at("face_area").size());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const double area = golden.at("face_area")[f];
    EXPECT_NEAR(mesh.faces[f].area, area, 1e-13 * area);
  }
}

TEST(MeshGolden, EachPublishedDiscLoads) {
  const int vertices[] = {297, 1205, 2699, 4766, 7496};
  for (int i = 0; i < 5; ++i) {
    const std::string path = kShared + "/cusick/mesh_in/circle" + std::to_string(i + 1) + ".obj";
    SKIP_WITHOUT(path);
    const Mesh mesh = ReadObj(path);
    EXPECT_EQ(mesh.num_vertices(), vertices[i]);
    EXPECT_EQ(mesh.boundary_loops.size(), 1u);
    EXPECT_EQ(mesh.num_vertices() - mesh.num_hinges() -
                  static_cast<int>(mesh.boundary_loops[0].size()) + mesh.num_faces(),
              1);  // Euler
  }
}

TEST(MeshGolden, APublishedTargetLoadsWithItsDummyVt) {
  const std::string path = kShared + "/cusick/data/Fabric 5/meshes/Fabric_5_Sample_2_Capture_4.obj";
  SKIP_WITHOUT(path);
  EXPECT_EQ(ReadObjSurface(path).triangles.size(), 5226u);
  EXPECT_EQ(ReadObj(path, {.first_vt_is_dummy = true}).num_vertices(), 2699);
  EXPECT_THROW(ReadObj(path), InputError);
}

}  // namespace
}  // namespace drape
