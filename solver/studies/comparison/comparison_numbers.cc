// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/comparison_numbers.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/json_input.h"
#include "solver/posterior/posterior_io.h"

namespace drape {
namespace {

void AddFeature(const std::string& name, const FeatureScore& feature, Numbers* numbers) {
  (*numbers)[name + "_error"] = std::abs(feature.predicted_mean - feature.observed_mean);
  (*numbers)[name + "_crps"] = feature.crps;
  (*numbers)[name + "_coverage_50"] = feature.half.coverage;
  (*numbers)[name + "_width_50"] = feature.half.width;
  (*numbers)[name + "_coverage_90"] = feature.ninety.coverage;
  (*numbers)[name + "_width_90"] = feature.ninety.width;
}

// A number, or the sum of a list or an object of numbers.
double ReadSum(const JsonInput& input) {
  if (input.value().is_number()) return input.Number();
  double sum = 0.0;
  if (input.value().is_object()) {
    for (const auto& [key, value] : input.value().items()) sum += input.At(key).Number();
    return sum;
  }
  for (int i = 0; i < input.ExpectArray().Size(); ++i) sum += input.At(i).Number();
  return sum;
}

}  // namespace

Numbers ComputeNumbers(const DistributionScore& score) {
  Numbers numbers = {{"mean_image_mse", score.mean_image_mse},
                     {"feature_energy", score.feature_energy},
                     {"outline_energy_m", score.outline_energy}};
  AddFeature("dc", score.features[0], &numbers);
  AddFeature("folds", score.features[1], &numbers);
  std::erase_if(numbers, [](const auto& number) { return std::isnan(number.second); });
  return numbers;
}

Numbers FitNumbers(const nlohmann::json& summary, const std::string& where) {
  const JsonInput input(summary, where);
  const JsonInput mean = input.At("mean");
  Numbers numbers = {{"train_mse", mean.At("mse").Number()},
                     {"train_profile_rms_px", mean.At("profile_rms_px").Number()},
                     {"train_iou", mean.At("iou").Number()},
                     {"train_hausdorff_m", mean.At("outline_hausdorff_m").Number()},
                     {"fit_seconds", ReadSum(input.At("seconds"))},
                     {"rollouts", input.At("rollouts").NotNegative()},
                     {"parameters", input.At("parameters").At("count").Number()}};
  for (const char* part : {"fields", "posterior"}) {
    if (!input.Has(part)) continue;
    numbers["fit_seconds"] += ReadSum(input.At(part).At("seconds"));
    numbers["rollouts"] += input.At(part).At("rollouts").NotNegative();
  }
  if (input.Has("fields")) numbers["parameters"] = input.At("fields").At("parameters").Number();
  if (input.Has("posterior")) {
    numbers["parameters"] = input.At("posterior").At("log_factors").ExpectArray().Size();
    if (input.At("posterior").At("kind").String() == ToString(PosteriorKind::kElements))
      numbers["parameters"] *= 2;  // a mean and a deviation each
    const JsonInput elbo = input.At("posterior").At("elbo");
    if (!elbo.value().is_null()) numbers["elbo"] = elbo.Number();  // null: no sample is valid
  }
  return numbers;
}

}  // namespace drape
