// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace drape::attack {

// What --help=all says of an option, so that a new option is attacked without a change here.

enum class OptionType { kText, kPath, kInteger, kNumber, kSwitch, kChoice };

struct ListedOption {
  std::string key;
  OptionType type = OptionType::kText;
  bool is_list = false;
  std::vector<std::string> choices = {};
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;
  bool required = false;
};

// Throws std::runtime_error for a line that begins an option and is not understood.
std::vector<ListedOption> ParseHelp(const std::string& help);

// A value that an option is given. `refused`: it is bad whatever else is given.
struct OptionValue {
  std::string text;
  bool refused = false;
};

// Bad, extreme and hostile values for its type and range.
std::vector<OptionValue> MakeValues(const ListedOption& option);

}  // namespace drape::attack
