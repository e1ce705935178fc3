// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "losses/outline/outline.h"
#include "physics/mesh/disc.h"
#include "physics/util/options/field.h"

namespace drape {

// What in a photograph says where the camera was.
enum class PhotoMarker {
  kDisc,  // the rim of the round disc that lies on the cloth over the support
  kTag,   // a printed AprilTag of family 36h11 that lies flat beside the cloth or on the disc
  kNone   // nothing: a scan, or parallel light; px_per_m is the scale
};
constexpr auto EnumNames(PhotoMarker) {
  return MakeNames<PhotoMarker>(
      {{PhotoMarker::kDisc, "disc"}, {PhotoMarker::kTag, "tag"}, {PhotoMarker::kNone, "none"}});
}

struct PhotoOptions {
  PhotoMarker marker = PhotoMarker::kDisc;
  double specimen = 2 * DrapeDiscs().specimen;  // diameters [m]
  double support = 2 * DrapeDiscs().support;    //
  double disc = 0.0;                            // diameter of the disc [m]; 0: the support's
  double disc_height = 0.0;                     // of its visible rim above the support plane [m]
  double tag = 0.0;                             // side of the tag's black square [m]
  double tag_height = 0.0;                      // of the tag's plane above the support plane [m]
  double focal_35mm = 0.0;                      // [mm]; 0: EXIF
  double px_per_m = 0.0;                        // of a scan [px/m]
  double threshold = 0.0;                       // 0 … 1 between ground and cloth; 0: found
  std::string mask;                             // picture of the cloth made by hand; empty: found
  std::vector<int> cloth_points;                // columns and rows of points on the cloth [px]
  std::vector<int> ground_points;               // and on the ground
};

inline DrapeDiscs MakeDiscs(const PhotoOptions& options) {
  return {0.5 * options.specimen, 0.5 * options.support};
}

// A length of the photograph's objects [m].
inline Field LengthField(const char* key, const char* doc, double least, double most) {
  return {.key = key,
          .doc = doc,
          .unit = "m",
          .range = {.least = least, .most = most},
          .usual_least = least,
          .usual_most = 0.6};
}

template <MutableOrConst<PhotoOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [marker, specimen, support, disc, disc_height, tag, tag_height, focal_35mm, px_per_m,
         threshold, mask, cloth_points, ground_points] = options;
  visit(marker,
        Field{.key = "marker",
              .doc = "what shows where the camera was: disc: the rim of the disc that lies on the "
                     "cloth over the support; tag: a printed AprilTag (36h11); none: a scan or "
                     "parallel light, of which px_per_m is the scale"});
  visit(specimen, LengthField("specimen", "diameter of the flat specimen", 0.01, 10));
  visit(support, LengthField("support", "diameter of the support", 0.005, 10));
  visit(disc,
        LengthField("disc", "diameter of the disc that is seen; 0: that of the support", 0, 10));
  visit(disc_height, LengthField("disc_height", "height of the disc's rim above the cloth", -1, 1));
  visit(tag, LengthField("tag", "side of the tag's black square", 0, 10));
  visit(tag_height, LengthField("tag_height", "height of the tag above the support", -10, 10));
  visit(focal_35mm, Field{.key = "focal_35mm",
                          .doc = "focal length of a 35-mm camera of the same view, 24 to 28 for "
                                 "the main camera of a telephone; 0: that of the file's EXIF data",
                          .unit = "mm",
                          .range = {.least = 0, .most = 10000},
                          .usual_least = 10,
                          .usual_most = 1000});
  visit(px_per_m, Field{.key = "px_per_m",
                        .doc = "marker = none: scale of the picture, 11811 for 300 dots an inch",
                        .unit = "px/m",
                        .range = {.least = 0, .most = 1e7},
                        .usual_least = 100,
                        .usual_most = 1e5});
  visit(threshold, Field{.key = "threshold",
                         .doc = "where the cloth begins, from 0 (as the ground) to 1 (as the most "
                                "unlike pixels); 0: found",
                         .range = {.least = 0, .most = 1}});
  visit(mask, Field{.key = "mask",
                    .doc = "picture of the photograph's size made by hand, black where the cloth "
                           "is; its edge is refined",
                    .is_path = true});
  visit(cloth_points, Field{.key = "cloth_points",
                            .doc = "columns and rows of points on the cloth, c1,r1,c2,r2,…, where "
                                   "it is not found without",
                            .unit = "px",
                            .range = {.least = 0}});
  visit(ground_points, Field{.key = "ground_points",
                             .doc = "the same of points beside the cloth",
                             .unit = "px",
                             .range = {.least = 0}});
}

// The silhouette of a photograph, and the camera that sees it.
struct PhotoResult {
  PhotoFault fault = PhotoFault::kNone;
  std::string reason;                 // one line, where there is a fault
  std::vector<std::string> warnings;  // one sentence each
  RgbImage overlay;                   // the photograph with what was found, also with a fault
  Eigen::Vector4d specimen_box{0, 0, 0, 0};  // left, top, width and height of the flat specimen in
                                             // it [px]; 0 without one

  // Nothing of the following with a fault.
  GrayImage silhouette;  // as a pinhole that looks straight down sees it, from where the camera was
  Camera camera;         // that pinhole; orthographic without a marker
  GrayImage projected;   // estimated vertical projection, for the camera of the published images
  Eigen::VectorXd radius;          // of that projection [m], shape [360] (VerticalProfile)
  ShapeFeatures shape;             // of that projection
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
