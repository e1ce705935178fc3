// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/dataset/dataset.h"
#include "physics/util/options/enum_names.h"
#include "physics/util/options/field.h"
#include "solver/fit/observation.h"

namespace drape {

constexpr auto EnumNames(CameraKind) {
  return MakeNames<CameraKind>(
      {{CameraKind::kOrthographic, "orthographic"}, {CameraKind::kPinhole, "pinhole"}});
}

// Where the support's centre is in an image.
enum class CentreMode {
  kNominal,  // the image's centre
  kOutline   // where the outline has no first harmonic: the published images are off by up to 10 px
};
constexpr auto EnumNames(CentreMode) {
  return MakeNames<CentreMode>(
      {{CentreMode::kNominal, "nominal"}, {CentreMode::kOutline, "outline"}});
}

// What of a capture of the public data set is fitted.
enum class ObservationSource {
  kSilhouettes,
  kMeshes  // the outline of its published mesh, whose z has no further information [METHODS, P11]
};
constexpr auto EnumNames(ObservationSource) {
  return MakeNames<ObservationSource>(
      {{ObservationSource::kSilhouettes, "silhouettes"}, {ObservationSource::kMeshes, "meshes"}});
}

struct ObservationOptions {
  CameraKind camera = CameraKind::kOrthographic;
  CentreMode centre = CentreMode::kOutline;
  int angles = 90;  // K of r(θ)
};

template <MutableOrConst<ObservationOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [camera, centre, angles] = options;
  visit(camera, Field{.key = "camera", .doc = "the published images are orthographic projections"});
  visit(centre, Field{.key = "centre",
                      .doc = "where the support's centre is: at the image's centre, or found from "
                             "the outline"});
  visit(angles, Field{.key = "angles",
                      .doc = "number of rays at which the outline is compared",
                      .least = 31,
                      .most = 3600});
}

// An image of a drape, or what the camera sees of a published mesh, which has been turned onto its
// image (KeepUsable); its name is the file's, or "sample_2_capture_1_up". Throws InputError for a
// file that cannot be read or has no closed outline around the support's centre.
Observation ReadImageObservation(const std::string& file, const ObservationOptions& options);
Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   const ObservationOptions& options);

}  // namespace drape
