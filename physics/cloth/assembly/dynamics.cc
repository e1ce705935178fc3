// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/dynamics.h"

#include "physics/cloth/assembly/air_element.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {
namespace {

double FaceDrag(const Face& face, const Dynamics& moving, double h) {
  return h * moving.air_drag * face.area / 3.0;
}

template <int N>
Vec3<Dual<N>> Seeded(const Vec3<double>& a, int first) {
  return {{a.x, first}, {a.y, first + 1}, {a.z, first + 2}};
}
template <int N>
Vec3<Dual<N>> Constant(const Vec3<double>& a) {
  return {a.x, a.y, a.z};
}

Vec3<double> FaceNormal(const Face& face, const Eigen::VectorXd& x) {
  return UnitNormal<double>({LoadVec3(x.data(), face.vertex[0]), LoadVec3(x.data(), face.vertex[1]),
                             LoadVec3(x.data(), face.vertex[2])});
}
// The same with its derivatives by the nine coordinates.
Vec3<Dual<9>> NormalByCorners(const Face& face, const Eigen::VectorXd& x) {
  Vec3<Dual<9>> corner[3];
  for (int a = 0; a < 3; ++a) corner[a] = Seeded<9>(LoadVec3(x.data(), face.vertex[a]), 3 * a);
  return UnitNormal(corner);
}

// Calls visit(row of the impulse, whether by x, row of x or v, derivative) for all corners of all
// faces: through the normal, and by the velocity of the corner.
template <class Visit>
void ForEachAirDerivative(const ClothModel& model, const MaterialField& material,
                          const MovingStep& step, const Visit& visit) {
  const Dynamics& moving = material.dynamics;
  for (const Face& face : model.mesh.faces) {
    const Vec3<Dual<9>> normal = NormalByCorners(face, step.x);
    const auto n = Seeded<6>({normal.x.a, normal.y.a, normal.z.a}, 0);
    const Dual<6> drag = FaceDrag(face, moving, step.h);
    for (const int i : face.vertex) {
      const auto impulse =
          AirImpulse(drag, n, Seeded<6>(LoadVec3(step.v.data(), i), 3),
                     Constant<6>(LoadVec3(step.w.data(), i)), Constant<6>(moving.wind));
      for (int r = 0; r < 3; ++r) {
        const double* by = (&impulse.x)[r].v;
        for (int j = 0; j < 9; ++j)
          visit(3 * i + r, true, 3 * face.vertex[j / 3] + j % 3,
                by[0] * normal.x.v[j] + by[1] * normal.y.v[j] + by[2] * normal.z.v[j]);
        for (int j = 0; j < 3; ++j) visit(3 * i + r, false, 3 * i + j, by[3 + j]);
      }
    }
  }
}

// Calls add(row, entry, derivative) for the impulse of the air by c and wind. It is in proportion
// to c.
template <class Add>
void ForEachAirNumber(const ClothModel& model, const MaterialField& material,
                      const MovingStep& step, const Add& add) {
  const Dynamics& moving = material.dynamics;
  const auto wind = Seeded<3>(moving.wind, 0);
  for (const Face& face : model.mesh.faces) {
    const double area_time = step.h * face.area / 3.0;
    const Vec3<double> n = FaceNormal(face, step.x);
    for (const int i : face.vertex) {
      const Vec3<double> v = LoadVec3(step.v.data(), i), w = LoadVec3(step.w.data(), i);
      const Vec3<double> by_drag = AirImpulse(area_time, n, v, w, moving.wind);
      for (int r = 0; r < 3; ++r) add(3 * i + r, kByAirDrag, (&by_drag.x)[r]);
      if (moving.air_drag == 0.0) continue;
      const auto impulse = AirImpulse(Dual<3>(FaceDrag(face, moving, step.h)), Constant<3>(n),
                                      Constant<3>(v), Constant<3>(w), wind);
      for (int r = 0; r < 3; ++r)
        for (int j = 0; j < 3; ++j) add(3 * i + r, kByWind + j, (&impulse.x)[r].v[j]);
    }
  }
}

// Calls add(row, entry, derivative) for what each number but the stiffness damping adds to the
// right-hand side.
template <class Add>
void ForEachNumber(const ClothModel& model, const MaterialField& material, const MovingStep& step,
                   const Add& add) {
  const double h = step.h, damped = 1.0 + h * material.dynamics.mass_damping;
  const Eigen::Vector3d gravity = model.scene.gravity.value_or(Eigen::Vector3d::Zero());
  for (int i = 0; i < model.num_dofs(); ++i) {
    const double area = model.vertex_area[i / 3];
    add(i, kByDensity, area * (step.v[i] - damped * step.w[i] + h * gravity[i % 3]));
    add(i, kByMassDamping, -h * material.density * area * step.w[i]);
  }
  ForEachAirNumber(model, material, step, add);
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
    const Vec3<double> n = FaceNormal(face, x);
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
  ForEachNumber(model, material, step,
                [&](int row, int entry, double derivative) { columns(row, entry) += derivative; });
  Eigen::VectorXd stiff = Eigen::VectorXd::Zero(model.num_dofs());
  AddElementStiffnessTimes(model, material, step.x, step.w, -step.h, stiff.data());
  columns.col(kByStiffnessDamping) = stiff;
  return columns;
}

DynamicsNumbers DynamicsAdjoint(const ClothModel& model, const MaterialField& material,
                                const MovingStep& step, const RowMatrix& lambda,
                                double stiffness_work) {
  DynamicsNumbers sums = DynamicsNumbers::Zero();
  ForEachNumber(model, material, step, [&](int row, int entry, double derivative) {
    sums[entry] += derivative * lambda(row, 0);
  });
  sums[kByStiffnessDamping] = -step.h * stiffness_work;
  return sums;
}

}  // namespace drape
