// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/scene_io.h"

#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/scan_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// Far more than any cloth has, and far less than what overflows.
constexpr double kMaxLength = 100.0;   // [m]
constexpr double kMaxGravity = 1e4;    // [m/s²]
constexpr double kMaxStiffness = 1e9;  // of a handle [N/m]
constexpr double kMaxForce = 1e6;      // [N]
constexpr double kMaxNormal = 1e6;     // any length, which is then divided by

double Positive(const JsonInput& input, double most) {
  const double value = input.Number();
  if (value <= 0.0 || value > most) input.Fail(Format("a number > 0 and ≤ %g", most));
  return value;
}

Eigen::Vector3d Vector(const JsonInput& input, double most) {
  input.ExpectArray(3);
  return {input.At(0).NumberWithin(-most, most), input.At(1).NumberWithin(-most, most),
          input.At(2).NumberWithin(-most, most)};
}

// x and y; the cloth lies at z = 0.
Eigen::Vector3d Centre(const JsonInput& region) {
  if (!region.Has("centre")) return Eigen::Vector3d::Zero();
  const JsonInput centre = region.At("centre").ExpectArray(2);
  return {centre.At(0).NumberWithin(-kMaxLength, kMaxLength),
          centre.At(1).NumberWithin(-kMaxLength, kMaxLength), 0.0};
}

RingRegion ReadRing(const JsonInput& input) {
  input.ExpectKeys({"inner", "outer", "centre"});
  RingRegion ring;
  ring.centre = Centre(input);
  if (input.Has("inner")) ring.inner = input.At("inner").Number();
  if (input.Has("outer")) ring.outer = input.At("outer").Number();
  if (ring.inner < 0.0 || ring.outer < ring.inner) input.Fail("0 ≤ inner ≤ outer");
  return ring;
}

HalfPlaneRegion ReadHalfPlane(const JsonInput& input) {
  input.ExpectKeys({"normal", "offset"});
  HalfPlaneRegion plane;
  plane.offset = input.At("offset").NumberWithin(-kMaxLength * kMaxNormal, kMaxLength * kMaxNormal);
  if (!input.Has("normal")) return plane;
  plane.normal = Vector(input.At("normal"), kMaxNormal);
  const double length = plane.normal.norm();
  if (length < 1.0 / kMaxNormal) input.At("normal").Fail("a direction");
  plane.normal /= length;
  plane.offset /= length;
  return plane;
}

Region ReadRegion(const JsonInput& input) {
  input.ExpectKeys({"disc", "ring", "half_plane"});
  if (input.Size() != 1) input.Fail("one of disc, ring, half_plane");
  if (input.Has("ring")) return ReadRing(input.At("ring"));
  if (input.Has("half_plane")) return ReadHalfPlane(input.At("half_plane"));
  const JsonInput disc = input.At("disc");
  disc.ExpectKeys({"radius", "centre"});
  return DiscRegion{Positive(disc.At("radius"), kMaxLength), Centre(disc)};
}

Handles ReadHandles(const JsonInput& input) {
  input.ExpectKeys({"region", "regions", "vertices", "stiffness"});
  Handles handles{.regions = {}, .stiffness = Positive(input.At("stiffness"), kMaxStiffness)};
  if (input.Has("region") && input.Has("regions")) input.Fail("region or regions, not both");
  if (input.Has("region")) handles.regions.push_back(ReadRegion(input.At("region")));
  if (input.Has("regions")) {
    const JsonInput regions = input.At("regions").ExpectArray();
    for (int i = 0; i < regions.Size(); ++i) handles.regions.push_back(ReadRegion(regions.At(i)));
  }
  if (input.Has("vertices")) {
    const JsonInput vertices = input.At("vertices").ExpectArray();
    for (int i = 0; i < vertices.Size(); ++i)
      handles.vertices.push_back(
          vertices.At(i).IntegerWithin(0, std::numeric_limits<int>::max() - 1));
  }
  if (handles.regions.empty() && handles.vertices.empty())
    input.Fail("region, regions or vertices, of what is held");
  return handles;
}

EdgeLoad ReadLoad(const JsonInput& input) {
  input.ExpectKeys({"region", "force"});
  return {.region = ReadRegion(input.At("region")), .force = Vector(input.At("force"), kMaxForce)};
}

PlaneObstacle ReadPlane(const JsonInput& input) {
  const HalfPlaneRegion plane = ReadHalfPlane(input);
  return {plane.normal, plane.offset};
}

SphereObstacle ReadSphere(const JsonInput& input) {
  input.ExpectKeys({"centre", "radius"});
  return {Vector(input.At("centre"), kMaxLength), Positive(input.At("radius"), kMaxLength)};
}

CapsuleObstacle ReadCapsule(const JsonInput& input) {
  input.ExpectKeys({"from", "to", "radius"});
  return {Vector(input.At("from"), kMaxLength), Vector(input.At("to"), kMaxLength),
          Positive(input.At("radius"), kMaxLength)};
}

PlateObstacle ReadPlate(const JsonInput& input) {
  input.ExpectKeys({"top", "radius", "thickness", "rim_radius"});
  PlateObstacle plate;
  plate.top = Vector(input.At("top"), kMaxLength);
  plate.radius = Positive(input.At("radius"), kMaxLength);
  if (input.Has("thickness")) plate.thickness = Positive(input.At("thickness"), kMaxLength);
  if (input.Has("rim_radius")) plate.rim_radius = Positive(input.At("rim_radius"), kMaxLength);
  if (plate.rim_radius > plate.radius || 2.0 * plate.rim_radius > plate.thickness)
    input.Fail("rim_radius of at most radius and thickness/2");
  return plate;
}

// The surface of a solid, in the place that the scene gives it.
ObjSurface ReadSolid(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys({"file", "scale", "translation"});
  const JsonInput file = input.At("file");
  const double scale = input.Has("scale") ? Positive(input.At("scale"), kMaxLength) : 1.0;
  Eigen::Vector3d move = Eigen::Vector3d::Zero();
  if (input.Has("translation")) move = Vector(input.At("translation"), kMaxLength);
  const std::string path = (std::filesystem::path(folder) / file.String()).string();
  try {
    ObjSurface surface = ReadSurface(path);
    for (Eigen::Index i = 0; i < surface.x.size(); i += 3)
      surface.x.segment<3>(i) = scale * surface.x.segment<3>(i) + move;
    if (const double most = surface.x.cwiseAbs().maxCoeff(); !(most <= kMaxLength))
      throw InputError(path, Format("a vertex has a coordinate of %g m, expected at most %g m; "
                                    "scale is the length of its unit in metres",
                                    most, kMaxLength));
    RequireClosed(surface, path);
    RequireSolid(surface, path);
    return surface;
  } catch (const InputError& error) {
    throw InputError(file.Name(), error.what());
  }
}

Obstacle ReadMesh(const JsonInput& input, const std::string& folder) {
  constexpr double kReach = 0.03;  // [m]
  ObjSurface surface = ReadSolid(input, folder);
  Eigen::Matrix3Xd x = surface.x.reshaped(3, surface.x.size() / 3);
  return std::make_shared<const SurfaceObstacle>(std::move(x), std::move(surface.triangles),
                                                 Eigen::Matrix3Xd(), kReach, SurfaceBlend::kPlaces);
}

Obstacle ReadObstacle(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys({"plane", "sphere", "capsule", "plate", "mesh"});
  if (input.Size() != 1) input.Fail("one of plane, sphere, capsule, plate, mesh");
  if (input.Has("mesh")) return ReadMesh(input.At("mesh"), folder);
  if (input.Has("plane")) return ReadPlane(input.At("plane"));
  if (input.Has("sphere")) return ReadSphere(input.At("sphere"));
  if (input.Has("capsule")) return ReadCapsule(input.At("capsule"));
  return ReadPlate(input.At("plate"));
}

Contact ReadContact(const JsonInput& input, const std::string& folder) {
  constexpr double kMostThickness = 0.1;  // [m], also of the range
  input.ExpectKeys({"thickness", "range", "stiffness", "obstacles", "self"});
  Contact contact;
  if (input.Has("self")) contact.self = input.At("self").Boolean();
  if (input.Has("thickness"))
    contact.thickness = input.At("thickness").NumberWithin(0.0, kMostThickness);
  if (input.Has("range")) contact.range = Positive(input.At("range"), kMostThickness);
  if (input.Has("stiffness")) contact.stiffness = Positive(input.At("stiffness"), kMaxStiffness);
  const JsonInput obstacles = input.At("obstacles").ExpectArray();
  for (int i = 0; i < obstacles.Size(); ++i)
    contact.obstacles.push_back(ReadObstacle(obstacles.At(i), folder));
  return contact;
}

}  // namespace

Scene ReadScene(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  return ReadScene(JsonInput(document, path), std::filesystem::path(path).parent_path().string());
}

Scene ReadScene(const JsonInput& input, const std::string& folder) {
  input.ExpectKeys({"stretch", "bend", "gravity", "handles", "load", "contact"});
  Scene scene;
  if (input.Has("stretch")) scene.stretch = input.At("stretch").Boolean();
  if (input.Has("bend")) scene.bend = input.At("bend").Boolean();
  if (input.Has("gravity")) scene.gravity = Vector(input.At("gravity"), kMaxGravity);
  if (input.Has("handles")) scene.handles = ReadHandles(input.At("handles"));
  if (input.Has("load")) scene.load = ReadLoad(input.At("load"));
  if (input.Has("contact")) scene.contact = ReadContact(input.At("contact"), folder);
  return scene;
}

}  // namespace drape
