// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material.h"
#include "physics/mesh.h"

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

// Mean of x − x_rest over the vertices with the largest u.
Eigen::Vector3d TipMove(const Mesh& mesh, const Eigen::VectorXd& x);

}  // namespace drape
