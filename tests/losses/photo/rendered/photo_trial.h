// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/photo/photo.h"
#include "tests/losses/photo/rendered/rendered_photo.h"

namespace drape {

// A drape of a known fabric, from the simulator on a small mesh.
struct KnownDrape {
  std::string name;
  Mesh mesh;
  Eigen::VectorXd x;         // [m], shape [3V]
  double coefficient = 0.0;  // ComputeCoefficient
};
// The drape coefficient by the area of the vertical projection of the whole cloth.
double ComputeCoefficient(const Mesh& mesh, const Eigen::VectorXd& x);
KnownDrape SimulateDrape(const std::string& fabric, int seed);
// A drape of 41 % that tests share.
const KnownDrape& Wool();
// One of the drapes of six fabrics, from soft to stiff.
constexpr unsigned kNumDrapes = 6;
KnownDrape SimulateDrapeOfSix(unsigned number);

// How a photograph of a known drape was measured. Drape coefficients in points (percent).
struct PhotoTrial {
  PhotoResult result;
  double outline_rms = 0.0;     // of the silhouette from the drape seen by the camera found [px]
  double outline_bias = 0.0;    // mean from the drape seen by the true camera, positive where the
                                // outline is too large [px]
  double outline_rms_mm = 0.0;  // the same in the support plane
  double error_of_estimate = 0.0;  // of the coefficient, as drape_photo tells it: the sum of …
  double error_by_outline = 0.0;   // … that of the outline in the photograph, …
  double error_by_camera = 0.0;    // … of the camera that was found, …
  double error_by_heights = 0.0;   // … and of the hem's estimated heights
  double error_of_plane = 0.0;     // without a model of the camera
  double tilt_error = 0.0;         // [rad]
  double height_error = 0.0;       // of the eye, relative
};
PhotoTrial TryPhoto(const PhotoScene& scene, const KnownDrape& drape, const PhotoOptions& options,
                    const std::string& folder);

}  // namespace drape
