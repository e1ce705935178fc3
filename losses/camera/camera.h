// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "losses/camera/projection.h"
#include "physics/mesh/disc.h"
#include "physics/util/options/enum_names.h"

namespace drape {

struct GrayImage;

enum class CameraKind {
  kOrthographic,  // the projection of the published images, and the default
  kPinhole  // a photograph's, turned to look straight down (losses/camera/photo), or that of the
            // published code, which is for parity runs only [MODEL, M46]
};

constexpr auto EnumNames(CameraKind) {
  return MakeNames<CameraKind>(
      {{CameraKind::kOrthographic, "orthographic"}, {CameraKind::kPinhole, "pinhole"}});
}

// A camera above the support that looks straight down [MODEL, M46]. World: x right and y up in the
// image, z towards the camera, support plane z = 0 [m]. Image: (column, row), pixel centres at
// integers.
struct Camera {
  CameraKind kind = CameraKind::kOrthographic;
  int width = 256;             // [px]
  int height = 256;            // [px]
  double cx = 127.5;           // column of the world's origin, the support's centre [px]
  double cy = 127.5;           // row of it [px]
  double scale = 719.5;        // orthographic only [px/m]
  double eye_height = 0.7;     // pinhole only: z of the centre of projection [m]
  double field_of_view = 0.5;  // pinhole only: vertical [rad]
  double eye_x = 0.0;          // pinhole only: where above the support plane the centre of
  double eye_y = 0.0;          // projection is [m]

  // Throws InputError (prefix `where`) that names the first invalid field and its value.
  void Check(const std::string& where) const;

  double focal_length() const { return 0.5 * height / std::tan(0.5 * field_of_view); }  // [px]

  Projection projection() const {
    const bool pinhole = kind == CameraKind::kPinhole;
    return {pinhole,
            cx,
            cy,
            scale,
            eye_height,
            focal_length(),
            pinhole ? eye_x : 0.0,
            pinhole ? eye_y : 0.0};
  }

  // Magnification of the plane at height z [px/m].
  template <typename T>
  T PixelsPerMetre(const T& z) const {
    return projection().PixelsPerMetre(z);
  }
  double pixels_per_metre() const { return PixelsPerMetre(0.0); }  // in the support plane

  // Maps x [m], shape [3], to the image point (column, row) [px], shape [2]. T is double or any
  // dual number. A pinhole needs z < eye_height.
  template <typename T>
  void Project(const T x[3], T image[2]) const {
    projection().Project(x, image);
  }

  // The point of the plane at height z [m] that is seen at an image point (column, row) [px].
  Eigen::Vector2d WorldFromImage(const Eigen::Vector2d& image, double z) const {
    const double s = PixelsPerMetre(z), parallax = pixels_per_metre() - s;
    const bool pinhole = kind == CameraKind::kPinhole;
    return {(image.x() - cx - (pinhole ? parallax * eye_x : 0.0)) / s,
            (cy - image.y() - (pinhole ? parallax * eye_y : 0.0)) / s};
  }

  // ∂image/∂x [px/m], shape [2, 3].
  Eigen::Matrix<double, 2, 3> ImageFromWorldJacobian(const double x[3]) const;
};

// The camera of the published images, in which a flat specimen fills 84 % of the picture; larger,
// at the same scale, for a larger specimen.
Camera CameraAbove(const DrapeDiscs& discs);

// Projects all vertices: x [m], node-major, shape [3V] → image_points [px], shape [2, V]. Returns
// false when a coordinate is not finite or a vertex is not in front of the camera.
bool ProjectVertices(const Eigen::VectorXd& x, const Camera& camera,
                     Eigen::Matrix2Xd* image_points);

// Calibrates an orthographic camera from an image of a flat circle of known radius [m]: centre =
// centroid of the coverage, scale = sqrt(area/π)/radius. Throws InputError (prefix `where`) when
// the silhouette is not plausible (SegmentSilhouette) or when its second moment is not that of a
// circle.
Camera CalibrateFromCircle(const GrayImage& image, double radius, const std::string& where);

// Returns positions, shape [3V], mirrored (y → −y) if requested and then turned about z
// counter-clockwise by `rotation` [rad].
Eigen::VectorXd TurnedAboutZ(const Eigen::VectorXd& x, double rotation, bool mirrored = false);

}  // namespace drape
