// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/dataset/dataset.h"
#include "solver/fit/observation.h"

namespace drape {

// Where the support's centre is in an image.
enum class CentreMode {
  kNominal,  // the image's centre
  kOutline   // where the outline has no first harmonic: the published images are off by up to 10 px
};
// "nominal" or "outline". Throws InputError for any other.
CentreMode ParseCentreMode(const std::string& text);

// What of a capture of the public data set is fitted.
enum class ObservationSource {
  kSilhouettes,
  kMeshes  // the outline of its published mesh: the mesh's z says nothing more [METHODS, P11]
};
// "silhouettes" or "meshes". Throws InputError for any other.
ObservationSource ParseObservationSource(const std::string& text);
const char* ToString(ObservationSource source);

struct ObservationOptions {
  CameraKind camera = CameraKind::kOrthographic;
  CentreMode centre = CentreMode::kOutline;
  int angles = 90;  // K of r(θ)
};

// An image of a drape, or what the camera sees of a published mesh, which has been turned onto its
// image (KeepUsable); its name is the file's, or "sample_2_capture_1_up". Throws InputError for a
// file that cannot be read or has no closed outline around the support's centre.
Observation ReadImageObservation(const std::string& file, const ObservationOptions& options);
Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   const ObservationOptions& options);

}  // namespace drape
