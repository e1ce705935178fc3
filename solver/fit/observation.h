// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "physics/cloth/state.h"

namespace drape {

// One silhouette of a drape, as it was photographed.
struct Observation {
  std::string name;  // file name without folder and extension
  std::string file;
  GrayImage image;
  Camera camera;           // its centre is the support's centre in this image
  Eigen::VectorXd radius;  // outline r(θ) of the image [px of outline_camera()], shape [K]
  DrapeDiscs discs;        // of the drape
  ImageQuality quality;    // how far the silhouette can be trusted, and what was done to it
  std::optional<PhotographNotes> photograph;  // from which the silhouette is, by the camera's file

  // The camera at the scale of the published images, in whose pixels (1.39 mm) a fit compares
  // outlines: σ and the errors of a fit are lengths, whatever the resolution of the image.
  Camera outline_camera() const;
  // The image's outline at `angles` angles, in those pixels; nothing when it is not closed.
  std::optional<Eigen::VectorXd> MeasureRadius(int angles) const;
};

// Shapes [m], each of shape [3V], as states without velocity.
inline std::vector<State> AtRest(const std::vector<Eigen::VectorXd>& shapes) {
  std::vector<State> states;
  for (const Eigen::VectorXd& x : shapes) states.push_back({x, Eigen::VectorXd::Zero(x.size())});
  return states;
}

}  // namespace drape
