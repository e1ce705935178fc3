// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"

namespace drape {

// A node (fold) of an outline: a peak that CountFolds counts, between two valleys. Peaks and
// valleys are found on the smoothed profile, radii are of the profile itself.
struct DrapeNode {
  double angle = 0.0;   // of the peak [rad]
  double radius = 0.0;  // of the peak [m]
  double height = 0.0;  // of the peak over the mean of its two valleys [m]
  double width = 0.0;   // of its base, straight from valley to valley [m]
  double severity() const { return height / width; }
};

// What laboratories read off the outline of a drape. Quantities of nodes are 0 without nodes.
struct LaboratoryDrape {
  DrapeDiscs discs;
  double drape_coefficient = 0.0;   // [%]
  std::vector<DrapeNode> nodes;     // by their angles
  double spacing_mean = 0.0;        // of neighbouring nodes [rad]
  double spacing_variation = 0.0;   // SD/mean of these, over the nodes that there are
  double severity_mean = 0.0;       // height over width at the base
  double severity_deviation = 0.0;  // SD over the nodes
  double distance_ratio = 0.0;  // drape distance ratio (R − mean r)/(R − r_s) [%] [Jeong 1998]
  double fold_depth_index = 0.0;  // mean height of the nodes over R − r_s [%]
  double amplitude_ratio = 0.0;   // half the mean height over the mean radius [%]
  double circularity = 0.0;       // 4πA/L²
};
LaboratoryDrape MeasureLaboratoryDrape(const Eigen::VectorXd& radius, const DrapeDiscs& discs);

// Where a number is from, in the words of all programs, pages and files.
inline constexpr char kMeasured[] = "measured", kFromThePrior[] = "from the prior",
                      kGiven[] = "given", kOriginNotKnown[] = "not known",
                      kMeasuredIfMass[] = "measured, if the assumed mass is right";

// A quantity as a textile laboratory reports it, in its unit: the one type in which the value, the
// interval and the origin of a number go from a fit to its verdict, sheet, page and exports.
struct LaboratoryRow {
  std::string key;  // of a CSV column, with the unit: "dc_percent"
  std::string name;
  double value = 0.0;     // the bound itself where the interval has one end only
  std::string unit = {};  // empty: none
  struct Interval {
    double low = 0.0, high = 0.0;
  };
  // The interval of 90 %. An infinite end: the data bound the quantity from the other side only.
  // None for what the data have not measured.
  std::optional<Interval> interval = {};
  std::string source = {};                 // kMeasured, kFromThePrior, …
  std::string standard = {};               // that defines it, or where the formula is from
  std::optional<double> reads_up_to = {};  // the largest value that its instrument reads

  bool Reads(double number) const { return !reads_up_to || number <= *reads_up_to; }
  bool measured() const { return source.starts_with(kMeasured); }
  // Whether its value is one bound, "at least" or "at most".
  bool is_bound() const {
    return interval && std::isinf(interval->high) != std::isinf(interval->low);
  }
  std::string ValueText() const;     // "9.52", "at least 124", "> 20"
  std::string IntervalText() const;  // "5.9 … 15.2"; empty without two ends
  // "bending rigidity B, overall 9.52 µN·m (5.9 … 15.2), measured"
  std::string Text() const;
};

struct LaboratorySheet {
  std::string title;
  std::vector<LaboratoryRow> rows;

  // The row of that key. Throws InputError that lists the keys.
  const LaboratoryRow& of(const std::string& key) const;
};

// The sheet of a drape's outline: sizes, drape coefficient, nodes and numbers from node heights.
LaboratorySheet DrapeSheet(const LaboratoryDrape& drape, const std::string& title);

// For reports: {"title", "rows": [{"key", "name", "value", "unit", "low", "high", "text",
// "interval", "source", "standard"}]}. text, interval: ValueText, IntervalText. low and high are
// null without an interval or beside a bound, whose value is null. Rows with a largest reading have
// it as "reads_up_to"; what is larger is null, and if that is the value, "note" says so.
nlohmann::ordered_json RowJson(const LaboratoryRow& row);
nlohmann::ordered_json SheetJson(const LaboratorySheet& sheet);
// The sheet `name` of the block "laboratory" of summary.json of a fit in this folder; nothing where
// there is none. Throws InputError for a file that cannot be read.
std::optional<LaboratorySheet> ReadSheet(const std::string& folder, const std::string& name);
// Writes the sheet with each node: {"angle_deg", "radius_mm", "height_mm", "width_mm", "severity"}.
nlohmann::ordered_json DrapeSheetJson(const LaboratoryDrape& drape, const std::string& title);

// For a person: the title and a line for each row, or for each that has one of the keys. What is
// beyond the largest reading N of a row is "> N".
std::string SheetText(const LaboratorySheet& sheet, const std::set<std::string>& keys = {});

}  // namespace drape
