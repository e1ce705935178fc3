// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "losses/metrics/distribution_metrics.h"

namespace drape {

// What models are compared by: names, units, and where they are read from.

struct ComparedNumber {
  const char* key;    // of CSV and JSON, SI units
  const char* label;  // for a person
  double unit;        // of the label's unit
};

inline constexpr double kMilli = 1e-3;
inline constexpr std::array<ComparedNumber, 32> kComparedNumbers = {{
    // The fit on its own images.
    {"train_mse", "fit: silhouette MSE", 1},
    {"train_profile_rms_px", "fit: outline rms [px]", 1},
    {"train_iou", "fit: IoU", 1},
    {"train_hausdorff_m", "fit: outline Hausdorff [mm]", kMilli},
    // Drapes drawn from it, against held-out captures (DistributionScore).
    {"mean_image_mse", "held out: MSE of the mean image", 1},
    {"dc_error", "held out: error of the mean DC", 1},
    {"dc_crps", "held out: CRPS of DC", 1},
    {"dc_coverage_50", "held out: DC in 50 % intervals", 1},
    {"dc_width_50", "held out: their width", 1},
    {"dc_coverage_90", "held out: DC in 90 % intervals", 1},
    {"dc_width_90", "held out: their width", 1},
    {"folds_error", "held out: error of the mean folds", 1},
    {"folds_crps", "held out: CRPS of folds", 1},
    {"folds_coverage_50", "held out: folds in 50 % intervals", 1},
    {"folds_width_50", "held out: their width", 1},
    {"folds_coverage_90", "held out: folds in 90 % intervals", 1},
    {"folds_width_90", "held out: their width", 1},
    {"feature_energy", "held out: energy score of features", 1},
    {"outline_energy_m", "held out: energy score of outlines [mm]", kMilli},
    {"hausdorff_m", "held out: outline Hausdorff of pairs [mm]", kMilli},
    // What the calibration did (CalibrateBend), and the same numbers without it.
    {"bend_factor_up", "calibrated: factor on bend, face up", 1},
    {"bend_factor_down", "calibrated: factor on bend, face down", 1},
    {"mean_image_mse_as_fitted", "as fitted: MSE of the mean image", 1},
    {"dc_error_as_fitted", "as fitted: error of the mean DC", 1},
    {"dc_coverage_90_as_fitted", "as fitted: DC in 90 % intervals", 1},
    {"feature_energy_as_fitted", "as fitted: energy score of features", 1},
    // What it takes.
    {"fit_seconds", "fit [s]", 1},
    {"calibration_seconds", "calibration [s]", 1},
    {"prediction_seconds", "prediction [s]", 1},
    {"rollouts", "rollouts of the fit", 1},
    {"parameters", "free numbers", 1},
    {"elbo", "evidence lower bound [nat]", 1},
}};

// By key of kComparedNumbers; one that a model does not have is not there.
using Numbers = std::map<std::string, double>;

// Errors are absolute values of the mean predicted less the mean observed.
Numbers ComputeNumbers(const DistributionScore& score);

// Of summary.json of drape_fit. Throws InputError (prefix `where`) for what is no such file.
Numbers FitNumbers(const nlohmann::json& summary, const std::string& where);

}  // namespace drape
