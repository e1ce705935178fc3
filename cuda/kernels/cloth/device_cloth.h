// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/device.h"
#include "cuda/factor/multifrontal.h"
#include "cuda/kernels/cloth/cloth_view.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

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
  std::shared_ptr<const ClothModel> model_;
  std::vector<int> position_;
  Multifrontal multifrontal_;
  DeviceArrays arrays_;
  Law law_;
  ClothView view_{};
};

// The tables of the fabrics of a batch: each field is there once, however many rollouts use it.
class DeviceMaterials {
 public:
  explicit DeviceMaterials(std::span<const MaterialField* const> materials);
  const MaterialView* views() const { return views_.data(); }

 private:
  DeviceArrays tables_;
  DeviceBuffer<MaterialView> views_;
};

}  // namespace drape
