// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "physics/util/options/enum_names.h"

namespace drape {

// A fabric as other simulators take it: one stiffness for all strains and curvatures
// [METHODS, P70]. Directions are those of a laboratory: bending along the weft is that of hinges
// whose edges lie along the warp, row 2 of a bend table; bending along the warp is row 0.
struct LinearFabric {
  double c11 = 0.0, c22 = 0.0, c12 = 0.0;  // membrane stiffness: weft, warp, coupling [N/m]
  double shear = 0.0;                      // G = c33/2, by the angle of shear [N/m]
  double bend_weft = 0.0, bend_warp = 0.0, bend_bias = 0.0;  // rigidity D of the hinges [N·m]
  double density = 0.0;                                      // [kg/m²]
};

// The tangent of the tables at zero strain and the rigidity at zero curvature, as the law sees
// them. `tables` has one table of each kind.
LinearFabric LineariseAtRest(const MaterialField& tables, const Law& law);

// The same membrane, and for each direction the rigidity that has the same bending energy in the
// drapes of `weights` (StiffnessWeights, shape [39]); a direction in which they do not bend keeps
// its rigidity at zero curvature.
LinearFabric LineariseInDrape(const MaterialField& tables, const Law& law,
                              const Eigen::VectorXd& weights);

// The tables that mean the same here: constant over strain and curvature.
MaterialField TablesFrom(const LinearFabric& material);

// The mean rigidity over all directions of the hinges, which is that of an isotropic sheet [N·m].
double MeanRigidity(const LinearFabric& material);

// What an isotropic sheet keeps of a fabric that is not: of its two numbers, or the least
// difference of both.
enum class IsotropicChoice { kNearest, kShear, kStretch };
constexpr auto EnumNames(IsotropicChoice) {
  return MakeNames<IsotropicChoice>({{IsotropicChoice::kNearest, "nearest"},
                                     {IsotropicChoice::kShear, "shear"},
                                     {IsotropicChoice::kStretch, "stretch"}});
}

// The Lamé numbers of a sheet by length of section [N/m]: c11 = c22 = λ + 2μ, c12 = λ, G = μ.
struct IsotropicSheet {
  double mu = 0.0, lambda = 0.0;
};
// kNearest: the least squares over the entries of the stiffness tensor, with c12 and G counted
// twice and four times. kShear: mean of c11 and c22, and G. kStretch: that mean, and c12. λ is at
// least 0, as the programs that take it expect.
IsotropicSheet MakeIsotropic(const LinearFabric& material, IsotropicChoice choice);
// `material` with the membrane of that sheet, and with its mean rigidity in all directions.
LinearFabric WithIsotropicMembrane(LinearFabric material, const IsotropicSheet& sheet);
LinearFabric WithMeanRigidity(LinearFabric material);

}  // namespace drape
