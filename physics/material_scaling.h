// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material.h"

namespace drape {

// `material` with all stretch entries times stretch, all bend entries times bend.
MaterialField Scaled(MaterialField material, double stretch, double bend);

}  // namespace drape
