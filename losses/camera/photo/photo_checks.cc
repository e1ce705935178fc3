// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/photo_checks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

void CheckOptions(const PhotoOptions& options) {
  if (options.support >= options.specimen)
    throw InputError("option 'support'", Format("found %g, expected less than specimen = %g m",
                                                options.support, options.specimen));
  if (options.marker == PhotoMarker::kTag && options.tag <= 0)
    throw InputError("option 'tag'",
                     "not given, expected the side of the tag's black square [m] "
                     "with marker = tag");
  if (options.marker == PhotoMarker::kNone && options.px_per_m <= 0)
    throw InputError("option 'px_per_m'",
                     "not given, expected the scale of the picture with "
                     "marker = none");
}

double FocalLength(const Photograph& photo, const PhotoOptions& options) {
  constexpr double kFilmDiagonal = 43.2666;  // [mm]
  constexpr double kSameShape = 0.01;
  const double width = photo.image.width, height = photo.image.height;
  double focal = options.focal_35mm;
  if (focal <= 0) {
    focal = photo.exif.focal_35mm;
    if (focal <= 0)
      throw PhotoFailure{PhotoFault::kNoFocalLength,
                         "the file does not tell the focal length, expected EXIF data (send the "
                         "original file) or focal_35mm"};
    if (photo.exif.width > 0 && photo.exif.height > 0) {
      const double taken = double(std::max(photo.exif.width, photo.exif.height)) /
                           std::min(photo.exif.width, photo.exif.height);
      const double shown = std::max(width, height) / std::min(width, height);
      if (std::abs(taken / shown - 1) > kSameShape)
        throw PhotoFailure{PhotoFault::kCroppedPhoto,
                           Format("the photograph was cropped: it is %.0fx%.0f px and was taken "
                                  "with %dx%d, expected the whole photograph or focal_35mm",
                                  width, height, photo.exif.width, photo.exif.height)};
    }
  }
  return focal * std::hypot(width, height) / kFilmDiagonal;
}

void CheckGlare(const PhotoPlanes& planes, const cv::Mat1b& cloth) {
  constexpr double kMostOfGround = 0.02, kMostOfCloth = 0.004;
  if (planes.saturated > kMostOfGround) return;  // back light, or a white ground
  const std::vector<cv::Point> outline = LongestOutline(cloth);
  std::vector<cv::Point> hull;
  cv::convexHull(outline, hull);
  cv::Mat1b inside = cv::Mat1b::zeros(cloth.size());
  cv::fillConvexPoly(inside, hull, 1);
  cv::Mat1b white;
  cv::inRange(planes.rgb, cv::Scalar::all(250), cv::Scalar::all(255), white);
  const cv::Mat1b glare = white & (inside * 255);
  const double share = cv::countNonZero(glare) / double(cv::countNonZero(cloth));
  if (share <= kMostOfCloth) return;
  throw PhotoFailure{PhotoFault::kGlare,
                     Format("glare: %.1f %% of the cloth is white without detail, expected light "
                            "that is not reflected into the camera",
                            100 * share),
                     {LongestOutline(glare / 255)}};
}

void CheckBlur(double blur) {
  constexpr double kMost = 2.5e-3;  // [m]
  if (blur <= kMost) return;
  throw PhotoFailure{PhotoFault::kBlur,
                     Format("the outline is blurred over %.1f mm (standard deviation), expected at "
                            "most %.1f: hold the camera still and focus on the cloth",
                            1e3 * blur, 1e3 * kMost)};
}

}  // namespace drape
