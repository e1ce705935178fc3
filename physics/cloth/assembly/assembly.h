// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Adds the small matrices of elements to a block matrix, for the loops of assembly: the rows of the
// corners whose bit is set.

using Matrix6 = double[6][6];  // over the columns of F, as StretchStepDerivative orders them

// The block is contiguous and comes from a local array without aliases, which makes two or three
// vector instructions.
inline void AddBlock(const double (&block)[9], double* out) {
  for (int i = 0; i < 9; ++i) out[i] += block[i];
}

// Adds scale·[Du Dv]ᵀ·Q·[Du Dv] to the nine blocks of a face.
inline void AddFaceBlocks(const Face& face, const Matrix6& Q, double scale, const int* blocks,
                          BlockMatrix& A, unsigned corners = ~0U) {
  const ShapeGradient s = GradientOf(face);
  double part[2][2][9];  // Q's blocks uu uv, vu vv
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) part[i / 3][k / 3][3 * (i % 3) + k % 3] = scale * Q[i][k];
  for (int a = 0; a < 3; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    double row_u[9], row_v[9];
    for (int i = 0; i < 9; ++i) {
      row_u[i] = s.u[a] * part[0][0][i] + s.v[a] * part[1][0][i];
      row_v[i] = s.u[a] * part[0][1][i] + s.v[a] * part[1][1][i];
    }
    for (int b = 0; b < 3; ++b) {
      double block[9];
      for (int i = 0; i < 9; ++i) block[i] = s.u[b] * row_u[i] + s.v[b] * row_v[i];
      AddBlock(block, A.block(blocks[3 * a + b]));
    }
  }
}

inline void AddHingeBlocks(const double (&Q)[12][12], const int* blocks, BlockMatrix& A,
                           unsigned corners = ~0U) {
  for (int a = 0; a < 4; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    for (int b = 0; b < 4; ++b) {
      double block[9];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) block[3 * i + k] = Q[3 * a + i][3 * b + k];
      AddBlock(block, A.block(blocks[4 * a + b]));
    }
  }
}

// Adds scale·d·dᵀ to the sixteen blocks of a hinge.
inline void AddHingeBlocks(const HingeGradient& gradient, double scale, const int* blocks,
                           BlockMatrix& A, unsigned corners = ~0U) {
  for (int a = 0; a < 4; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    const Vec3<double> row = scale * gradient.d[a];
    for (int b = 0; b < 4; ++b) {
      const Vec3<double>& d = gradient.d[b];
      AddBlock({row.x * d.x, row.x * d.y, row.x * d.z, row.y * d.x, row.y * d.y, row.y * d.z,
                row.z * d.x, row.z * d.y, row.z * d.z},
               A.block(blocks[4 * a + b]));
    }
  }
}

// What one of several threads adds up: all that the elements add at the vertices of its own part of
// the mesh. Elements across a border of parts are computed once for each part. Each sum has the
// order that it has without parts, and the same bits.
struct AssemblyPart {
  struct Element {
    int index;
    unsigned corners;  // bit a: whether corner a is of this part
  };
  std::vector<Element> faces, hinges;  // ascending
};

// Parts with about as many vertices each, ≥ 1.
std::vector<AssemblyPart> SplitAssembly(const Mesh& mesh, int parts);

// Sums of the element kernels over a cloth. x and w have shape [3V]. Everything about a step
// follows from g(x; w) = h·f(x) − h²·H(x)·w [MODEL, M31]: the step solves (M + h²H)·v' = M·v + h·f
// [MODEL, M30].
// self: the contact of the cloth with itself, which keeps what it finds for the next shape; null:
// it is found again. Scenes without it take none.
// parts: of the mesh, a thread each; empty: one thread.
using AssemblyParts = std::vector<AssemblyPart>;

// Computes f(x) [N], shape [3V].
void AssembleForce(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                   Eigen::VectorXd& force, SurfaceContact* self = nullptr,
                   const AssemblyParts& parts = {});

// Computes f(x) [N], shape [3V], and A = M + h²·H(x) [kg], with the damping of material.dynamics
// (1 + hα)·M + h²·H + hβ·H of the elements [MODEL, M64]. CHECKs here and below that the pattern
// has the blocks of pairs that touch.
void AssembleStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                  double h, Eigen::VectorXd& force, BlockMatrix& A, SurfaceContact* self = nullptr,
                  const AssemblyParts& parts = {});

// The velocity by which elements that are damped by their stiffness enter g: their part h²·H·w
// grows to (h² + hβ)·H·w, which is h²·H times (1 + β/h)·w [MODEL, M64]. Without this damping it is
// w itself, which outlives it.
class DampedVelocity {
 public:
  DampedVelocity(const MaterialField& material, const Eigen::VectorXd& w, double h);
  DampedVelocity(const DampedVelocity&) = delete;
  DampedVelocity& operator=(const DampedVelocity&) = delete;
  const double* data() const { return data_; }  // [3V]

 private:
  Eigen::VectorXd scaled_;
  const double* data_;
};

// Computes ∂g/∂x with w held [kg/s] [MODEL, M39]. With w = 0 and h = 1 it is ∂f/∂x = −K, the exact
// stiffness of statics [N/m] [MODEL, M33]. Where the cloth touches itself, that is all there is:
// the change of its H with x is left out.
void AssembleStepDerivative(const ClothModel& model, const MaterialField& material,
                            const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                            BlockMatrix& derivative, SurfaceContact* self = nullptr,
                            const AssemblyParts& parts = {});

// The second Piola–Kirchhoff stress of each face at x [N/m], shape [F]; empty in a scene without
// stretch.
using StressField = std::vector<StretchStress<double>>;
StressField MembraneStress(const ClothModel& model, const MaterialField& material,
                           const Eigen::VectorXd& x);
// The stress to first order in dx: S(x) + ∂S/∂x·dx [MODEL, M34]. A rotation along dx does not
// strain it, whereas it strains S(x + dx) by ½|dx|².
StressField ExtrapolatedMembraneStress(const ClothModel& model, const MaterialField& material,
                                       const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
// Adds ∫S:∂²G/∂x² [N/m], the contribution of the stress S to the stiffness.
void AddGeometricStiffness(const ClothModel& model, const StressField& stress, BlockMatrix& K);

// The energy [J]: exact for gravity, handles, loads and bending [MODEL, M15]; for stretch see
// StretchEnergy.
double Energy(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
              SurfaceContact* self = nullptr);

// The energy of stretch and bend by unit of each entry of one table for the whole cloth: they are
// linear in the entries as long as these are not negative. 24 of stretch [m], then 15 of bend [1],
// shape [39]; zero for what the scene has not.
Eigen::VectorXd EnergyByEntry(const ClothModel& model, const Eigen::VectorXd& x);

// Contact of the cloth with itself as a scene has it [MODEL, M62].

bool HasSelfContact(const Scene& scene);
// CHECKs that the scene has it.
SurfaceContact MakeSelfContact(const ClothModel& model);
// Throws InputError where thickness and range together are more than the mean edge: neighbours
// would touch. Nothing where the scene has no such contact.
void RequireThinCloth(const ClothModel& model);

// Where a cloth overlaps itself: two faces meet, by exact predicates, or two parts are not further
// apart than the cloth is thick.
struct SelfOverlap {
  std::array<int, 2> vertex;  // one of each part
  double distance = 0.0;      // of the parts, 0 where faces meet [m]
};
// The first; none where the scene has no such contact.
std::optional<SelfOverlap> FindSelfOverlap(const ClothModel& model, const Eigen::VectorXd& x);

// The smallest gap of the pairs that push [m]; the range of the contact if no pair does.
double SmallestSelfGap(const ClothModel& model, const Eigen::VectorXd& x);

// `to`, or as much of the way there as no part of the cloth passes through another: shapes that are
// extrapolated can overlap. The shape `from` does not.
Eigen::VectorXd ReachSafely(const ClothModel& model, const Eigen::VectorXd& from,
                            const Eigen::VectorXd& to);

}  // namespace drape
