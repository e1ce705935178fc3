// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/readouts/tangent_reader.h"

#include <glog/logging.h>

#include <algorithm>

#include "cuda/readout/device_readouts.h"

namespace drape {

std::vector<const DeviceReadout*> CollectDeviceReadouts(const Readout& readout, std::size_t first,
                                                        std::size_t count) {
  std::vector<const DeviceReadout*> each;
  for (std::size_t i = first; i < first + count; ++i) {
    each.push_back(readout.device(i));
    CHECK(each.back() != nullptr && each.back()->kind == each[0]->kind);
    CHECK_EQ(each.back()->size, readout.size());
    CHECK_EQ(each.back()->width, each[0]->width);
  }
  return each;
}

namespace {

// rows·dx, [slots, rows, kPaddedEntries].
std::vector<double> MultiplyRows(const DeviceResources& resources, const SparseRows& sparse,
                                 int rows, const double* dx, int slots) {
  constexpr std::size_t kMostNumbers = std::size_t{1} << 24;  // at a time: pixels are many rows
  const std::size_t of_slot = std::size_t{kPaddedEntries} * rows;
  const int some = static_cast<int>(std::clamp<std::size_t>(kMostNumbers / of_slot, 1, slots));
  DeviceBuffer<double> out(some * of_slot);
  std::vector<double> host(slots * of_slot);
  for (int first = 0; first < slots; first += some) {
    const int count = std::min(some, slots - first);
    const SparseRows part{sparse.start + std::size_t{1} * first * rows, sparse.dof, sparse.value};
    LaunchReadRows(resources.view(), part,
                   dx + std::size_t{kPaddedEntries} * first * resources.view().num_dofs(),
                   out.data(), rows, count, resources.stream());
    resources.streams().Synchronize();
    CopyToHost<double>(out.data(), std::span(host).subspan(first * of_slot, count * of_slot));
  }
  return host;
}

void ReadOutlineTangents(const DeviceResources& resources, const TangentShapes& shapes,
                         const Readout& readout, std::span<LinearReadout* const> results) {
  const int slots = static_cast<int>(results.size()), rows = readout.size();
  const DeviceOutlines outlines(
      {&resources.cloth(), shapes.x, CollectDeviceReadouts(readout, 0, results.size())}, nullptr,
      resources.stream());
  const std::vector<double> radius = outlines.Radius();
  const std::vector<int> status = outlines.Status();
  const std::vector<double> dr =
      MultiplyRows(resources, outlines.Jacobian(), rows, shapes.dx, slots);
  for (int s = 0; s < slots; ++s) {
    if (shapes.host[s] == nullptr || status[s] != kRead) continue;
    results[s]->r = Eigen::Map<const Eigen::VectorXd>(radius.data() + s * rows, rows);
    results[s]->dr =
        Eigen::Map<const RowMatrix>(dr.data() + s * rows * kPaddedEntries, rows, kPaddedEntries)
            .leftCols(kMaterialEntries);
  }
}

void ReadTangentsOnHost(const DeviceResources& resources, const TangentShapes& shapes,
                        const Readout& readout, std::span<LinearReadout* const> results) {
  const int slots = static_cast<int>(results.size()), rows = readout.size();
  std::vector<ReadoutJacobian> jacobians(slots);
  std::vector<char> read(slots);
#pragma omp parallel for schedule(dynamic, 1) num_threads(resources.threads())
  for (int i = 0; i < slots; ++i)
    read[i] = shapes.host[i] != nullptr &&
              readout.Read(i, *shapes.host[i], &results[i]->r, &jacobians[i]);
  std::vector<int> start{0}, dof;
  std::vector<double> value;
  for (int i = 0; i < slots; ++i)
    for (int r = 0; r < rows; ++r) {
      if (read[i])
        for (ReadoutJacobian::InnerIterator at(jacobians[i], r); at; ++at) {
          dof.push_back(resources.cloth().DofInEliminationOrder(static_cast<int>(at.col())));
          value.push_back(at.value());
        }
      start.push_back(static_cast<int>(dof.size()));
    }
  const DeviceBuffer<int> starts(start), dofs(dof);
  const DeviceBuffer<double> values(value);
  const std::vector<double> dr =
      MultiplyRows(resources, {starts.data(), dofs.data(), values.data()}, rows, shapes.dx, slots);
  for (int i = 0; i < slots; ++i) {
    if (read[i]) {
      results[i]->dr =
          Eigen::Map<const RowMatrix>(dr.data() + std::size_t{1} * i * rows * kPaddedEntries, rows,
                                      kPaddedEntries)
              .leftCols(kMaterialEntries);
    } else {
      *results[i] = {};
    }
  }
}

}  // namespace

void ReadTangentShapes(const DeviceResources& resources, const TangentShapes& shapes,
                       const Readout& readout, std::span<LinearReadout* const> results) {
  const DeviceReadout* known = readout.device(0);
  if (known != nullptr && known->kind == ReadoutKind::kOutline) {
    ReadOutlineTangents(resources, shapes, readout, results);
  } else {
    ReadTangentsOnHost(resources, shapes, readout, results);
  }
}

}  // namespace drape
