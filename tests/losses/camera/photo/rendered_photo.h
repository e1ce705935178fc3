// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "losses/image/image.h"
#include "physics/mesh/mesh.h"

namespace drape {

using Rgb = Eigen::Vector3d;  // 0 … 1, as stored (sRGB)

// A scene that is rendered as a telephone would take it: a drape under a disc, above a table.
struct PhotoScene {
  int width = 1600, height = 1200;  // [px]
  double focal_35mm = 26.0;
  Eigen::Vector3d eye{0.03, -0.02, 1.0};  // [m]
  Eigen::Vector2d tilt{0.0, 0.0};         // [rad], as PhotoPose::tilt
  Rgb cloth{0.25, 0.3, 0.6}, ground{0.8, 0.79, 0.76}, disc{0.9, 0.9, 0.88};
  double ground_height = -0.25;  // [m]
  bool has_disc = true;
  double disc_radius = 0.09, disc_height = 0.0;  // [m]
  double tag_side = 0.0;                         // [m] 0: none; id 7 of family 36h11
  Eigen::Vector3d tag_place{0.0, 0.0, 0.001};    // of its centre [m]
  Eigen::Vector2d light{0.25, 0.15};             // x and y of where the light comes from, z = 1
  double shadow = 0.35;   // share of the light that the shadow on the ground lacks
  double falloff = 0.15;  // of the light from one side of the picture to the other
  double texture = 0.02;  // of cloth and ground, standard deviation
  double noise = 0.012;   // of a channel, standard deviation
  double blur = 0.7;      // standard deviation [px]
  double motion = 0.0;    // length of a shake along the rows [px]
  double exposure = 1.0;
  double glare = 0.0;  // radius of a highlight on the cloth's edge [m]
  int jpeg_quality = 90;
  int orientation = 1;  // EXIF, of how the camera was held
  bool has_exif = true;
  unsigned seed = 1;
};

// One piece of cloth in a scene.
struct ScenePiece {
  const Mesh* mesh;
  Eigen::VectorXd x;                                // [m], shape [3V]
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // where its axis is [m]
};

RgbImage RenderPhoto(const PhotoScene& scene, const std::vector<ScenePiece>& pieces);
// The file that a telephone would write of a picture: turned as it was held, with EXIF data.
std::vector<uint8_t> PhotoFile(const PhotoScene& scene, const RgbImage& image);

// A scene of a colourful laboratory, of that number.
PhotoScene RandomScene(unsigned number);

}  // namespace drape
