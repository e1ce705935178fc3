// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"

namespace drape {

// A quantity as a textile laboratory reports it, in its unit.
struct LaboratoryRow {
  std::string key;  // of a CSV column, with the unit: "dc_percent"
  std::string name;
  double value = 0.0;
  std::string unit;  // empty: none
  struct Interval {
    double low = 0.0, high = 0.0;
  };
  std::optional<Interval> interval = {};   // of 90 %
  std::string source;                      // "measured", "from the prior", "given", …
  std::string standard = {};               // that defines it, or where the formula is from
  std::optional<double> reads_up_to = {};  // the largest value that its instrument reads

  bool Reads(double number) const { return !reads_up_to || number <= *reads_up_to; }
};

struct LaboratorySheet {
  std::string title;
  std::vector<LaboratoryRow> rows;
};

// Of the outline of a drape: sizes, drape coefficient, nodes, what follows from their heights.
LaboratorySheet DrapeSheet(const LaboratoryDrape& drape, const std::string& title);

// For reports: {"title", "rows": [{"key", "name", "value", "unit", "low", "high", "source",
// "standard"}]}; low and high are null without an interval. Rows with a largest reading have it as
// "reads_up_to"; what is larger is null, and if that is the value, "note" says so.
nlohmann::ordered_json SheetJson(const LaboratorySheet& sheet);
// The same with each node: {"angle_deg", "radius_mm", "height_mm", "width_mm", "severity"}.
nlohmann::ordered_json DrapeSheetJson(const LaboratoryDrape& drape, const std::string& title);

// For a person: the title and a line for each row, or for each that has one of the keys. What is
// beyond the largest reading N of a row is "> N".
std::string SheetText(const LaboratorySheet& sheet, const std::set<std::string>& keys = {});

}  // namespace drape
