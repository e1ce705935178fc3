// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/dynamics.h"

#include "physics/cloth/assembly/air_element.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {
namespace {

// The inputs of AirImpulse, by their place among the derivatives of a dual number.
enum AirInput { kAirX = 0, kAirV = 9, kAirWind = 12, kAirDrag = 15, kAirInputs = 16 };
using AirDual = Dual<kAirInputs>;

Vec3<AirDual> Seeded(const Vec3<double>& a, int first) {
  return {{a.x, first}, {a.y, first + 1}, {a.z, first + 2}};
}

double FaceDrag(const Face& face, const Dynamics& moving, double h) {
  return h * moving.air_drag * face.area / 3.0;
}

// Calls visit(face, corner, impulse with its derivatives by x of the face, v of the corner, wind
// and c) for all corners of all faces.
template <class Visit>
void ForEachAirImpulse(const ClothModel& model, const MaterialField& material,
                       const MovingStep& step, const Visit& visit) {
  const Dynamics& moving = material.dynamics;
  const Vec3<AirDual> wind = Seeded(moving.wind, kAirWind);
  for (const Face& face : model.mesh.faces) {
    Vec3<AirDual> x[3];
    for (int a = 0; a < 3; ++a)
      x[a] = Seeded(LoadVec3(step.x.data(), face.vertex[a]), kAirX + 3 * a);
    const Vec3<AirDual> n = UnitNormal(x);
    AirDual drag = FaceDrag(face, moving, step.h);
    drag.v[kAirDrag] = step.h * face.area / 3.0;
    for (int a = 0; a < 3; ++a) {
      const Vec3<double> w = LoadVec3(step.w.data(), face.vertex[a]);
      visit(face, a,
            AirImpulse(drag, n, Seeded(LoadVec3(step.v.data(), face.vertex[a]), kAirV),
                       Vec3<AirDual>{w.x, w.y, w.z}, wind));
    }
  }
}

// Calls visit(row of the impulse, whether by x, row of x or v, derivative) for the corners' inputs.
template <class Visit>
void ForEachAirDerivative(const ClothModel& model, const MaterialField& material,
                          const MovingStep& step, const Visit& visit) {
  ForEachAirImpulse(model, material, step,
                    [&](const Face& face, int corner, const Vec3<AirDual>& impulse) {
                      const int to = 3 * face.vertex[corner];
                      for (int r = 0; r < 3; ++r) {
                        const double* by = (&impulse.x)[r].v;
                        for (int j = 0; j < 9; ++j)
                          visit(to + r, true, 3 * face.vertex[j / 3] + j % 3, by[kAirX + j]);
                        for (int j = 0; j < 3; ++j) visit(to + r, false, to + j, by[kAirV + j]);
                      }
                    });
}

// out += scale·H(x)·w of stretch and bend [MODEL, M11, M14].
void AddElementStiffnessTimes(const ClothModel& model, const MaterialField& material,
                              const Eigen::VectorXd& x, const Eigen::VectorXd& w, double scale,
                              double* out) {
  VisitLaws(
      model,
      [&](const auto& law) {
        for (int f = 0; f < model.mesh.num_faces(); ++f) {
          const Face& face = model.mesh.faces[f];
          const DeformationGradient<double> F = GatherColumns(face, x.data());
          const auto k = EvaluateStretch(law, Green(F), material.stretch_of(f));
          const DeformationGradient<double> Hw =
              StretchStiffnessTimes(k, F, GatherColumns(face, w.data()));
          ScatterColumns(face, {scale * Hw.u, scale * Hw.v}, out);
        }
      },
      [&](const auto& law) {
        for (int e = 0; e < model.mesh.num_hinges(); ++e) {
          const Hinge& hinge = model.mesh.hinges[e];
          const HingeCorners places = GatherCorners(hinge, x.data());
          const double theta = DihedralAngle(places);
          const HingeGradient d = AngleGradient(EvaluateWings(places));
          const double moment = HingeStiffness(law, hinge, material.bend_of(e), theta) *
                                law.Measure(theta).slope * Dot(d, GatherCorners(hinge, w.data()));
          for (int a = 0; a < 4; ++a) AddTo(out, hinge.vertex[a], (scale * moment) * d.d[a]);
        }
      });
}

}  // namespace

void AddAirStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                const Eigen::VectorXd& v, double h, Eigen::VectorXd& force, BlockMatrix& A) {
  const Dynamics& moving = material.dynamics;
  for (const Face& face : model.mesh.faces) {
    const Vec3<double> corner[3] = {LoadVec3(x.data(), face.vertex[0]),
                                    LoadVec3(x.data(), face.vertex[1]),
                                    LoadVec3(x.data(), face.vertex[2])};
    const Vec3<double> n = UnitNormal(corner);
    const Eigen::Vector3d normal(n.x, n.y, n.z);
    for (const int i : face.vertex) {
      const double d =
          AirCoefficient(FaceDrag(face, moving, h), n, LoadVec3(v.data(), i), moving.wind);
      A.Add(model.pattern.diagonal[i], d * normal * normal.transpose());
      force.segment<3>(3 * i) += (d / h * Dot(n, moving.wind)) * normal;
    }
  }
}

void AddAirTangent(const ClothModel& model, const MaterialField& material, const MovingStep& step,
                   const RowMatrix& dx, const RowMatrix& dv, RowMatrix& out) {
  ForEachAirDerivative(model, material, step, [&](int to, bool by_x, int from, double derivative) {
    out.row(to) += derivative * (by_x ? dx : dv).row(from);
  });
}

void AddAirAdjoint(const ClothModel& model, const MaterialField& material, const MovingStep& step,
                   const RowMatrix& lambda, RowMatrix& adj_x, RowMatrix& adj_v) {
  ForEachAirDerivative(model, material, step, [&](int to, bool by_x, int from, double derivative) {
    (by_x ? adj_x : adj_v).row(from) += derivative * lambda.row(to);
  });
}

RowMatrix DynamicsColumns(const ClothModel& model, const MaterialField& material,
                          const MovingStep& step) {
  RowMatrix columns = RowMatrix::Zero(model.num_dofs(), kDynamicsEntries);
  const double h = step.h, alpha = material.dynamics.mass_damping;
  const Eigen::VectorXd area = model.LumpedMass(1.0), momentum = area.cwiseProduct(step.w);
  columns.col(kByDensity) = area.cwiseProduct(step.v) - (1.0 + h * alpha) * momentum;
  if (model.scene.gravity)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      columns.col(kByDensity).segment<3>(3 * i) += h * model.vertex_area[i] * *model.scene.gravity;
  columns.col(kByMassDamping) = -h * material.density * momentum;
  Eigen::VectorXd stiff = Eigen::VectorXd::Zero(model.num_dofs());
  AddElementStiffnessTimes(model, material, step.x, step.w, -h, stiff.data());
  columns.col(kByStiffnessDamping) = stiff;
  ForEachAirImpulse(model, material, step,
                    [&](const Face& face, int corner, const Vec3<AirDual>& impulse) {
                      for (int r = 0; r < 3; ++r) {
                        const int row = 3 * face.vertex[corner] + r;
                        const double* by = (&impulse.x)[r].v;
                        columns(row, kByAirDrag) += by[kAirDrag];
                        for (int j = 0; j < 3; ++j) columns(row, kByWind + j) += by[kAirWind + j];
                      }
                    });
  return columns;
}

}  // namespace drape
