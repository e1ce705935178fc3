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
  double factor() const { return factor_; }     // of data over w

 private:
  double factor_;
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

// What the elements of a cloth contribute at a shape, from which force, energy, stress and exact
// stiffness follow: each law is evaluated once.
struct ElementStates {
  struct OfFace {
    StretchStress<Dual<3>> stress;  // second Piola–Kirchhoff stress and ∂S/∂G [N/m]
    double energy;                  // [J]; see StretchEnergy
  };
  struct OfHinge {
    double moment, slope;  // minus its moment, and the derivative by the angle [N·m]
    double energy;         // [J]
  };
  std::vector<OfFace> faces;    // [F]; empty in a scene without stretch
  std::vector<OfHinge> hinges;  // [E]; empty in a scene without bending
};
// Computes f(x) as AssembleForce does, and what it follows from.
ElementStates EvaluateElements(const ClothModel& model, const MaterialField& material,
                               const Eigen::VectorXd& x, Eigen::VectorXd& force,
                               SurfaceContact* self = nullptr, const AssemblyParts& parts = {});

// A stress of each face [N/m], shape [F]; empty in a scene without stretch.
using StressField = std::vector<StretchStress<double>>;
StressField MembraneStress(const ElementStates& states);
// The stress to first order in dx: S(x) + ∂S/∂x·dx [MODEL, M34]. A rotation along dx does not
// strain it, whereas it strains S(x + dx) by ½|dx|².
StressField ExtrapolatedMembraneStress(const ClothModel& model, const ElementStates& states,
                                       const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
// Adds ∫S:∂²G/∂x² [N/m], the contribution of the stress S to the stiffness.
void AddGeometricStiffness(const ClothModel& model, const StressField& stress, BlockMatrix& K);
// Computes ½(K + Kᵀ), K = −∂f/∂x [N/m], with the geometric stiffness of another stress than that of
// the states, which are those at x. part: of pairs of the cloth that touch.
void AssembleStiffness(const ClothModel& model, const ElementStates& states,
                       const StressField& stress, const Eigen::VectorXd& x, StiffnessPart part,
                       BlockMatrix& K, SurfaceContact* self = nullptr,
                       const AssemblyParts& parts = {});

// The energy [J]: exact for gravity, handles, loads and bending [MODEL, M15]; for stretch see
// StretchEnergy. states: at x.
double Energy(const ClothModel& model, double density, const ElementStates& states,
              const Eigen::VectorXd& x, SurfaceContact* self = nullptr);
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
