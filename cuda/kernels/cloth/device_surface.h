// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/device/device_buffer.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"

namespace drape {

// A copy of a triangle mesh on the present device.
class DeviceSurface {
 public:
  explicit DeviceSurface(const SurfaceObstacle& surface);
  const SurfaceView& view() const { return view_; }

 private:
  DeviceBuffer<double> x_, centre_, radius_, face_normal_, corner_normal_;
  DeviceBuffer<int> corner_, neighbour_, counted_, cell_start_, cell_triangle_;
  SurfaceView view_;
};

}  // namespace drape
