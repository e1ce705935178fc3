// SPDX-License-Identifier: Apache-2.0
#include "physics/material_scaling.h"

namespace drape {

MaterialField Scaled(MaterialField material, double stretch, double bend) {
  for (StretchTable& table : material.stretch)
    for (auto& row : table.c)
      for (double& entry : row) entry *= stretch;
  for (BendTable& table : material.bend)
    for (auto& row : table.b)
      for (double& entry : row) entry *= bend;
  return material;
}

}  // namespace drape
