// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/cuda_backend.h"
#include "physics/errors.h"

namespace drape {

std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* choice) {
  if (name != "cpu" && name != "cuda" && name != "auto")
    throw InputError("backend", "unknown name '" + name + "', expected auto, cpu or cuda");
  const CudaSurvey survey = name == "auto" ? SurveyCuda() : CudaSurvey{};
  const bool cuda = name == "cuda" || survey.usable;
  if (choice != nullptr) {
    *choice = cuda ? "cuda" : "cpu";
    *choice += name != "auto" ? " (as asked)" : " (auto: " + survey.text + ")";
  }
  return cuda ? MakeCudaBackend(std::move(model), threads)
              : MakeCpuBackend(std::move(model), threads);
}

}  // namespace drape
