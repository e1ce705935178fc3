// SPDX-License-Identifier: Apache-2.0
#include "cuda/make_backend.h"

#include <glog/logging.h>

#include <utility>

#include "cuda/engine/cuda_backend.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

std::string CpuText(int threads) {
  return std::to_string(threads) + (threads == 1 ? " CPU thread" : " CPU threads");
}

void CheckName(const std::string& name) {
  if (name != "cpu" && name != "cuda" && name != "auto")
    throw InputError("backend", "unknown name '" + name + "', expected auto, cpu or cuda");
}

// What a scene has that no device computes; empty: nothing.
std::string OnCpuAlone(const Scene& scene) {
  return scene.contact && scene.contact->self ? "contact of the cloth with itself" : "";
}

}  // namespace

std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* device) {
  CheckName(name);
  std::string text = CpuText(threads);
  if (const std::string what = OnCpuAlone(model->scene); !what.empty()) {
    if (name == "cuda") throw InputError("backend", "found cuda, expected cpu for " + what);
    if (device != nullptr) *device = text + ", on which alone " + what + " runs";
    return MakeCpuBackend(std::move(model), threads);
  }
  const CudaSurvey survey = name == "cpu" ? CudaSurvey{} : SurveyCuda();
  if (name == "auto" && !survey.usable) VLOG(1) << "no GPU: " << survey.text;
  if (name == "cuda" || survey.usable) {
    try {
      std::unique_ptr<Backend> backend = MakeCudaBackend(model, threads);
      if (device != nullptr) *device = survey.text;
      return backend;
    } catch (const InputError& error) {  // a mesh that no device can factor
      if (name == "cuda") throw;
      text += std::string(", not on ") + survey.text + ": " + error.what();
    }
  }
  if (device != nullptr) *device = text;
  return MakeCpuBackend(std::move(model), threads);
}

std::unique_ptr<LinearSolver> MakeStepLinearSolver(const std::string& name,
                                                   const BlockPattern& pattern, int threads,
                                                   std::string* device) {
  CheckName(name);
  const CudaSurvey survey = name == "cpu" ? CudaSurvey{} : SurveyCuda();
  if (name == "cuda" || survey.usable) {
    std::unique_ptr<LinearSolver> solver = MakeCudaSolver(pattern);
    solver->SetThreads(threads);
    if (device != nullptr) *device = survey.text;
    return solver;
  }
  if (device != nullptr) *device = CpuText(threads);
  return MakeLinearSolver(pattern, threads);
}

std::future<void> WakeGpus(const std::string& name) {
  return name == "cpu" ? std::future<void>() : std::async(WakeCuda);
}

std::string UsableGpu() {
  const CudaSurvey survey = SurveyCuda();
  return survey.usable ? survey.text : "";
}

}  // namespace drape
