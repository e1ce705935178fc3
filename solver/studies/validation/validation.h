// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/validation/reference_case.h"

namespace drape {

// Our stiffness against textbooks: closed forms and published figures [MODEL, M53–M59], each on
// the built-in meshes at three resolutions.

struct ValidationOptions {
  std::string law = "smooth";
  std::vector<std::string> only;  // groups; empty: all
};

//  rigidity    D that a mesh makes of a bend table B = 4·D, on discs and strips
//  cantilever  drop over reach of a strip under its weight, Γ = ρgL³/EI [Romero 2021], and
//              the 41.5° of [ASTM D1388] at Γ = 8.0042
//  tip_load    the elastica with a load on its tip [Bisshopp 1945], [Mattiasson 1981]
//  hanging     ΔL/L = ρgL/2k
//  uniaxial    N = k(l² − 1)l/2
//  disc        clamped plate, w0 = q·a⁴/(64·D) [Timoshenko 1959]
//  annulus     the drape test of a stiff cloth, clamped at .6 and .4 of its radius
//  rigid       rigid motions cause no net force or torque
//  turn        a quarter turn of the material exchanges c11 and c22
std::vector<std::string> ValidationGroups();

// A cancelled run ends after the group in progress. Throws InputError for an unknown group or law.
std::vector<ReferenceCase> Validate(const ValidationOptions& options,
                                    const RunControl& control = {});

bool AllPass(const std::vector<ReferenceCase>& cases);

}  // namespace drape
