// SPDX-License-Identifier: Apache-2.0
// Compiled by nvcc only, never run: the element headers hold nothing that a device cannot do. Each
// kernel instantiates every element function of a law in double, and the laws in Dual and float.
#include "physics/laws_reference.h"
#include "physics/laws_smooth.h"

namespace drape {

template <class Law, class T>
__device__ void Coefficients(const Law& law, const Face& face, const StretchTable& table,
                             const double* x, T* out) {
  const DeformationGradient<double> F = GatherColumns(face, x);
  const GreenStrain<T> G{T(Green(F).uu), T(Green(F).vv), T(Green(F).uv)};
  const StretchCoefficients<T> k = EvaluateStretch(law, G, table);
  out[0] = k.c11 + k.c12 + k.c22 + k.c33 + k.ramp_uu + k.ramp_vv;
}

template <class Law>
__global__ void StretchKernel(Law law, const Face* faces, const StretchTable* table, const double* x,
                              const double* w, double h, double* out, float* out_float,
                              Dual<3>* out_dual) {
  const int f = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  const Face& face = faces[f];
  const ShapeGradient shape = GradientOf(face);
  const DeformationGradient<double> F = GatherColumns(face, x), wF = GatherColumns(face, w);
  const auto k = EvaluateStretch(law, Green(F), *table);
  const auto force = StretchForce(k, F), Hw = StretchStiffnessTimes(k, F, wF);
  const auto unit = StretchStepForce(UnitStiffness(k, 1), F, wF, h);
  double Q[6][6], by_entry[kStretchRows][kStretchCols];
  StretchStepDerivative(law, F, *table, wF, h, Q);
  law.StiffnessByTable(k.G, *table, by_entry);
  AddTo(out, face.vertex[0], shape.u[0] * force.u + shape.v[0] * Hw.v + unit.u);
  out[f] += Q[1][2] + by_entry[1][2] + StretchEnergy(k);
  const StretchAdjoint adjoint = AdjStretchStep(law, F, *table, wF, h, wF);
  ScatterColumns(face, adjoint.adj_F, out);
  out[f] += adjoint.adj_stiffness[0];
  Coefficients(law, face, *table, x, out_float);
  Coefficients(law, face, *table, x, out_dual);
}

template <class Law>
__global__ void BendKernel(Law law, const Hinge* hinges, const BendTable* table, const double* x,
                           const double* w, double h, double* out, float* out_float) {
  const int e = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  const Hinge& hinge = hinges[e];
  const HingeCorners corners = GatherCorners(hinge, x), velocity = GatherCorners(hinge, w);
  const double theta = DihedralAngle(corners);
  const HingeGradient d = AngleGradient(EvaluateWings(corners));
  const double kappa = HingeStiffness(law, hinge, *table, theta);
  double Q[12][12], by_entry[kBendRows][kBendCols];
  BendStepDerivative(law, hinge, *table, corners, velocity, h, Q);
  HingeStiffnessByTable(law, hinge, *table, theta, by_entry);
  AddTo(out, hinge.vertex[0], StepMoment(kappa, theta, Dot(d, velocity), h) * d.d[0]);
  out[e] += Q[3][4] + by_entry[1][1] + BendEnergy(law, hinge, *table, theta);
  const BendAdjoint adjoint = AdjBendStep(law, hinge, *table, corners, velocity, h, velocity, theta);
  out[e] += adjoint.adj_x[0] + adjoint.adj_kappa;
  out_float[e] = HingeStiffness(law, hinge, *table, static_cast<float>(theta));
}

template __global__ void StretchKernel(ReferenceStretch, const Face*, const StretchTable*,
                                       const double*, const double*, double, double*, float*, Dual<3>*);
template __global__ void StretchKernel(SmoothStretch, const Face*, const StretchTable*, const double*,
                                       const double*, double, double*, float*, Dual<3>*);
template __global__ void BendKernel(ReferenceBend, const Hinge*, const BendTable*, const double*,
                                    const double*, double, double*, float*);
template __global__ void BendKernel(SmoothBend, const Hinge*, const BendTable*, const double*,
                                    const double*, double, double*, float*);

}  // namespace drape
