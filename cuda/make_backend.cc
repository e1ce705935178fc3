// SPDX-License-Identifier: Apache-2.0
#include "cuda/make_backend.h"

#include <utility>

#include "cuda/engine/cuda_backend.h"
#include "physics/util/errors.h"

namespace drape {

std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* choice) {
  if (name != "cpu" && name != "cuda" && name != "auto")
    throw InputError("backend", "unknown name '" + name + "', expected auto, cpu or cuda");
  const bool automatic = name == "auto";
  const CudaSurvey survey = automatic ? SurveyCuda() : CudaSurvey{name == "cuda", ""};
  std::string why = automatic ? "auto: " + survey.text : "as asked";
  std::unique_ptr<Backend> backend;
  try {
    if (survey.usable) backend = MakeCudaBackend(model, threads);
  } catch (const InputError& error) {  // a mesh that no device can factor
    if (!automatic) throw;
    why = std::string("auto: ") + error.what();
  }
  if (!backend) backend = MakeCpuBackend(std::move(model), threads);
  if (choice != nullptr) *choice = backend->name() + " (" + why + ")";
  return backend;
}

}  // namespace drape
