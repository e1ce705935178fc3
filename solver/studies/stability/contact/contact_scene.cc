// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/contact/contact_scene.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "physics/cloth/contact/vertex_contact.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/strip.h"

namespace drape {
namespace {

using Scenario = StabilityScenario;
constexpr double kSide = 0.1, kAbove = 2e-3, kStay = 0.02;  // [m], [m], [s]

Mesh Square(double edge) {
  const int along = static_cast<int>(std::lround(kSide / edge));
  Mesh mesh = MakeStrip(kSide, kSide, along, static_cast<int>(std::lround(1.155 * along)));
  for (Eigen::Index i = 0; i < mesh.rest_x.size(); i += 3) mesh.rest_x[i] -= 0.5 * kSide;
  return mesh;
}

// Two cloths as one mesh, `apart` from one another, the upper one turned.
Mesh Pair(const Mesh& sheet, double apart, double turn) {
  const int count = sheet.num_vertices();
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Matrix3Xd x(3, 2 * count);
  Eigen::Matrix2Xd uv(2, 2 * count);
  const Eigen::Map<const Eigen::Matrix3Xd> flat(sheet.rest_x.data(), 3, count);
  x << flat, (rotation * flat).colwise() + apart * Eigen::Vector3d::UnitZ();
  uv << sheet.uv, sheet.uv;
  std::vector<std::array<int, 3>> triangles = ListTriangles(sheet);
  for (std::array<int, 3> triangle : ListTriangles(sheet)) {
    for (int& i : triangle) i += count;
    triangles.push_back(triangle);
  }
  return BuildMesh(x.reshaped(), uv, triangles, "two sheets");
}

Contact Surface(const StabilityCase& run) {
  return {.thickness = run.thickness, .range = run.range};
}

Eigen::Vector3d Gravity(Scenario scenario) {
  const double angle = std::atan(kSlopeTangent);
  switch (scenario) {
    case Scenario::kSlope:  // in the frame of the slope
      return kContactGravity * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    case Scenario::kSkid:
    case Scenario::kSheets:
    case Scenario::kPinch:
      return Eigen::Vector3d::Zero();
    default:
      return {0.0, 0.0, -kContactGravity};
  }
}

// Below the origin, or what the cloth of the scenario lies on.
Obstacle Below(const StabilityCase& run) {
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d centre(0.0, 0.0, -run.radius);
  switch (run.scenario) {
    case Scenario::kBall:
      return SphereObstacle{.centre = centre, .radius = run.radius};
    case Scenario::kPlate:
      return PlateObstacle{
          .radius = kSide, .thickness = kPlateThickness, .rim_radius = 0.5 * kPlateThickness};
    case Scenario::kRod:
      return CapsuleObstacle{
          .from = centre - kSide * y, .to = centre + kSide * y, .radius = run.radius};
    default:
      return PlaneObstacle{};
  }
}

std::vector<Obstacle> Balls(const StabilityCase& run, double time) {
  const double half = 0.5 * std::max(run.distance, kClosingFrom - run.speed * time);
  const auto ball = [&](double side) {
    return SphereObstacle{.centre = {0.0, 0.0, side * (run.radius + half)}, .radius = run.radius};
  };
  return {ball(-1.0), ball(1.0)};
}

double Duration(const StabilityCase& run) {
  switch (run.scenario) {
    case Scenario::kBall:
      return 0.01 + (2.0 * run.radius + 0.02) / run.speed;
    case Scenario::kPlate:
      return 0.01 + 0.03 / run.speed;
    case Scenario::kSheets:
      return 0.01 + 0.02 / run.speed;
    case Scenario::kRod:
      return 0.25;
    case Scenario::kSlope:
      return 0.4;
    case Scenario::kSkid:
      return 0.01 + 0.02 / run.speed;
    default:
      return kStay + (kClosingFrom - run.distance) / run.speed;
  }
}

Mesh MakeSheets(const StabilityCase& run) {
  const Mesh sheet = Square(run.edge);
  if (run.scenario == Scenario::kSheets) return Pair(sheet, 2.0 * kAbove, 0.4);
  if (run.layers > 1.0) return Pair(sheet, run.thickness + run.range, 0.4);
  return sheet;
}

// Where the sheets are at first, and how they move.
void Throw(const StabilityCase& run, ContactScene& scene) {
  const Eigen::Index all = scene.start.x.size(), first = all / scene.sheets;
  const Contact surface = Surface(run);
  double height = 0.5 * run.thickness + kAbove;
  Eigen::Vector3d velocity(0.0, 0.0, -run.speed);
  if (run.scenario == Scenario::kSlope) {
    const double pressure = run.density * -Gravity(run.scenario).z();
    height = LyingHeight(surface, pressure);
    velocity.setZero();
  } else if (run.scenario == Scenario::kSkid) {
    velocity.x() = run.speed;
  } else if (run.scenario == Scenario::kPinch) {
    height = run.layers > 1.0 ? -0.5 * (run.thickness + run.range) : 0.0;
    velocity.setZero();
  }
  for (Eigen::Index i = 0; i < all; i += 3) {
    scene.start.x[i + 2] += height;
    scene.start.v.segment<3>(i) = velocity;
    if (run.scenario == Scenario::kSheets)
      scene.start.v.segment<3>(i) = (i < first ? -0.5 : 0.5) * velocity;
  }
}

}  // namespace

double LyingHeight(const Contact& contact, double pressure) {
  double low = 0.0, high = contact.range;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    const double pushes = -contact.stiffness * EvaluateBarrier(middle, contact.range).slope;
    (pushes > pressure ? low : high) = middle;
  }
  return contact.offset() + 0.5 * (low + high);
}

ContactScene MakeContactScene(const StabilityCase& run, MaterialField material) {
  CHECK(IsOfContact(run.scenario));
  ContactScene made;
  made.material = Scaled(material, run.stretch, run.bend);
  made.material.density = run.density;
  made.is_self_contact = run.scenario == Scenario::kSheets || run.layers > 1.0;
  made.sheets = made.is_self_contact ? 2 : 1;
  Scene scene;
  scene.gravity = Gravity(run.scenario);
  made.model = std::make_shared<ClothModel>(MakeSheets(run), scene, MakeLaw(run.law));
  made.start = made.model->RestState();
  made.duration = Duration(run);
  Throw(run, made);
  Contact contact = Surface(run);
  if (run.scenario == Scenario::kPinch) {
    made.contact_at = [contact, run](double time) mutable {
      contact.obstacles = Balls(run, time);
      return contact;
    };
  } else {
    if (run.scenario != Scenario::kSheets) contact.obstacles = {Below(run)};
    made.contact_at = [contact](double) { return contact; };
  }
  return made;
}

}  // namespace drape
