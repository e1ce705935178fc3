// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/outline.h"
#include "losses/photo/photo_options.h"

namespace drape {

// The silhouette of a photograph, and the camera that sees it.
struct PhotoResult {
  PhotoFault fault = PhotoFault::kNone;
  std::string reason;                 // one line, where there is a fault
  std::vector<std::string> warnings;  // one sentence each
  RgbImage overlay;                   // the photograph with what was found, also with a fault

  // Nothing of the following with a fault.
  GrayImage silhouette;  // as a pinhole that looks straight down sees it, from where the camera was
  Camera camera;         // that pinhole; orthographic without a marker
  GrayImage projected;   // estimated vertical projection, for the camera of the published images
  ShapeFeatures shape;   // of that projection (VerticalProfile)
  double coefficient_sd = 0.0;     // standard deviation of its drape coefficient
  double plane_coefficient = 0.0;  // drape coefficient without a model of the camera, as if the
                                   // drape were flat
  Eigen::Vector2d tilt{0.0, 0.0};  // of the camera, as PhotoPose::tilt [rad]
  double focal = 0.0;              // [px of the photograph]
  double marker_rms = 0.0;         // of the rim or the tag's corners from the model [px]
  double marker_share = 0.0;       // of the rim that is seen
  double blur = 0.0;               // standard deviation of the outline's blur [m]
  double contrast = 0.0;           // of cloth and ground, median along the outline [CIE Lab units]
};

// Finds the cloth, the marker and the camera in a photograph, turns the picture so that the camera
// looks straight down (the homography K R K⁻¹, which holds at every height), and measures the
// outline. A photograph that cannot be measured gives a fault; options that contradict one another
// throw InputError. Errors on rendered photographs: tests/bench/PHOTOS.md.
PhotoResult MeasurePhoto(const Photograph& photo, const PhotoOptions& options);

}  // namespace drape
