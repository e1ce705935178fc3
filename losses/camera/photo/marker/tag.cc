// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/marker/tag.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cmath>
#include <memory>

namespace drape {
namespace {

struct Deleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

double ComputeArea(const apriltag_detection_t& tag) {
  double area = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double *a = tag.p[i], *b = tag.p[(i + 1) % 4];
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(area);
}

}  // namespace

std::optional<std::array<Eigen::Vector2d, 4>> FindTag(const PhotoPlanes& planes) {
  constexpr int kMostErrors = 1;  // bits that are corrected
  constexpr float kLeastMargin = 20;
  // Linear light: in stored values the edges of a blurred tag lie in its black, and the tag looks
  // smaller by .6 %.
  cv::Mat1b gray;
  planes.luma.convertTo(gray, CV_8U, 255);
  const std::unique_ptr<apriltag_family_t, Deleter> family(tag36h11_create());
  const std::unique_ptr<apriltag_detector_t, Deleter> detector(apriltag_detector_create());
  apriltag_detector_add_family_bits(detector.get(), family.get(), kMostErrors);
  detector->quad_decimate = 1;
  image_u8_t image{gray.cols, gray.rows, static_cast<int32_t>(gray.step[0]), gray.data};
  const std::unique_ptr<zarray_t, Deleter> found(apriltag_detector_detect(detector.get(), &image));
  const apriltag_detection_t* best = nullptr;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* tag = nullptr;
    zarray_get(found.get(), i, &tag);
    if (tag->decision_margin < kLeastMargin) continue;
    if (best == nullptr || ComputeArea(*tag) > ComputeArea(*best)) best = tag;
  }
  if (best == nullptr) return std::nullopt;
  std::array<Eigen::Vector2d, 4> corners;
  // The library's pixel centres are at halves.
  for (size_t i = 0; i < 4; ++i) corners[i] = {best->p[i][0] - 0.5, best->p[i][1] - 0.5};
  return corners;
}

}  // namespace drape
