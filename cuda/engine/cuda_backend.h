// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "physics/linalg/linear_solver.h"
#include "physics/simulation/backend.h"

namespace drape {

// A feature that is not in this build; `why` says how that can be changed. The tools print what()
// and exit with 2.
class NotCompiled : public std::runtime_error {
 public:
  NotCompiled(const std::string& feature, const std::string& why)
      : std::runtime_error("no " + feature + " support: " + why) {}
};

// The build has CUDA code, but there is nothing here to run it on.
class NoDevice : public std::runtime_error {
 public:
  explicit NoDevice(const std::string& why) : std::runtime_error("no usable CUDA device: " + why) {}
};

// Batches on all CUDA devices of this machine, the batch split evenly over them. What a device
// cannot decide, a system that is not positive definite for one, is done on `threads` threads of
// the host. Throws NotCompiled or NoDevice, later CudaError or DeviceMemoryError (cuda_error.h).
std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel> model, int threads);

// A LinearSolver on the first CUDA device (factor/multifrontal.h). Throws as MakeCudaBackend does.
std::unique_ptr<LinearSolver> MakeCudaSolver(const BlockPattern& pattern);

// Where rollouts can run here, in words: the devices, or why there is none.
struct CudaSurvey {
  bool usable = false;
  std::string text;
};
CudaSurvey SurveyCuda();

// Makes the contexts of all devices, .3 s once a process. The first backend says what went wrong.
void WakeCuda();

}  // namespace drape
