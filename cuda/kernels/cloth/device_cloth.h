// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/device_buffer.h"
#include "cuda/factor/multifrontal.h"
#include "cuda/kernels/cloth/cloth_view.h"
#include "physics/cloth/cloth_model.h"
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

// A cloth model on the present device, in elimination order.
class DeviceCloth {
 public:
  // shared_bytes: of a block of threads.
  DeviceCloth(std::shared_ptr<const ClothModel> model, const FrontPlan& plan, int shared_bytes);

  const ClothModel& model() const { return *model_; }
  const ClothView& view() const { return view_; }
  const Law& law() const { return law_; }  // its tables lie on the device
  const Multifrontal& multifrontal() const { return multifrontal_; }

  // Rows of `columns` numbers a degree of freedom, from the mesh's order to elimination order and
  // back; on the host. `stride`: numbers a row in elimination order, zeros after the columns.
  void ToEliminationOrder(const double* mesh_order, int columns, int stride, double* to) const;
  void ToMeshOrder(const double* elimination_order, int columns, int stride, double* to) const;

 private:
  SolidContact UploadContact(const Contact& contact);

  std::shared_ptr<const ClothModel> model_;
  std::vector<int> position_;
  Multifrontal multifrontal_;
  DeviceBuffer<Face> faces_;
  DeviceBuffer<Hinge> hinges_;
  DeviceBuffer<double> vertex_area_, rest_x_, handle_, load_;
  DeviceBuffer<int> row_start_, column_, mirror_, entry_block_, entry_order_, diagonal_entry_;
  DeviceBuffer<Solid> solids_;
  std::vector<DeviceSurface> surfaces_;
  DeviceBuffer<StretchNode> strain_nodes_;
  struct Gather {
    DeviceBuffer<int> start, item;
    explicit Gather(const GatherList& list) : start(list.start), item(list.item) {}
    GatherView view() const { return {start.data(), item.data()}; }
  };
  std::unique_ptr<Gather> to_entry_, to_vertex_;
  Law law_;
  ClothView view_{};
};

// The tables of the fabrics of a batch: each field is there once, however many rollouts use it.
class DeviceMaterials {
 public:
  explicit DeviceMaterials(std::span<const MaterialField* const> materials);
  const MaterialView* views() const { return views_.data(); }

 private:
  DeviceBuffer<StretchTable> stretch_;
  DeviceBuffer<BendTable> bend_;
  DeviceBuffer<MaterialView> views_;
};

}  // namespace drape
