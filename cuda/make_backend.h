// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <memory>
#include <string>

#include "physics/linalg/linear_solver.h"
#include "physics/simulation/backend.h"

namespace drape {

// name: cpu, cuda, or auto (cuda where SurveyCuda says that it is usable). Throws InputError for
// any other. *device, when given, names what it runs on: "2 CPU threads", "NVIDIA H200". Why auto
// found no GPU is logged at --v=1.
std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* device = nullptr);

// A direct solver of single systems by the same names, for the steps of one large cloth. On a GPU
// it factors in a fraction of the time; what else a step does is on the host. The same throws.
std::unique_ptr<LinearSolver> MakeStepLinearSolver(const std::string& name,
                                                   const BlockPattern& pattern, int threads,
                                                   std::string* device = nullptr);

// Wakes the GPUs that MakeBackend would use while a program reads its input, where the system has a
// thread for it. Does nothing for cpu. The destructor of what is returned waits.
[[nodiscard]] std::future<void> WakeGpus(const std::string& name);

// The GPUs that auto runs on, "NVIDIA H200"; empty: none.
std::string UsableGpu();

}  // namespace drape
