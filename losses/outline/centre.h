// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

// The camera moved to where the image's outline has no first harmonic, Σ r(θ) e^{iθ} = 0: there the
// support's centre is in an image of a drape whose folds do not favour a side. The published images
// are off their nominal centre by up to 10 px (median 2). False when the outline is not complete.
bool CentreOnOutline(const GrayImage& image, Camera* camera);

}  // namespace drape
