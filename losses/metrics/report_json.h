// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "losses/camera/camera_io.h"
#include "losses/metrics/distribution_metrics.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"

namespace drape {

// The form in which the reports of all programs write the quality of an image, a comparison, the
// stability of a drape and the score of a prediction. Keys contain the unit.
nlohmann::ordered_json QualityJson(const ImageQuality& quality);
nlohmann::ordered_json MetricsJson(const SilhouetteMetrics& metrics);
// lowest_eigenvalues: the result of LowestEigenvalues [s⁻²]; an empty one is written as nulls.
nlohmann::ordered_json StabilityJson(const Eigen::VectorXd& lowest_eigenvalues);
nlohmann::ordered_json ScoreJson(const DistributionScore& score);

}  // namespace drape
