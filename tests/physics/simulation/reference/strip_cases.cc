// SPDX-License-Identifier: Apache-2.0
// Reference cases of strips: they bend under their weight or a load on the tip, hang, and are
// pulled.
#include <cmath>
#include <memory>

#include "physics/mesh/mesh_spec.h"
#include "physics/util/text_format.h"
#include "tests/physics/simulation/closed_forms.h"
#include "tests/physics/simulation/reference/reference_case.h"

namespace drape {
namespace {

constexpr double kLength = 0.1;         // of a cantilever [m]
constexpr double kDensity = 0.2;        // [kg/m²]
constexpr double kThinDensity = 0.005;  // little against the clamp's springs

struct Cantilever {
  std::shared_ptr<const ClothModel> model;
  double clamp;  // where its length starts [m]
};

// n triangles long and n/40 wide, so narrow that it is a beam: free to curl but for the first 1/50
// of its length. Each second row of vertices is shifted by half a spacing; those up to u = spacing
// are held, so the last held one is at 1 and 1/2 of it in turn and the clamp at 3/4.
Cantilever MakeCantilever(const Law& law, int n, Scene scene) {
  const double spacing = kLength / (n + 0.25);
  const int across = n / 40;
  scene.handles = CantileverScene(spacing, 0.0).handles;
  return {std::make_shared<const ClothModel>(
              MakeStrip((n + 1) * spacing, across * std::sqrt(0.75) * spacing, n + 1, across),
              scene, law),
          0.75 * spacing};
}

// Drop and reach of the tip [m].
Eigen::Vector2d DropAndReach(const Cantilever& cantilever, const Eigen::VectorXd& x) {
  const Mesh& mesh = cantilever.model->mesh;
  const Eigen::Vector3d move = TipMove(mesh, x);
  return {-move.z(), mesh.uv.row(0).maxCoeff() - cantilever.clamp + move.x()};
}

struct HeavyPoint {
  double gamma, drop_over_reach, tolerance;
};
constexpr double kAstmGamma = 8.0042, kAstmAngle = 41.5;  // [°]
// Master curve of the heavy elastica [Romero 2021], [MODEL, M53], and ASTM's angle.
constexpr HeavyPoint kHeavy[] = {{0.1, .01250, .01}, {0.5, .06244, .01}, {1, .12456, .01},
                                 {2, .24667, .01},   {5, .58572, .01},   {kAstmGamma, 0, 0},
                                 {10, 1.06680, .01}, {20, 1.86393, .01}, {50, 3.70556, .01},
                                 {100, 5.88810, .03}};

// Clamped and loaded at the tip across the rest direction, P·L²/EI.
struct TipPoint {
  double load, drop, shortening;  // by L
};
constexpr TipPoint kTip[] = {
    {1, .301721, .056433}, {2, .493457, .160642}, {5, .713792, .387628}, {10, .810609, .554996}};

}  // namespace

std::vector<ReferenceCase> CantileverCases(const Law& law) {
  constexpr double kInextensible = 1000.0;  // k by the weight of the strip
  const double load = kThinDensity * kReferenceGravity * kLength;
  std::vector<ReferenceCase> cases;
  for (const HeavyPoint& point : kHeavy)
    cases.push_back(point.gamma == kAstmGamma
                        ? ReferenceCase{"ASTM D1388 chord angle [deg]", kAstmAngle, 0.5, 1.0}
                        : RelativeReference(Format("H/W at Gamma = %g", point.gamma),
                                            point.drop_over_reach, point.tolerance));
  for (const int n : {80, 160, 320}) {
    Scene scene;
    scene.gravity = Eigen::Vector3d(0.0, 0.0, -kReferenceGravity);
    const Cantilever cantilever = MakeCantilever(law, n, scene);
    StepSolver solver(cantilever.model);
    Eigen::VectorXd x = cantilever.model->mesh.rest_x;
    for (std::size_t i = 0; i < cases.size(); ++i) {  // continuation in Γ
      const double EI = load * kLength * kLength / kHeavy[i].gamma;
      GoToRest(solver, LinearBeam(kInextensible * load, EI, kThinDensity), x);
      const Eigen::Vector2d tip = DropAndReach(cantilever, x);
      cases[i].computed.push_back(kHeavy[i].gamma == kAstmGamma
                                      ? std::atan2(tip[0], tip[1]) * 180.0 / M_PI
                                      : tip[0] / tip[1]);
    }
  }
  return cases;
}

std::vector<ReferenceCase> TipLoadCases(const Law& law) {
  constexpr double kPull = 0.005, kStiffness = 5.0;  // P [N/m of width], k [N/m]
  std::vector<ReferenceCase> cases;
  for (const TipPoint& point : kTip) {
    cases.push_back(
        RelativeReference(Format("drop / L at P L^2 / EI = %g", point.load), point.drop, .01));
    cases.push_back(RelativeReference(Format("(L - reach) / L at P L^2 / EI = %g", point.load),
                                      point.shortening, .01));
  }
  for (const int n : {80, 160, 320}) {
    const double spacing = kLength / (n + 0.25), width = n / 40 * std::sqrt(0.75) * spacing;
    Scene scene;
    scene.load = UniaxialScene((n + 1) * spacing, 0.0).load;
    scene.load->force = {0.0, 0.0, -kPull * width};
    const Cantilever cantilever = MakeCantilever(law, n, scene);
    StepSolver solver(cantilever.model);
    Eigen::VectorXd x = cantilever.model->mesh.rest_x;
    for (std::size_t i = 0; i < std::size(kTip); ++i) {  // continuation in the load
      const double EI = kPull * kLength * kLength / kTip[i].load;
      GoToRest(solver, LinearBeam(kStiffness, EI, kThinDensity), x);
      const Eigen::Vector2d tip = DropAndReach(cantilever, x);
      cases[2 * i].computed.push_back(tip[0] / kLength);
      cases[2 * i + 1].computed.push_back(1.0 - tip[1] / kLength);
    }
  }
  return cases;
}

// N = k(l² − 1)l/2 = k(ε + 3ε²/2 + …) lowers ρgL/2k by ρgL/k of it: .6 % at k = 100, nothing that
// shows at k = 10⁴, where the scaled value of [MODEL, M56] holds.
std::vector<ReferenceCase> HangingCases(const Law& law) {
  const double length = 0.3, load = kDensity * kReferenceGravity * length;
  std::vector<ReferenceCase> cases = {
      RelativeReference("stretch at k = 100 N/m, to second order",
                        load / 200.0 * (1.0 - load / 100.0), 1e-3),
      RelativeReference("stretch at k = 10000 N/m, x 100", 2.943e-3, 1e-3)};
  for (const int n : {30, 60, 120}) {
    const auto model =
        std::make_shared<const ClothModel>(MakeStrip(length, length / 15, n, n * 6 / 75 + 1),
                                           HangingStripScene(kReferenceGravity), law);
    StepSolver solver(model);
    for (const bool stiff : {false, true}) {
      Eigen::VectorXd x = model->mesh.rest_x;
      GoToRest(solver, LinearMaterial(stiff ? 1e4 : 1e2, 1e-6, kDensity), x);
      cases[stiff].computed.push_back(TipMove(model->mesh, x).x() / length * (stiff ? 100 : 1));
    }
  }
  return cases;
}

std::vector<ReferenceCase> UniaxialCases(const Law& law) {
  const double length = 0.2, width = 0.05, k = 100.0;
  std::vector<ReferenceCase> cases;
  for (const double stretch : {1.05, 1.1, 1.2}) {
    const double pull = k * (stretch * stretch - 1.0) * stretch / 2.0;
    ReferenceCase one = RelativeReference(Format("l at N = %.4g N/m", pull), stretch, 1e-3);
    one.scale = pull / (k * (3.0 * stretch * stretch - 1.0) / 2.0);  // .1 % of N, not of l
    for (const int n : {10, 20, 40}) {
      const auto model = std::make_shared<const ClothModel>(
          MakeStrip(length, width, n, 3 * n / 10), UniaxialScene(length, pull * width), law);
      StepSolver solver(model);
      Eigen::VectorXd x = model->mesh.rest_x;
      GoToRest(solver, LinearMaterial(k, 1e-6, kDensity), x);
      one.computed.push_back(1.0 + TipMove(model->mesh, x).x() / length);
    }
    cases.push_back(one);
  }
  return cases;
}

}  // namespace drape
