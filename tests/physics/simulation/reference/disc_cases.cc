// SPDX-License-Identifier: Apache-2.0
// Reference cases of discs, of the rigidity that a mesh makes of a table, and of symmetry.
#include <Eigen/Geometry>
#include <cmath>
#include <memory>

#include "physics/cloth/assembly/assembly.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/text_format.h"
#include "tests/physics/simulation/closed_forms.h"
#include "tests/physics/simulation/reference/reference_case.h"

namespace drape {
namespace {

// A disc held where |x| ≥ radius [m], under gravity [m/s²] along −z. Two rings of held vertices
// clamp its edge; one ring leaves the edge free to rotate.
Scene ClampedDiscScene(double radius, double gravity) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -gravity);
  scene.handles = Handles{.regions = {RingRegion{.inner = radius}}, .stiffness = 1e6};
  return scene;
}

constexpr int kDiscs[] = {300, 1200, 4800};
constexpr double kDiscRounding = 1e-10;

// A stretched and wrinkled disc on which nothing but the cloth itself acts.
struct Wrinkled {
  ClothModel model;
  Eigen::VectorXd x;
};

Wrinkled MakeWrinkled(const Law& law, int vertices) {
  Wrinkled cloth{{MakeDisc({.target_vertices = vertices}), Scene(), law}, {}};
  cloth.x = cloth.model.mesh.rest_x;
  for (int i = 0; i < cloth.x.size(); i += 3) {
    const double u = cloth.x[i], v = cloth.x[i + 1];
    cloth.x[i] += 0.01 * u + 0.002 * v;
    cloth.x[i + 2] = 0.01 * std::sin(40.0 * u) * std::cos(30.0 * v);
  }
  return cloth;
}

MaterialField Anisotropic() {
  MaterialField material = LinearMaterial(1.0, 1e-5, 0.2);
  for (auto& row : material.stretch[0].c) row[0] = 60.0, row[1] = 5.0, row[2] = 40.0, row[3] = 15.0;
  for (int r = 0; r < kBendRows; ++r)
    for (double& entry : material.bend[0].b[r]) entry *= 1.0 + r;
  return material;
}

ReferenceCase Nothing(const std::string& name) { return {name, 0.0, kDiscRounding, 1.0}; }

using Matrix3X = Eigen::Matrix3Xd;

Matrix3X Forces(const ClothModel& model, const MaterialField& material, const Matrix3X& x) {
  Eigen::VectorXd force;
  AssembleForce(model, material, x.reshaped(), force);
  return force.reshaped(3, force.size() / 3);
}

Eigen::Matrix2d Diagonal(double uu, double vv) {
  return Eigen::Vector2d(uu, vv).asDiagonal().toDenseMatrix();
}

}  // namespace

std::vector<ReferenceCase> RigidityCases(const Law&) {
  const double nu = kHingePoisson;
  std::vector<ReferenceCase> cases = {
      RelativeReference("disc: D_mesh / D along u", 1.0, .02),
      RelativeReference("disc: D_mesh / D along v", 1.0, .02),
      RelativeReference("disc: dome, 2 (1 + nu)", 2.0 * (1.0 + nu), .02),
      RelativeReference("disc: saddle, 2 (1 - nu)", 2.0 * (1.0 - nu), .02),
      RelativeReference("strip: D_mesh / D, held flat across", 1.0, .02),
      RelativeReference("strip: D_mesh / D, free to curl, 1 - nu^2", 1.0 - nu * nu, .02)};
  const Eigen::Matrix2d bent[] = {Diagonal(1, 0), Diagonal(0, 1), Diagonal(1, 1), Diagonal(1, -1)};
  for (const int vertices : kDiscs) {
    const Mesh disc = MakeDisc({.target_vertices = vertices});
    for (int i = 0; i < 4; ++i) cases[i].computed.push_back(CurvatureRigidity(disc, bent[i]));
  }
  for (const int n : {40, 80, 160}) {
    const int across = n / 8;
    const Mesh strip = MakeStrip(0.1, across * std::sqrt(0.75) * 0.1 / n, n, across);
    cases[4].computed.push_back(CurvatureRigidity(strip, bent[0]));
    cases[5].computed.push_back(BeamRigidity(strip));
  }
  return cases;
}

// Held from a ring of vertices outwards. Where a hinge there bends over its held wing too, the
// clamp lies half a row of triangles outside that ring, between the first two held rows. The
// deflection is read at the vertex next to the centre and divided by the plate's own shape (1 −
// r²/a²)² there. The plate sinks by 3e-3 of its radius with a membrane too soft to stiffen it
// (relative w0²·k/D = 1e-4).
std::vector<ReferenceCase> ClampedDiscCases(const Law& law) {
  constexpr double kRadius = 0.1, kRigidity = 1e-2, kStiffness = 10.0, kDensity = 0.2;
  const double q = kDensity * kReferenceGravity;
  ReferenceCase one =
      RelativeReference("w0 [m], clamped", q * std::pow(kRadius, 4) / (64.0 * kRigidity), .02);
  for (const int vertices : kDiscs) {
    const double row = kRadius * std::sqrt(M_PI * std::sqrt(0.75) / vertices);
    const double inner = kRadius - (law.held_wing_bends() ? 0.5 * row : 0.0);
    const auto model = std::make_shared<const ClothModel>(
        MakeDisc(
            {.radius = inner + 2.5 * row, .support_radius = inner, .target_vertices = vertices}),
        ClampedDiscScene(inner, kReferenceGravity), law);
    StepSolver solver(model);
    Eigen::VectorXd x = model->mesh.rest_x;
    GoToRest(solver, LinearMaterial(kStiffness, kRigidity, kDensity), x);
    int centre = 0;
    const double r2 = model->mesh.uv.colwise().squaredNorm().minCoeff(&centre);
    const double shape = std::pow(1.0 - r2 / (kRadius * kRadius), 2);
    one.computed.push_back(-x[3 * centre + 2] / shape);
  }
  return {one};
}

// The drape test of a stiff cloth: the rim sinks by 3e-3 of the radius. A hinge that bends over its
// held wing too clamps half a row inside the ring of the support.
std::vector<ReferenceCase> AnnulusCases(const Law& law) {
  constexpr double kRadius = 0.15, kStiffness = 10.0, kDensity = 0.2;
  const double q = kDensity * kReferenceGravity, sag = 3e-3 * kRadius;
  std::vector<ReferenceCase> cases;
  for (const double ratio : {0.6, 0.4}) {
    const double rigidity =
        AnnulusDeflection(ratio, kHingePoisson) * q * std::pow(kRadius, 4) / sag;
    ReferenceCase one =
        RelativeReference(Format("rim [m], support %g of the radius", ratio), sag, .03);
    for (const int vertices : kDiscs) {
      const double row = kRadius * std::sqrt(M_PI * std::sqrt(0.75) / vertices);
      const double support = ratio * kRadius + (law.held_wing_bends() ? 0.5 * row : 0.0);
      Scene scene = ClampedDiscScene(support, kReferenceGravity);
      scene.handles->regions = {DiscRegion{.radius = support}};
      const auto model = std::make_shared<const ClothModel>(
          MakeDisc({.radius = kRadius, .support_radius = support, .target_vertices = vertices}),
          scene, law);
      StepSolver solver(model);
      Eigen::VectorXd x = model->mesh.rest_x;
      GoToRest(solver, LinearMaterial(kStiffness, rigidity, kDensity), x);
      const std::vector<int>& rim = model->mesh.boundary_loops[0];
      double sum = 0.0;
      for (const int i : rim) sum -= x[3 * i + 2];
      one.computed.push_back(sum / static_cast<double>(rim.size()));
    }
    cases.push_back(one);
  }
  return cases;
}

std::vector<ReferenceCase> RigidMotionCases(const Law& law) {
  std::vector<ReferenceCase> cases = {Nothing("net force / sum of forces"),
                                      Nothing("net torque / sum of torques"),
                                      Nothing("forces after a rigid motion of the rest"),
                                      Nothing("forces turn with a rigid motion")};
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(0.1, -0.2, 0.3);
  for (const int vertices : kDiscs) {
    const Wrinkled cloth = MakeWrinkled(law, vertices);
    const Matrix3X x = cloth.x.reshaped(3, vertices);
    const Matrix3X rest = cloth.model.mesh.rest_x.reshaped(3, vertices);
    const auto forces = [&](const Matrix3X& at) { return Forces(cloth.model, Anisotropic(), at); };
    const Matrix3X f = forces(x);
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (int i = 0; i < vertices; ++i) torque += x.col(i).cross(f.col(i));
    const Eigen::RowVectorXd size = f.colwise().norm();
    cases[0].computed.push_back(f.rowwise().sum().norm() / size.sum());
    cases[1].computed.push_back(torque.norm() / size.dot(x.colwise().norm()));
    cases[2].computed.push_back(forces((turn * rest).colwise() + shift).norm() / f.norm());
    cases[3].computed.push_back((forces((turn * x).colwise() + shift) - turn * f).norm() /
                                f.norm());
  }
  return cases;
}

std::vector<ReferenceCase> TurnCases(const Law& law) {
  ReferenceCase one = Nothing("forces after a quarter turn of material and table");
  for (const int vertices : kDiscs) {
    const Wrinkled cloth = MakeWrinkled(law, vertices);
    const Mesh& mesh = cloth.model.mesh;
    Eigen::Matrix2Xd uv(2, vertices);
    uv << -mesh.uv.row(1), mesh.uv.row(0);
    const ClothModel turned(BuildMesh(mesh.rest_x, uv, ListTriangles(mesh), "turned disc"), Scene(),
                            law);
    const Matrix3X x = cloth.x.reshaped(3, vertices);
    const Matrix3X f = Forces(cloth.model, Anisotropic(), x);
    const Matrix3X g = Forces(turned, TurnedByQuarter(Anisotropic()), x);
    one.computed.push_back((f - g).norm() / f.norm());
  }
  return {one};
}

}  // namespace drape
