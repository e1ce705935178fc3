// SPDX-License-Identifier: Apache-2.0
#include "cuda/readout/device_readouts.h"

#include <glog/logging.h>

#include <map>

#include "cuda/device/arena.h"

namespace drape {
namespace {

template <class T>
DeviceBuffer<T> Zeros(std::size_t size) {
  DeviceBuffer<T> buffer(size);
  Clear(buffer);
  return buffer;
}

template <class T>
std::vector<T> Download(const T* from, std::size_t count) {
  std::vector<T> host(count);
  CopyToHost<T>(from, host);
  return host;
}
template <class T>
std::vector<T> Download(const DeviceBuffer<T>& from) {
  return Download(from.data(), from.size());
}

const double* SlotPositions(const ShapesToRead& shapes, int slot) {
  return shapes.x + std::size_t{1} * slot * shapes.cloth->view().num_dofs();
}

SilhouettePlan MakePlan(const DeviceCloth& cloth, const DeviceReadout& readout) {
  return SilhouettePlan::Of(cloth.mesh(), readout.width, readout.height);
}

}  // namespace

DeviceLosses::DeviceLosses(const ShapesToRead& shapes,
                           std::span<const Eigen::VectorXd* const> targets, double sigma)
    : dofs_(shapes.cloth->view().num_dofs()),
      sigma_(sigma),
      loss_(Zeros<double>(targets.size())),
      dL_dx_(Zeros<double>(targets.size() * dofs_)) {
  std::map<const Eigen::VectorXd*, std::size_t> starts;
  std::vector<double> all;
  for (const Eigen::VectorXd* target : targets) {
    const auto [place, fresh] = starts.try_emplace(target, all.size());
    if (fresh) all.insert(all.end(), target->data(), target->data() + target->size());
    target_start_.push_back(place->second);
  }
  targets_ = DeviceBuffer<double>(all);
}

std::vector<double> DeviceLosses::Download() const { return drape::Download(loss_); }

DeviceOutlines::DeviceOutlines(const ShapesToRead& shapes, DeviceLosses* losses,
                               cudaStream_t stream) {
  const int slots = shapes.slots();
  const OutlinePlan plan{shapes.cloth->mesh(), shapes.readouts[0]->size};
  const std::size_t hem = plan.mesh.num_hem, angles = plan.num_angles, rows = slots * angles;
  CHECK_GT(hem, 0u) << "a mesh without a boundary has no hem";
  points_ = DeviceBuffer<Vec2>(slots * hem);
  radius_ = Zeros<double>(rows);
  value_ = Zeros<double>(6 * rows);
  dof_ = Zeros<int>(6 * rows);
  status_ = Zeros<int>(slots);
  std::vector<int> start(rows + 1);
  for (std::size_t r = 0; r <= rows; ++r) start[r] = static_cast<int>(6 * r);
  start_ = DeviceBuffer<int>(start);
  std::vector<OutlineSlot> each(slots);
  for (int s = 0; s < slots; ++s) {
    const std::size_t row = s * angles;
    each[s] = {SlotPositions(shapes, s),
               nullptr,
               1.0,
               shapes.readouts[s]->camera,
               points_.data() + s * hem,
               radius_.data() + row,
               dof_.data() + 6 * row,
               value_.data() + 6 * row,
               nullptr,
               nullptr,
               status_.data() + s};
    if (losses == nullptr) continue;
    each[s].target = losses->target(s);
    each[s].sigma = losses->sigma();
    each[s].loss = losses->loss(s);
    each[s].dL_dx = losses->dL_dx(s);
  }
  slots_ = DeviceBuffer<OutlineSlot>(each);
  LaunchOutlines(plan, slots_.data(), slots, stream);
  if (losses != nullptr) LaunchOutlineLoss(plan, slots_.data(), slots, stream);
  CUDA_CHECK(cudaStreamSynchronize(stream));
}

std::vector<double> DeviceOutlines::Radius() const { return Download(radius_); }
std::vector<int> DeviceOutlines::Status() const { return Download(status_); }
SparseRows DeviceOutlines::Jacobian() const { return {start_.data(), dof_.data(), value_.data()}; }

DeviceSilhouettes::DeviceSilhouettes(const ShapesToRead& shapes, DeviceLosses* losses,
                                     cudaStream_t stream)
    : plan_(MakePlan(*shapes.cloth, *shapes.readouts[0])),
      memory_(shapes.slots() * BytesOfSlot(*shapes.cloth, *shapes.readouts[0])),
      status_(Zeros<int>(shapes.slots())),
      host_slots_(shapes.slots()) {
  Arena arena(&memory_);
  for (int s = 0; s < shapes.slots(); ++s) {
    const DeviceReadout& readout = *shapes.readouts[s];
    SilhouetteSlot& slot = host_slots_[s];
    TakeSilhouette(arena, plan_, &slot);
    slot.x = SlotPositions(shapes, s);
    slot.camera = readout.camera;
    slot.half_width = readout.half_width;
    slot.status = status_.data() + s;
    if (losses == nullptr) continue;
    slot.target = losses->target(s);
    slot.sigma = losses->sigma();
    slot.loss = losses->loss(s);
    slot.dL_dx = losses->dL_dx(s);
  }
  slots_ = DeviceBuffer<SilhouetteSlot>(host_slots_);
  LaunchCoverage(plan_, slots_.data(), shapes.slots(), stream);
  if (losses != nullptr) LaunchSilhouetteLoss(plan_, slots_.data(), shapes.slots(), stream);
  CUDA_CHECK(cudaStreamSynchronize(stream));
}

std::size_t DeviceSilhouettes::BytesOfSlot(const DeviceCloth& cloth, const DeviceReadout& readout) {
  Arena measure;
  SilhouetteSlot slot;
  TakeSilhouette(measure, MakePlan(cloth, readout), &slot);
  return measure.used();
}

std::vector<double> DeviceSilhouettes::Coverage(int slot) const {
  return Download(host_slots_[slot].coverage, plan_.pixels());
}
std::vector<int> DeviceSilhouettes::Status() const { return Download(status_); }
int DeviceSilhouettes::Cuts(int slot) const {
  return Download(host_slots_[slot].cut_start + plan_.edges(), 1)[0];
}

std::vector<int> MeasureLosses(const ShapesToRead& shapes, DeviceLosses* losses,
                               cudaStream_t stream) {
  if (shapes.readouts[0]->kind == ReadoutKind::kOutline)
    return DeviceOutlines(shapes, losses, stream).Status();
  return DeviceSilhouettes(shapes, losses, stream).Status();
}

}  // namespace drape
