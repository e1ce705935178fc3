// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/validation/recovery.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/quantile.h"
#include "physics/util/text_format.h"
#include "solver/fit/parameters/effective_stiffness.h"
#include "solver/fit/parameters/stiffness_list.h"
#include "solver/job/fit_verdict.h"
#include "solver/job/plot/chart.h"

namespace drape {
namespace {

struct Row {
  const char *key, *label;
};
// Those of ListStiffness that differ by more than the weight, from what a drape shows to what it
// does not.
constexpr Row kRows[] = {{"bending_length_m", "bending length"},
                         {"bend_n_m", "bend, as it drapes"},
                         {"bend_along_warp_n_m", "bend, warp edges"},
                         {"bend_along_weft_n_m", "bend, weft edges"},
                         {"bend_at_45_deg_n_m", "bend, 45 deg edges"},
                         {"c33_n_per_m", "shear c33"},
                         {"c11_n_per_m", "stretch c11"},
                         {"c22_n_per_m", "stretch c22"}};

// 0 where fits claim nothing about the quantity.
double ClaimedFactor(const std::string& key, const JsonInput& verdict) {
  const bool is_length = key == "bending_length_m";
  if (!is_length && key != "bend_n_m") return 0.0;
  const double factor = verdict.At("bend_n_m").At("factor_90").Number();
  return is_length ? std::cbrt(factor) : factor;
}

double Height(std::size_t row) { return static_cast<double>(row + 1); }

}  // namespace

double RecoveredQuantity::Quantile(double share) const { return drape::Quantile(ratios, share); }

Recovery ReadRecovery(const std::vector<std::string>& folders) {
  Recovery recovery;
  std::vector<std::vector<double>> claims(std::size(kRows));
  for (const Row& row : kRows) recovery.quantities.push_back({.name = row.label});
  for (const std::string& folder : folders) {
    const std::string path = folder + "/summary.json";
    const nlohmann::json file = ReadJsonFile(path);
    const JsonInput summary(file, path), verdict = summary.At("verdict");
    if (verdict.At("grade").String() == ToString(FitGrade::kDoNotUse)) {
      ++recovery.left_out;
      continue;
    }
    const JsonInput stiffness = summary.At("stiffness");
    for (std::size_t i = 0; i < std::size(kRows); ++i) {
      const JsonInput quantity = stiffness.At(kRows[i].key);
      if (!quantity.Has("reference"))
        throw InputError(path, "has no reference, expected a fit with --ground_truth");
      recovery.quantities[i].ratios.push_back(quantity.At("fitted").Number() /
                                              quantity.At("reference").Number());
      claims[i].push_back(ClaimedFactor(kRows[i].key, verdict));
    }
    ++recovery.fits;
  }
  if (recovery.fits == 0)
    throw InputError(folders.front(), "none of " + std::to_string(folders.size()) +
                                          " fits is usable, expected one at least");
  for (std::size_t i = 0; i < claims.size(); ++i) {
    std::sort(claims[i].begin(), claims[i].end());
    std::sort(recovery.quantities[i].ratios.begin(), recovery.quantities[i].ratios.end());
    recovery.quantities[i].claimed_factor = Quantile(claims[i], 0.5);
  }
  return recovery;
}

std::string RecoveryText(const Recovery& recovery) {
  std::string text = Format("%d fits of known fabrics, %d more left out as not to be used\n",
                            recovery.fits, recovery.left_out);
  text += Format("%-24s %8s %8s %8s %10s %8s\n", "fitted/reference", "5 %", "median", "95 %",
                 "claimed", "inside");
  for (const RecoveredQuantity& quantity : recovery.quantities) {
    text += Format("%-24s %8.2f %8.2f %8.2f", quantity.name.c_str(), quantity.Quantile(0.05),
                   quantity.Quantile(0.5), quantity.Quantile(0.95));
    if (const double factor = quantity.claimed_factor; factor > 0.0) {
      const auto inside =
          std::count_if(quantity.ratios.begin(), quantity.ratios.end(),
                        [&](double ratio) { return ratio <= factor && ratio >= 1.0 / factor; });
      text += Format("   to %.2f x %7.0f %%", factor,
                     100.0 * static_cast<double>(inside) / recovery.fits);
    }
    text += "\n";
  }
  return text;
}

void RenderRecovery(const Recovery& recovery, const std::string& path) {
  constexpr char kTeal[] = "#21918c", kGrey[] = "#aaaaaa", kRed[] = "#d62728";
  constexpr double kBar = 0.22, kClaim = 0.4;  // below the dots
  const double rows = Height(recovery.quantities.size());
  Chart chart{.x = {.label = "fitted / reference", .log = true, .range = {{0.1, 10.0}}},
              .y = {.range = {{rows - 0.3, 0.5}}},
              .key = KeyPlace::kNone,
              .box = ChartBox{0.29, 0.97, 0.19, 0.86}};
  chart.x.ticks = {{0.1, "0.1"}, {0.2, "0.2"}, {0.5, "0.5"}, {1, "1"},
                   {2, "2"},     {5, "5"},     {10, "10"}};
  chart.y.ticks.emplace();
  const double left = chart.x.range->first, right = chart.x.range->second;
  const auto line = [&](double from, double to, double height, const char* colour, double width) {
    chart.series.push_back(
        {.points = {{std::clamp(from, left, right), height}, {std::clamp(to, left, right), height}},
         .colour = colour,
         .width = width});
  };
  chart.series.push_back(
      {.points = {{1.0, 0.5}, {1.0, rows - 0.3}}, .colour = "#555555", .width = 1.0});
  ChartSeries fits{.mark = Mark::kPoints, .colour = kGrey, .size = 0.6};
  ChartSeries medians{.mark = Mark::kPoints, .colour = kTeal, .size = 1.2};
  for (std::size_t i = 0; i < recovery.quantities.size(); ++i) {
    const RecoveredQuantity& quantity = recovery.quantities[i];
    const double height = Height(i);
    chart.y.ticks->emplace_back(height, quantity.name);
    for (const double ratio : quantity.ratios)
      fits.points.emplace_back(std::clamp(ratio, left, right), height);
    medians.points.emplace_back(std::clamp(quantity.Quantile(0.5), left, right), height + kBar);
    line(quantity.Quantile(0.05), quantity.Quantile(0.95), height + kBar, kTeal, 3.0);
    if (const double factor = quantity.claimed_factor; factor > 0.0)
      line(1.0 / factor, factor, height + kClaim, kRed, 3.0);
  }
  chart.series.push_back(std::move(fits));
  chart.series.push_back(std::move(medians));
  chart.labels.push_back(
      {.text = Format("dots: %d fits of drapes of known fabrics; green: median and 90 %% of them; "
                      "red: the 90 %% interval that fits state",
                      recovery.fits),
       .at = {0.02, 0.91},
       .in_picture = true,
       .font_size = 8});
  WritePicture(path, {.title = "Which numbers of a fit can be trusted?",
                      .width = 640,
                      .height = 440,
                      .charts = {std::move(chart)}});
}

}  // namespace drape
