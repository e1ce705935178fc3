// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <span>

#include "losses/dataset/dataset.h"
#include "physics/cloth/scene_io.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/scan_io.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

std::string CheckField(const MaterialField& field) {
  double sum = field.density;
  for (const StretchTable& table : field.stretch)
    for (const double entry : std::span(table.entries(), kStretchEntries))
      sum += entry > 0 ? 1 / (1 + entry) : -entry;
  for (const BendTable& table : field.bend)
    for (const double entry : std::span(table.entries(), kBendEntries))
      sum += entry > 0 ? 1 / (1 + entry) : -entry;
  return std::isfinite(sum) && field.density > 0 ? "" : "read a fabric that is not finite";
}

std::string CheckState(const State& state) {
  return state.x.allFinite() && state.v.allFinite() ? "" : "read a state that is not finite";
}

// A strip of a few triangles, so that its files are short.
std::shared_ptr<const Mesh> MakeFewTriangles() {
  return std::make_shared<Mesh>(ParseMeshSpec("strip:0.1x0.05x3"));
}

Reader MakeFieldReader(const std::string& valid, const std::string& scratch) {
  const auto mesh = MakeFewTriangles();
  Material material = ReadMaterial(valid + "wool.json");
  material.field.stretch.assign(static_cast<std::size_t>(mesh->num_faces()),
                                material.field.stretch.front());
  material.field.bend.assign(static_cast<std::size_t>(mesh->num_hinges()),
                             material.field.bend.front());
  WriteMaterialField(scratch + "field.json", material, *mesh);
  return {.name = "field",
          .file = "field.json",
          .content = ReadText(scratch + "field.json"),
          .read = [mesh](const std::string& path) {
            return CheckField(ReadMaterialFor(*mesh, path).field);
          }};
}

Reader MakeStateReader(const std::string& scratch) {
  const auto mesh = MakeFewTriangles();
  WriteState(scratch + "state.json", {mesh->rest_x, 0 * mesh->rest_x});
  return {
      .name = "state",
      .file = "state.json",
      .content = ReadText(scratch + "state.json"),
      .read = [mesh](const std::string& path) { return CheckState(ReadStart(path, *mesh, 0.01)); }};
}

// A triangle in the binary form of a format: the bytes of its numbers.
template <class... T>
std::string Bytes(T... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

Reader MakeScanReader(const std::string& name, const std::string& file,
                      const std::string& content) {
  return {.name = name,
          .file = file,
          .content = content,
          .read =
              [](const std::string& path) {
                return ReadSurface(path).x.allFinite() ? std::string()
                                                       : "read a surface that is not finite";
              },
          .is_json = false};
}

}  // namespace

std::vector<Reader> MakeClothReaders(const std::string& valid, const std::string& scratch) {
  const auto mesh = MakeFewTriangles();
  WriteObj(scratch + "mesh.obj", *mesh, mesh->rest_x);
  const auto read_material = [](const std::string& path) {
    return CheckField(ReadMaterial(path).field);
  };
  return {
      {.name = "obj",
       .file = "mesh.obj",
       .content = ReadText(scratch + "mesh.obj"),
       .read =
           [](const std::string& path) {
             const Mesh read = ReadObj(path);
             return read.rest_x.allFinite() && read.uv.allFinite()
                        ? std::string()
                        : "read a mesh that is not finite";
           },
       .is_json = false},
      {.name = "surface",
       .file = "surface.obj",
       .content = ReadText(scratch + "mesh.obj"),
       .read =
           [](const std::string& path) {
             return ReadObjSurface(path).x.allFinite() ? std::string()
                                                       : "read a surface that is not finite";
           },
       .is_json = false},
      MakeScanReader("surface.stl", "surface.stl",
                     "solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid a\n"),
      MakeScanReader("surface.ply", "surface.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                     "y\nproperty float z\nelement face 1\nproperty list uchar int "
                     "vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
      MakeScanReader("binary stl", "surface.stl",
                     std::string(80, ' ') + Bytes(uint32_t{1}) + Bytes(0.f, 0.f, 1.f) +
                         Bytes(0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f) + std::string(2, ' ')),
      MakeScanReader("binary ply", "surface.ply",
                     "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float "
                     "x\nproperty float y\nproperty double z\nelement face 1\nproperty list uchar "
                     "int vertex_indices\nend_header\n" +
                         Bytes(0.f, 0.f) + Bytes(0.0) + Bytes(1.f, 0.f) + Bytes(0.0) +
                         Bytes(0.f, 1.f) + Bytes(0.0) + Bytes(uint8_t{3}) + Bytes(0, 1, 2)),
      {.name = "published mesh",
       .file = "drape.obj",
       .content = ReadText(scratch + "mesh.obj"),
       .read =
           [](const std::string& path) {
             ReadObjDiscs(path);
             const PublishedMesh read = ReadPublishedMesh(path);
             return read.surface.x.allFinite() && (!read.cloth || read.cloth->rest_x.allFinite())
                        ? std::string()
                        : "read a mesh that is not finite";
           },
       .is_json = false},
      {.name = "material",
       .file = "material.json",
       .content = ReadText(valid + "wool.json"),
       .read = read_material},
      {.name = "published",
       .file = "published.json",
       .content = ReadText(valid + "published.json"),
       .read = read_material},
      MakeFieldReader(valid, scratch),
      {.name = "start",
       .file = "start.json",
       .content = ReadText(valid + "waves.json"),
       .read =
           [mesh](const std::string& path) { return CheckState(ReadStart(path, *mesh, 0.01)); }},
      MakeStateReader(scratch),
      {.name = "scene",
       .file = "scene.json",
       .content = ReadText(valid + "pull.json"),
       .read = [](const std::string& path) {
         ReadScene(path);
         return std::string();
       }}};
}

}  // namespace drape::attack
