// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

// Moves the camera to the point about which the outline of the image has no first harmonic, Σ r(θ)
// e^{iθ} = 0. This point is the centre of the support in an image of a drape whose folds favour no
// side. The centres of the published images deviate from the nominal one by up to 10 px (median 2).
// Returns false when the outline is not complete; the camera may then have moved.
bool CentreOnOutline(const GrayImage& image, Camera* camera);

}  // namespace drape
