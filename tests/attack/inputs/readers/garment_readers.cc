// SPDX-License-Identifier: Apache-2.0
// What drape_garment and scenes with contact read: patterns of both formats, bodies of OBJ files,
// obstacles.
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "physics/cloth/scene_io.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/garment_mesh.h"
#include "solver/prediction/garment/pattern/pattern.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

constexpr double kEdge = 0.09;  // of the triangles [m]

// As far as a program gets before the first step.
std::string ReadAndSew(const std::string& path) {
  const GarmentMesh garment = MakeGarmentMesh(ReadPattern(path), kEdge, path);
  const SewnGarment sewn = Sew(garment, MakeLaw("smooth"));
  return garment.mesh.rest_x.allFinite() && garment.mesh.uv.allFinite() && sewn.start_x.allFinite()
             ? ""
             : "read a garment that is not finite";
}

std::string ReadBody(const std::string& folder) {
  const BodyFiles as_it_is = {.up = "z", .front = "-y", .scale = 1, .offset = {0, 0, 0}};
  const auto body = ReadBodySequence(folder + "/body_%04d.obj", as_it_is);
  return body->Positions(0.0).allFinite() && body->Positions(0.02).allFinite()
             ? ""
             : "read a body that is not finite";
}

// Frame number `mutated` of two, the other of which is good.
Reader MakeBodyReader(int mutated) {
  const auto file = [](int frame) { return Format("body_%04d.obj", frame); };
  return {.name = mutated == 0 ? "body" : "second frame of a body",
          .file = file(mutated),
          .content = MakeBodyObj(0.01 * mutated),
          .read =
              [=](const std::string& path) {
                const std::string folder = std::filesystem::path(path).parent_path();
                const int other = 1 - mutated;
                if (!std::filesystem::exists(folder + "/" + file(other)))
                  test::WriteQuickly(folder + "/" + file(other), MakeBodyObj(0.01 * other));
                return ReadBody(folder);
              },
          .is_json = false};
}

std::string CheckObstacles(const Scene& scene) {
  if (!scene.contact) return "";
  for (const Obstacle& obstacle : scene.contact->obstacles)
    for (const Eigen::Vector3d& x : {Eigen::Vector3d(0.1, 0.02, 0), Eigen::Vector3d(0, 0, 0.3)}) {
      const ObstacleDistance distance = DistanceTo(obstacle, x);
      if (!std::isfinite(distance.value) || !distance.normal.allFinite() ||
          !distance.curvature.allFinite())
        return "read an obstacle whose distance is not finite";
    }
  return "";
}

}  // namespace

std::vector<Reader> MakeGarmentReaders(const std::string& valid) {
  return {{.name = "garment",
           .file = "garment.json",
           .content = ReadText(valid + "skirt.json"),
           .read = ReadAndSew},
          {.name = "GarmentCode",
           .file = "specification.json",
           .content = ReadText(valid + "garmentcode.json"),
           .read = ReadAndSew},
          MakeBodyReader(0),
          MakeBodyReader(1),
          {.name = "contact",
           .file = "contact.json",
           .content = ReadText(valid + "contact.json"),
           .read = [](const std::string& path) { return CheckObstacles(ReadScene(path)); }}};
}

}  // namespace drape::attack
