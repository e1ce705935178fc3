// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material.h"

namespace drape {

struct ScaleFactors {
  double stretch = 1.0;  // on all stretch entries
  double bend = 1.0;     // on all bend entries
  bool operator==(const ScaleFactors&) const = default;
};

// `material` with all stretch entries times stretch, all bend entries times bend.
MaterialField Scaled(MaterialField material, double stretch, double bend);

}  // namespace drape
