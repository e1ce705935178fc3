// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "cuda/device/device_buffer.h"

namespace drape {

// Hands out pieces of one block of device memory. A workspace is a struct that takes its arrays
// from an arena: once from an empty one, to learn how large it is, then from one that holds it.
class Arena {
 public:
  Arena() = default;
  explicit Arena(DeviceBuffer<char>* memory) : base_(memory->data()), capacity_(memory->size()) {}

  template <class T>
  T* Take(std::size_t count) {
    T* piece = base_ == nullptr ? nullptr : reinterpret_cast<T*>(base_ + used_);
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    return piece;
  }
  std::size_t used() const { return used_; }
  bool fits() const { return used_ <= capacity_; }

 private:
  static constexpr std::size_t kAlignment = 256;
  char* base_ = nullptr;
  std::size_t capacity_ = 0, used_ = 0;
};

}  // namespace drape
