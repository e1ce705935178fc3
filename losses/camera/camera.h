// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/util/options/enum_names.h"

namespace drape {

// A point or vector of the image plane [px].
struct Vec2 {
  double x, y;
};

inline Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2 operator*(double s, const Vec2& a) { return {s * a.x, s * a.y}; }
inline bool operator==(const Vec2& a, const Vec2& b) { return a.x == b.x && a.y == b.y; }
inline double Dot(const Vec2& a, const Vec2& b) { return a.x * b.x + a.y * b.y; }
inline double Cross(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

// Column i of an array of shape [2, V].
inline Vec2 PointAt(const double* points, int i) { return {points[2 * i], points[2 * i + 1]}; }

// The projection of a Camera as plain numbers [MODEL, M46].
struct Projection {
  bool pinhole;
  double cx, cy;        // column and row of the world's origin, the support's centre [px]
  double scale;         // orthographic only [px/m]
  double eye_height;    // pinhole only [m]
  double focal;         // pinhole only [px]
  double eye_x, eye_y;  // pinhole only: of the centre of projection [m]

  // Magnification of the plane at height z [px/m].
  template <typename T>
  T PixelsPerMetre(const T& z) const {
    return pinhole ? T(focal) / (T(eye_height) - z) : T(scale);
  }
  // Maps x [m], shape [3], to the image point (column, row) [px], shape [2].
  template <typename T>
  void Project(const T x[3], T image[2]) const {
    const T s = PixelsPerMetre(x[2]);
    const T parallax = PixelsPerMetre(T(0)) - s;
    image[0] = T(cx) + s * x[0] + parallax * T(eye_x);
    image[1] = T(cy) - s * x[1] - parallax * T(eye_y);
  }
  // ∂image/∂x [px/m], shape [2, 3].
  void Jacobian(const double x[3], double jacobian[2][3]) const {
    const double s = PixelsPerMetre(x[2]);
    const double ds_dz = pinhole ? s / (eye_height - x[2]) : 0.0;
    jacobian[0][0] = s;
    jacobian[0][1] = 0.0;
    jacobian[0][2] = ds_dz * (x[0] - eye_x);
    jacobian[1][0] = 0.0;
    jacobian[1][1] = -s;
    jacobian[1][2] = -ds_dz * (x[1] - eye_y);
  }
  // adj_x = Jacobianᵀ·adj_image, shape [3].
  void AdjProject(const double x[3], const Vec2& adj_image, double adj_x[3]) const {
    double jacobian[2][3];
    Jacobian(x, jacobian);
    for (int i = 0; i < 3; ++i)
      adj_x[i] = jacobian[0][i] * adj_image.x + jacobian[1][i] * adj_image.y;
  }
  // Returns whether the camera sees the point; false also for a point that is not finite in front
  // of a pinhole.
  bool IsInFront(const double x[3]) const { return !pinhole || x[2] < eye_height; }
};

struct GrayImage;

enum class CameraKind {
  kOrthographic,  // the projection of the published images, and the default
  kPinhole        // a photograph's, turned to look straight down (losses/photo), or that of the
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
};

// The camera of the published images, in which a flat specimen fills 84 % of the picture; larger,
// at the same scale, for a larger specimen.
Camera CameraAbove(const DrapeDiscs& discs);

// Projects all vertices: x [m], node-major, shape [3V] → image_points [px], shape [2, V]. Returns
// false when a coordinate is not finite or a vertex is not in front of the camera.
bool ProjectVertices(const Eigen::VectorXd& x, const Camera& camera,
                     Eigen::Matrix2Xd* image_points);

// Returns positions, shape [3V], mirrored (y → −y) if requested and then turned about z
// counter-clockwise by `rotation` [rad].
Eigen::VectorXd TurnedAboutZ(const Eigen::VectorXd& x, double rotation, bool mirrored = false);

// A camera as reports hold it and as a file of its own: kind, width, height, cx, cy [px]; px_per_m
// in the support plane; of a pinhole also eye_height_m, field_of_view_rad, eye_x_m and eye_y_m.
nlohmann::ordered_json CameraJson(const Camera& camera);

// The camera of such an object, or of an object that holds it as "camera". Throws InputError
// (prefix `where`) for a key that is missing and a value that Camera::Check refuses.
Camera CameraFromJson(const nlohmann::json& json, const std::string& where);

// The camera of a file that holds such an object, or of one that holds it as "camera", as the
// files of drape_photo do. Throws InputError also for a file that cannot be read.
Camera ReadCamera(const std::string& path);

// What drape_photo says of a photograph beside its camera, for whoever uses the silhouette.
struct PhotographNotes {
  double coefficient = 0.0;     // estimated drape coefficient
  double coefficient_sd = 0.0;  // its standard deviation
  std::vector<std::string> warnings;
};
// {"dc", "dc_sd", "warnings"}, the member "photograph" of a camera file.
nlohmann::ordered_json PhotographJson(const PhotographNotes& notes);
// Reads them from such a file; none if it is not of a photograph. Throws InputError for a file that
// cannot be read and for a member of another form.
std::optional<PhotographNotes> ReadPhotographNotes(const std::string& path);

}  // namespace drape
