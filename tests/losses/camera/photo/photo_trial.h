// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/photo/photo.h"
#include "tests/losses/camera/photo/rendered_photo.h"

namespace drape {

// A drape of a known fabric, from the simulator on a small mesh.
struct KnownDrape {
  std::string name;
  Mesh mesh;
  Eigen::VectorXd x;         // [m], shape [3V]
  double coefficient = 0.0;  // of its vertical projection
};
KnownDrape SimulateDrape(const std::string& fabric, int seed);
// One of the drapes of six fabrics, from soft to stiff.
constexpr unsigned kNumDrapes = 6;
KnownDrape SimulateDrapeOfSix(unsigned number);

// How a photograph of a known drape was measured. Drape coefficients in points (percent).
struct PhotoTrial {
  PhotoResult result;
  double outline_rms = 0.0;     // of the silhouette from the drape seen by the camera found [px]
  double outline_bias = 0.0;    // mean of the same, positive where the outline is too large
  double outline_rms_mm = 0.0;  // the same in the support plane
  double error_with_heights = 0.0;  // of the coefficient by the outline and the hem's known heights
  double error_of_estimate = 0.0;   // by the estimated heights, as drape_photo tells it
  double error_of_plane = 0.0;      // without a model of the camera
  double tilt_error = 0.0;          // [rad]
  double height_error = 0.0;        // of the eye, relative
};
PhotoTrial TryPhoto(const PhotoScene& scene, const KnownDrape& drape, const PhotoOptions& options,
                    const std::string& folder);

}  // namespace drape
