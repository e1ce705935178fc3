// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/util/options/enum_names.h"

namespace drape {

// Where the support's centre is in an image.
enum class CentreMode {
  kNominal,  // at the image's centre, or where the user says
  kOutline   // where the outline has no first harmonic: the published images are off by up to 11 px
};
constexpr auto EnumNames(CentreMode) {
  return MakeNames<CentreMode>(
      {{CentreMode::kNominal, "nominal"}, {CentreMode::kOutline, "outline"}});
}

// Moves the camera to the point about which the outline of the image has no first harmonic, Σ r(θ)
// e^{iθ} = 0. This point is the centre of the support in an image of a drape whose folds favour no
// side. The centres of the published images deviate from the nominal one by up to 11 px (median 2).
// The search starts at the camera's centre. Returns false when the outline is not complete; the
// camera may then have moved.
bool CentreOnOutline(const GrayImage& image, Camera* camera);

// Moves the camera's centre to the centroid of the coverage where it is farther from it than a
// third of the cloth's mean radius: from there the outline may not be seen as a whole. No published
// image is off by more than a fifth.
void CentreOnFarCloth(const GrayImage& image, Camera* camera);

}  // namespace drape
