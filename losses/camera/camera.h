// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "physics/mesh/disc.h"
#include "physics/util/options/field.h"

namespace drape {

class JsonInput;

// The determinant of the matrix of the columns a and b: twice the signed area of the triangle of
// the origin, a and b.
inline double Determinant(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

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

  bool is_pinhole() const { return kind == CameraKind::kPinhole; }

  // Magnification of the plane at height z [px/m].
  template <typename T>
  T PixelsPerMetre(const T& z) const {
    return is_pinhole() ? T(focal_length()) / (T(eye_height) - z) : T(scale);
  }
  double pixels_per_metre() const { return PixelsPerMetre(0.0); }  // in the support plane

  // Maps x [m], shape [3], to the image point (column, row) [px], shape [2]. T is double or any
  // dual number. A pinhole needs z < eye_height.
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
    const double ds_dz = is_pinhole() ? s / (eye_height - x[2]) : 0.0;
    jacobian[0][0] = s;
    jacobian[0][1] = 0.0;
    jacobian[0][2] = ds_dz * (x[0] - eye_x);
    jacobian[1][0] = 0.0;
    jacobian[1][1] = -s;
    jacobian[1][2] = -ds_dz * (x[1] - eye_y);
  }

  // adj_x = Jacobianᵀ·adj_image, shape [3].
  void AdjProject(const double x[3], const Eigen::Vector2d& adj_image, double adj_x[3]) const {
    double jacobian[2][3];
    Jacobian(x, jacobian);
    for (int i = 0; i < 3; ++i)
      adj_x[i] = jacobian[0][i] * adj_image.x() + jacobian[1][i] * adj_image.y();
  }

  // Returns whether the camera sees the point; false also for a point that is not finite in front
  // of a pinhole.
  bool IsInFront(const double x[3]) const { return !is_pinhole() || x[2] < eye_height; }

  // The point of the plane at height z [m] that is seen at an image point (column, row) [px].
  Eigen::Vector2d WorldFromImage(const Eigen::Vector2d& image, double z) const {
    const double s = PixelsPerMetre(z), parallax = pixels_per_metre() - s;
    return {(image.x() - cx - (is_pinhole() ? parallax * eye_x : 0.0)) / s,
            (cy - image.y() - (is_pinhole() ? parallax * eye_y : 0.0)) / s};
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

// The camera of a file that holds such an object, or of one that holds it as "camera", as the
// files of drape_photo do. Throws InputError for a file that cannot be read, a key that is missing
// and a value that Camera::Check refuses.
Camera ReadCamera(const std::string& path);
// The same from such an object of another file.
Camera ReadCamera(const JsonInput& input);

// Where the warp lies in a picture, as a user says: "up", "right", "unknown", or whole degrees
// counter-clockwise from the right. Both ends of a thread are alike.
inline constexpr const char* kWarpDoc =
    "where the warp lies in the picture: up, right, degrees counter-clockwise from the right, or "
    "unknown, where results name a stiffer and a softer direction";
inline constexpr const char* kUnknownWarp = "unknown";
// Its angle [degrees], 0 … 179; none where it is not known. Throws InputError (prefix `where`).
std::optional<int> ParseWarp(const std::string& text, const std::string& where = "option 'warp'");
// The member "warp" of a camera file, as drape_photo writes it; without one kUnknownWarp.
std::string ReadWarp(const std::string& path);

// The results of drape_photo that accompany a silhouette, beside its camera.
struct PhotographNotes {
  double coefficient = 0.0;     // estimated drape coefficient
  double coefficient_sd = 0.0;  // its standard deviation
  std::vector<std::string> warnings;
};
// {"dc", "dc_sd", "warnings"}, the member "photograph" of a camera file.
nlohmann::ordered_json PhotographJson(const PhotographNotes& notes);
// Reads them from a camera file; none if it has no such member. Throws InputError for a file that
// cannot be read and for a member of another form.
std::optional<PhotographNotes> ReadPhotographNotes(const std::string& path);

// Specimen and support as a user sets them: diameters [m].
struct DiscsInput {
  static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

  double specimen = kNotGiven;  // not given: what the files say that the drapes are from, or that
  double support = kNotGiven;   // of the published drapes
};

template <MutableOrConst<DiscsInput> Input, class Visitor>
void VisitFields(Input& input, Visitor&& visit) {
  auto& [specimen, support] = input;
  visit(specimen, Field{.key = "specimen",
                        .doc = "diameter of the flat specimen; none: as the files of this drape "
                               "say that drapefit made, or 0.30",
                        .unit = "m",
                        .range = {.least = 0.01, .most = 10},
                        .usual_least = 0.05,
                        .usual_most = 0.6});
  visit(support, Field{.key = "support",
                       .doc = "diameter of the support; none: as those files say, or 0.18",
                       .unit = "m",
                       .range = {.least = 0.005, .most = 10},
                       .usual_least = 0.02,
                       .usual_most = 0.6});
}

// What a file says of the discs of its drape: a PNG of WritePng, an OBJ of WriteObj, or a JSON file
// with DiscsJson, as drape_photo and drape_fit write it. None in any other file, or where there is
// no file.
std::optional<DrapeDiscs> StoredDiscs(const std::string& file);

// The discs of drapes in `files`, which may be of any kind. Throws InputError where a file
// contradicts the user or another file, since drapes of different discs cannot be compared, and for
// a support that is not smaller than the specimen.
DrapeDiscs FindDiscs(const DiscsInput& input, const std::vector<std::string>& files = {});

// Returns the input by which a user gives these discs.
DiscsInput GivenDiscs(const DrapeDiscs& discs);

// {"specimen_diameter_m", "support_diameter_m"}.
nlohmann::ordered_json DiscsJson(const DrapeDiscs& discs);

// The scale of a picture in the support plane, as the picture or a thing in it says.
struct ScaleInput {
  bool dpi = false;                // the dots an inch that the file states: a scan
  std::vector<double> ruler = {};  // columns and rows of two points [px], their distance [mm]

  bool given() const { return dpi || !ruler.empty(); }
  // [px/m]. Throws InputError for a ruler of other than five numbers, of no length or of less than
  // 20 px, beside dpi, and for a picture that states no dots an inch (ReadPixelsPerMetre).
  double Find(const std::string& picture) const;
};

template <MutableOrConst<ScaleInput> Input, class Visitor>
void VisitFields(Input& input, Visitor&& visit) {
  auto& [dpi, ruler] = input;
  visit(dpi, Field{.key = "dpi",
                   .doc = "take the scale from the dots an inch that the picture's file states: "
                          "of a scan, not of a photograph"});
  visit(ruler, Field{.key = "ruler",
                     .doc = "take the scale from X1,Y1,X2,Y2,LENGTH_MM: column and row of two "
                            "points [px] and the distance between them [mm], of a ruler or across "
                            "a coin in the support plane"});
}

// A camera as a user sets it. What is not given follows from the image or, without an image, from
// the published ones: 256 × 256 px at 719.5 px/m.
struct CameraInput {
  static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

  CameraKind kind = CameraKind::kOrthographic;
  int width = 0, height = 0;          // [px]; 0: not given
  double cx = kNotGiven;              // column and row of the support's centre [px]; not given: the
  double cy = kNotGiven;              // image's centre
  double scale = kNotGiven;           // orthographic only [px/m]
  double image_width_mm = kNotGiven;  // width of the area seen in the support plane: another way to
                                      // give the scale
  ScaleInput picture = {};            // two further ways
  std::string file;  // ReadCamera, in place of all others; "beside": camera.json in the folder of
                     // an image

  std::string FileFor(const std::string& image) const;  // its path; empty: none
  bool gives_camera() const { return !file.empty(); }
  bool gives_scale() const;
  bool gives_centre() const;
};

template <MutableOrConst<CameraInput> Input, class Visitor>
void VisitFields(Input& input, Visitor&& visit) {
  auto& [kind, width, height, cx, cy, scale, image_width_mm, picture, file] = input;
  visit(kind, Field{.key = "camera",
                    .doc = "projection of the camera; the published images are orthographic"});
  const auto size = [](const char* key, const char* doc) {
    return Field{.key = key, .doc = doc, .unit = "px", .range = {.least = 0, .most = 8192}};
  };
  visit(width, size("camera_width", "width of the silhouette; 0: that of the image, or 256"));
  visit(height, size("camera_height", "height of the silhouette; 0: that of the image, or 256"));
  visit(cx, Field{.key = "camera_cx",
                  .doc = "column of the support's centre; none: the centre of the image",
                  .unit = "px"});
  visit(cy, Field{.key = "camera_cy",
                  .doc = "row of the support's centre; none: the centre of the image",
                  .unit = "px"});
  visit(scale, Field{.key = "camera_scale",
                     .doc = "magnification in the support plane; none: 719.5, that of the "
                            "published images of 256x256 px; an image of another size needs this "
                            "or image_width_mm",
                     .unit = "px/m",
                     .range = {.least = 1, .most = 1e7},
                     .usual_least = 100,
                     .usual_most = 1e5});
  visit(image_width_mm, Field{.key = "image_width_mm",
                              .doc = "width of the area that the image shows in the support "
                                     "plane, in place of camera_scale: lay a ruler on the support",
                              .unit = "mm",
                              .range = {.least = 1, .most = 1e5},
                              .usual_least = 80,
                              .usual_most = 5000});
  VisitFields(picture, visit);
  visit(file, Field{.key = "camera_file",
                    .doc = "camera.json of drape_photo, in place of the other camera options; "
                           "beside: the file of that name in the folder of each image",
                    .is_path = true,
                    .words = {"beside"}});
}

// The camera of a rendering; CameraAbove gives what is missing. Throws InputError.
Camera MakeCamera(const CameraInput& input, const DrapeDiscs& discs);

// The camera of an image, `where` being its path. Throws InputError (prefix `where`) also when the
// image has another size than the given one, or another than that of CameraAbove (published images:
// 256 × 256 px) and no scale.
Camera MakeCamera(const CameraInput& input, const GrayImage& image, const DrapeDiscs& discs,
                  const std::string& where);

}  // namespace drape
