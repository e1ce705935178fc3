// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "losses/camera.h"
#include "losses/metrics.h"

namespace drape {

// How the reports of all programs write a camera and a comparison, keys with units.
nlohmann::ordered_json CameraJson(const Camera& camera);
nlohmann::ordered_json MetricsJson(const SilhouetteMetrics& metrics);

}  // namespace drape
