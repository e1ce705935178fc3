// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "losses/image/image.h"
#include "physics/mesh/mesh.h"

namespace drape {

using Rgb = Eigen::Vector3d;  // 0 … 1, as stored (sRGB)

// Something flat beside or on the cloth: a convex polygon [m].
struct ScenePatch {
  Rgb color;
  std::vector<Eigen::Vector3d> corners;
};

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
  Eigen::Vector2d disc_place{0.0, 0.0};          // from the support's axis [m]
  double tag_side = 0.0;                         // [m] 0: none; id 7 of family 36h11
  Eigen::Vector3d tag_place{0.0, 0.0, 0.001};    // of its centre [m]
  Eigen::Vector2d light{0.25, 0.15};             // x and y of where the light comes from, z = 1
  double shadow = 0.35;   // share of the light that the shadow on the ground lacks
  double soft = 0.03;     // width of the shadow's edge [m]
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
  double distortion = 0.0;  // k1: a point at r focal lengths from the axis is seen at r(1 + k1 r²)
  double tone = 0.0;        // contrast that the camera adds to stored values, 0 … 1
  Rgb stripe{0, 0, 0};      // second colour of the cloth
  double stripes = 0.0;     // their width [m]; 0: plain
  std::vector<ScenePatch> patches;
};

// One piece of cloth in a scene.
struct ScenePiece {
  const Mesh* mesh;
  Eigen::VectorXd x;                                // [m], shape [3V]
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // where its axis is [m]
};

// What the camera stores. Shadows, lens and pixels multiply and mix light, not stored numbers.
RgbImage RenderPhoto(const PhotoScene& scene, const std::vector<ScenePiece>& pieces);
// A scene of a colourful laboratory, of that number.
PhotoScene RandomScene(unsigned number);
// One of 1000 × 750 px, 1.1 px/mm.
PhotoScene SmallScene();
// The grey level of each pixel.
std::vector<uint8_t> GreyLevels(const RgbImage& image);

}  // namespace drape
