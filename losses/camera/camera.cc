// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera.h"

#include <glog/logging.h>

#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// 2π·(second polar moment)/area² is 1 for a disc and (q + 1/q)/2 for an ellipse of axis ratio q.
// This bound rejects ellipses of q > 1.1 and every drape.
constexpr double kMaxCircleMoment = 1.005;

void Require(bool holds, const std::string& where, const char* field, double value,
             const char* expected) {
  if (!holds) throw InputError(where, Format("%s = %g, expected %s", field, value, expected));
}

struct Moments {
  double area = 0, column = 0, row = 0, polar = 0;
};

Moments CoverageMoments(const GrayImage& image) {
  Moments m;
  double raw_polar = 0;
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const double c = image.at(col, row);
      m.area += c;
      m.column += c * col;
      m.row += c * row;
      raw_polar += c * (double(col) * col + double(row) * row);
    }
  }
  m.column /= m.area;
  m.row /= m.area;
  m.polar = raw_polar - m.area * (m.column * m.column + m.row * m.row);
  return m;
}

}  // namespace

Camera CameraAbove(const DrapeDiscs& discs) {
  Camera camera;
  const double larger = discs.specimen / DrapeDiscs().specimen;
  if (larger <= 1.0) return camera;
  camera.width = camera.height = 2 * static_cast<int>(std::ceil(0.5 * larger * camera.width));
  camera.cx = camera.cy = 0.5 * (camera.width - 1);
  return camera;
}

void Camera::Check(const std::string& where) const {
  Require(width >= 16, where, "camera_width", width, ">= 16 px");
  Require(height >= 16, where, "camera_height", height, ">= 16 px");
  constexpr double kFarthest = 1e6;      // [px]
  constexpr double kLargestScale = 1e7;  // [px/m]
  Require(std::abs(cx) <= kFarthest, where, "camera_cx", cx, "a column from -1e6 to 1e6");
  Require(std::abs(cy) <= kFarthest, where, "camera_cy", cy, "a row from -1e6 to 1e6");
  if (kind == CameraKind::kPinhole) {
    Require(eye_height > 0 && eye_height <= 1e3, where, "eye_height", eye_height,
            "more than 0, up to 1000 m");
    Require(field_of_view > 0 && field_of_view < M_PI, where, "field_of_view", field_of_view,
            "between 0 and pi rad");
    Require(pixels_per_metre() <= kLargestScale, where, "field_of_view", field_of_view,
            "so wide that a metre has at most 1e7 px");
    constexpr double kFarthestEye = 100;  // [m]
    Require(std::abs(eye_x) <= kFarthestEye, where, "eye_x", eye_x, "-100 to 100 m");
    Require(std::abs(eye_y) <= kFarthestEye, where, "eye_y", eye_y, "-100 to 100 m");
  } else {
    Require(scale >= 1 && scale <= kLargestScale, where, "camera_scale", scale, "1 to 1e7 px/m");
  }
}

Eigen::Matrix<double, 2, 3> Camera::ImageFromWorldJacobian(const double x[3]) const {
  double rows[2][3];
  projection().Jacobian(x, rows);
  return Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(rows[0]);
}

bool ProjectVertices(const Eigen::VectorXd& x, const Camera& camera,
                     Eigen::Matrix2Xd* image_points) {
  CHECK_EQ(x.size() % 3, 0);
  const Projection projection = camera.projection();
  image_points->resize(2, x.size() / 3);
  for (int i = 0; i < image_points->cols(); ++i) {
    if (!projection.IsInFront(&x[3 * i])) return false;
    projection.Project(&x[3 * i], image_points->col(i).data());
  }
  return x.allFinite() && image_points->allFinite();
}

Camera CalibrateFromCircle(const GrayImage& image, double radius, const std::string& where) {
  CHECK_GT(radius, 0);
  const Moments m = CoverageMoments(SegmentSilhouette(image, where).image);
  const double moment = 2 * M_PI * m.polar / (m.area * m.area);
  if (moment > kMaxCircleMoment) {
    throw InputError(where, "the silhouette is not a circle (second moment " +
                                std::to_string(moment) +
                                " times that of a disc, expected at most 1.005)");
  }
  Camera camera;
  camera.width = image.width;
  camera.height = image.height;
  camera.cx = m.column;
  camera.cy = m.row;
  camera.scale = std::sqrt(m.area / M_PI) / radius;
  return camera;
}

Eigen::VectorXd TurnedAboutZ(const Eigen::VectorXd& x, double rotation, bool mirrored) {
  CHECK_EQ(x.size() % 3, 0);
  const double c = std::cos(rotation), s = std::sin(rotation), sign = mirrored ? -1 : 1;
  Eigen::VectorXd turned = x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    turned[i] = c * x[i] - s * sign * x[i + 1];
    turned[i + 1] = s * x[i] + c * sign * x[i + 1];
  }
  return turned;
}

}  // namespace drape
