// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/disc.h"
#include "physics/util/options/field.h"

namespace drape {

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
                        .least = 0.01,
                        .most = 10});
  visit(support, Field{.key = "support",
                       .doc = "diameter of the support; none: as those files say, or 0.18",
                       .unit = "m",
                       .least = 0.005,
                       .most = 10});
}

// What a file says of the discs of its drape: a PNG of WritePng, an OBJ of WriteObj, or a JSON file
// with DiscsJson, as drape_photo and drape_fit write it. None in any other file, or where there is
// no file.
std::optional<DrapeDiscs> StoredDiscs(const std::string& file);

// The discs of drapes in `files`, which may be of any kind. Throws InputError where a file
// contradicts the user or another file, since drapes of different discs cannot be compared, and for
// a support that is not smaller than the specimen.
DrapeDiscs FindDiscs(const DiscsInput& input, const std::vector<std::string>& files = {});

// As a user would set them.
DiscsInput GivenDiscs(const DrapeDiscs& discs);

// {"specimen_diameter_m", "support_diameter_m"}.
nlohmann::ordered_json DiscsJson(const DrapeDiscs& discs);

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
  std::string file;  // ReadCamera, in place of all others; "beside": camera.json in the folder of
                     // an image

  std::string FileFor(const std::string& image) const;  // its path; empty: none
  bool gives_camera() const { return !file.empty(); }
  bool gives_scale() const;
  bool gives_centre() const;
};

template <MutableOrConst<CameraInput> Input, class Visitor>
void VisitFields(Input& input, Visitor&& visit) {
  auto& [kind, width, height, cx, cy, scale, image_width_mm, file] = input;
  visit(kind, Field{.key = "camera",
                    .doc = "projection of the camera; the published images are orthographic"});
  const auto size = [](const char* key, const char* doc) {
    return Field{.key = key, .doc = doc, .unit = "px", .least = 0, .most = 8192};
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
                     .least = 1,
                     .most = 1e7});
  visit(image_width_mm, Field{.key = "image_width_mm",
                              .doc = "width of the area that the image shows in the support "
                                     "plane, in place of camera_scale: lay a ruler on the support",
                              .unit = "mm",
                              .least = 1,
                              .most = 1e5});
  visit(file, Field{.key = "camera_file",
                    .doc = "camera.json of drape_photo, in place of the other camera options; "
                           "beside: the file of that name in the folder of each image",
                    .is_path = true,
                    .word = "beside"});
}

// The camera of a rendering; CameraAbove gives what is missing. Throws InputError.
Camera MakeCamera(const CameraInput& input, const DrapeDiscs& discs);

// The camera of an image, `where` being its path. Throws InputError (prefix `where`) also when the
// image has another size than the given one, or another than that of CameraAbove (published images:
// 256 × 256 px) and no scale.
Camera MakeCamera(const CameraInput& input, const GrayImage& image, const DrapeDiscs& discs,
                  const std::string& where);

}  // namespace drape
