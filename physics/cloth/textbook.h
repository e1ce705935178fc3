// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"
#include "physics/mesh/mesh.h"

namespace drape {

// What textbooks calculate with, in terms of our tables and meshes.

// Poisson ratio of bending by the hinge formula (mesh_rigidity_test).
inline constexpr double kHingePoisson = -1.0 / 3.0;

// One stiffness for all strains and directions: membrane stiffness `k` [N/m] without Poisson
// coupling, plate rigidity `D` [N·m], density [kg/m²].
MaterialField LinearMaterial(double k, double D, double density);

// The linear material that bends as a beam of rigidity `EI` a width [N·m] where it is free to
// curl across, as in a narrow strip: D·(1 − ν²) = EI.
MaterialField LinearBeam(double k, double EI, double density);

// The tables of the same cloth with u and v exchanged by a quarter turn.
MaterialField TurnedByQuarter(MaterialField material);

// Rigidity of a flat mesh per plate rigidity D when all hinges are bent to the surface with this
// symmetric curvature [2, 2]: 2·energy/(D·area) by B = 4·D and W = B·l²θ²/(8(A0+A1)), written out
// here apart from the force law. 1 about one axis and 2(1 + ν) for a dome, but for free edges,
// which bear no hinges.
double CurvatureRigidity(const Mesh& mesh, const Eigen::Matrix2d& curvature);
// The same for curvature 1 along u when the mesh is free to curl across and to twist.
double BeamRigidity(const Mesh& mesh);

// Γ = ρgL³/EI at which the chord of a heavy cantilever (clamped horizontally, inextensible) falls
// `chord` below the horizontal [rad], 0 < chord < π/2: 8.0042 at the 41.5° of ASTM D1388, so that
// the bending length L/Γ^(1/3) is half the overhang there. Peirce's closed formula
// (cos(θ/2)/(8·tan θ))^(1/3)·L [Peirce 1930] is 1.9 % larger at 41.5°. CHECKs the range.
double HeavyElasticaGamma(double chord);

// Plate rigidity D [N·m] that a bend table gives a cloth bent along `direction` to the weft [rad]
// where it is hardly curved: its hinges lie in all directions φ and bear sin⁴(φ − direction) of it.
double DirectionalRigidity(const BendTable& table, double direction);

// Mean of x − x_rest over the vertices with the largest u.
Eigen::Vector3d TipMove(const Mesh& mesh, const Eigen::VectorXd& x);

}  // namespace drape
