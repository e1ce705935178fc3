// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/cloth/device_surface.h"

#include <cstddef>
#include <span>

namespace drape {
namespace {

// Copies `size` numbers of the host and lets the view point to the copy.
template <class T>
void Upload(std::size_t size, DeviceBuffer<T>& to, const T*& pointer) {
  to = DeviceBuffer<T>(std::span<const T>(pointer, size));
  pointer = to.data();
}

}  // namespace

DeviceSurface::DeviceSurface(const SurfaceObstacle& surface) : view_(surface.view()) {
  const auto vertices = static_cast<std::size_t>(surface.x().cols());
  const std::size_t triangles = surface.triangles().size();
  Upload(3 * vertices, x_, view_.x);
  Upload(3 * vertices, corner_normal_, view_.corner_normal);
  Upload(3 * triangles, corner_, view_.corner);
  Upload(3 * triangles, neighbour_, view_.neighbour);
  Upload(triangles, counted_, view_.counted);
  Upload(3 * triangles, centre_, view_.centre);
  Upload(triangles, radius_, view_.radius);
  Upload(3 * triangles, face_normal_, view_.face_normal);
  Upload(surface.lists().cell_start.size(), cell_start_, view_.cell_start);
  Upload(surface.lists().cell_triangle.size(), cell_triangle_, view_.cell_triangle);
}

}  // namespace drape
