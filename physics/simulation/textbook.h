// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Quantities of textbooks, expressed in the tables and meshes of this model.

// Poisson ratio of bending by the hinge formula [MODEL, M3] (mesh_rigidity_test).
inline constexpr double kHingePoisson = -1.0 / 3.0;

// A material with one stiffness for all strains and directions: membrane stiffness `k` [N/m]
// without Poisson coupling, plate rigidity `D` [N·m], density [kg/m²].
MaterialField LinearMaterial(double k, double D, double density);

// The linear material that bends as a beam of rigidity `EI` by width [N·m] where it is free to curl
// across, as in a narrow strip: D·(1 − ν²) = EI [MODEL, M54].
MaterialField LinearBeam(double k, double EI, double density);

// The tables of the same cloth with u and v exchanged by a quarter turn [MODEL, M59].
MaterialField TurnedByQuarter(MaterialField material);

// Rigidity of a flat mesh relative to the plate rigidity when all hinges are bent to the surface
// with this symmetric curvature [1/m], shape [2, 2]: 2·energy/(D·area) by B = 4·D and W =
// B·l²θ²/(8(A0 + A1)), computed here independently of the force law. It is 1 for curvature about
// one axis and 2(1 + ν) for a dome [MODEL, M54], up to the effect of free edges, which have no
// hinges.
double CurvatureRigidity(const Mesh& mesh, const Eigen::Matrix2d& curvature);
// The same for curvature 1 along u of a mesh that is free to curl across and to twist.
double BeamRigidity(const Mesh& mesh);

// The load Γ = ρgL³/EI at which the chord of a heavy cantilever (clamped horizontally,
// inextensible) falls `chord` [rad] below the horizontal, 0 < chord < π/2 [MODEL, M53]. It is
// 8.0042 at the 41.5° of [ASTM D1388], where the bending length L/Γ^(1/3) is therefore half the
// overhang. The closed formula (cos(θ/2)/(8·tan θ))^(1/3)·L [Peirce 1930] is 1.9 % larger at 41.5°.
// CHECKs the range.
double HeavyElasticaGamma(double chord);

// The deflection of the rim of a stiff disc of radius b that lies clamped on a support of radius
// ratio·b under a small uniform load q: w·D/(q·b⁴), for 0 < ratio < 1 and a plate of Poisson ratio
// nu [Timoshenko 1959], [MODEL, M58]. CHECKs the range.
double AnnulusDeflection(double ratio, double nu);

// The plate rigidity D [N·m] that a bend table gives a hardly curved cloth bent along `direction`
// [rad] to the weft [MODEL, M8]: its hinges lie in all directions φ, and each contributes with the
// weight sin⁴(φ − direction).
double DirectionalRigidity(const BendTable& table, double direction);

// Mean of x − x_rest [m] over the vertices with the largest u. x [m], shape [3V].
Eigen::Vector3d TipMove(const Mesh& mesh, const Eigen::VectorXd& x);

}  // namespace drape
