// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/plane.h"
#include "physics/util/math/host_device.h"

namespace drape {

// The projection of a Camera (losses/camera/camera.h) as plain numbers, which kernels use too
// [MODEL, M46].
struct Projection {
  bool pinhole;
  double cx, cy;        // column and row of the world's origin, the support's centre [px]
  double scale;         // orthographic only [px/m]
  double eye_height;    // pinhole only [m]
  double focal;         // pinhole only [px]
  double eye_x, eye_y;  // pinhole only: of the centre of projection [m]

  // Magnification of the plane at height z [px/m].
  template <typename T>
  DRAPE_HD T PixelsPerMetre(const T& z) const {
    return pinhole ? T(focal) / (T(eye_height) - z) : T(scale);
  }
  // Maps x [m], shape [3], to the image point (column, row) [px], shape [2].
  template <typename T>
  DRAPE_HD void Project(const T x[3], T image[2]) const {
    const T s = PixelsPerMetre(x[2]);
    const T parallax = PixelsPerMetre(T(0)) - s;
    image[0] = T(cx) + s * x[0] + parallax * T(eye_x);
    image[1] = T(cy) - s * x[1] - parallax * T(eye_y);
  }
  // ∂image/∂x [px/m], shape [2, 3].
  DRAPE_HD void Jacobian(const double x[3], double jacobian[2][3]) const {
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
  DRAPE_HD void AdjProject(const double x[3], const Vec2& adj_image, double adj_x[3]) const {
    double jacobian[2][3];
    Jacobian(x, jacobian);
    for (int i = 0; i < 3; ++i)
      adj_x[i] = jacobian[0][i] * adj_image.x + jacobian[1][i] * adj_image.y;
  }
  // Returns whether the camera sees the point; false also for a point that is not finite in front
  // of a pinhole.
  DRAPE_HD bool IsInFront(const double x[3]) const { return !pinhole || x[2] < eye_height; }
};

}  // namespace drape
