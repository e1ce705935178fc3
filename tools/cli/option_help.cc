// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "physics/util/atomic_file.h"
#include "tools/cli/option_text.h"
#include "tools/cli/versions.h"

namespace drape {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

template <class Range, class Append>
std::string Join(const Range& range, const char* separator, Append append) {
  std::string text;
  bool first = true;
  for (const auto& item : range) {
    if (!first) text += separator;
    first = false;
    append(text, item);
  }
  return text;
}

std::string NumberText(double value) {
  std::string text;
  constexpr double kReadable = 1e9;  // whole numbers up to it without an exponent
  if (std::fabs(value) <= kReadable && value == std::trunc(value)) {
    return std::to_string(static_cast<long>(value));
  }
  if (std::isfinite(value)) AppendNumber(text, value);
  return text;
}

}  // namespace

std::string ValueText(const Option& option) {
  const auto append_number = [](std::string& text, auto value) { text += NumberText(value); };
  const auto append_text = [](std::string& text, const std::string& value) { text += value; };
  return std::visit(
      Overloaded{[](const std::string* v) { return *v; },
                 [](const EnumField& v) { return v.name(); },
                 [](const bool* v) { return std::string(*v ? "true" : "false"); },
                 [](const int* v) { return NumberText(*v); },
                 [](const double* v) { return NumberText(*v); },
                 [&](const std::vector<std::string>* v) { return Join(*v, ",", append_text); },
                 [&](const auto* v) { return Join(*v, ",", append_number); }},
      option.value);
}

namespace {

std::string TypeText(const Option& option) {
  const std::string text = option.is_path ? "path" : "text";
  return std::visit(
      Overloaded{[&](const std::string*) {
                   return option.choices.empty() ? text : JoinChoices(option.choices, "|");
                 },
                 [&](const EnumField&) { return JoinChoices(option.choices, "|"); },
                 [](const bool*) { return std::string("switch"); },
                 [](const int*) { return std::string("integer"); },
                 [](const double*) { return std::string("number"); },
                 [](const std::vector<int>*) { return std::string("list of integers"); },
                 [](const std::vector<double>*) { return std::string("list of numbers"); },
                 [&](const std::vector<std::string>*) { return "list of " + text + "s"; }},
      option.value);
}

std::string Describe(const Option& option) {
  std::string text = "  --" + option.key + "  <" + TypeText(option) + ">";
  if (!option.words.empty()) text += " or " + JoinChoices(option.words, "…, ");
  const std::string range = RangeText(option), value = ValueText(option);
  if (!range.empty()) text += ", " + range;
  if (!option.unit.empty()) text += " [" + option.unit + "]";
  if (option.required) {
    text += ", required";
  } else {
    text += value.empty() ? ", default: none" : ", default: " + value;
  }
  return text + "\n      " + option.doc + "\n";
}

}  // namespace

std::string JoinChoices(const std::vector<std::string>& choices, const char* separator) {
  return Join(choices, separator,
              [](std::string& text, const std::string& choice) { text += choice; });
}

std::string RangeText(const Option& option) {
  const std::string least = NumberText(option.least), most = NumberText(option.most);
  const std::string above = option.above_least ? "> " : "≥ ";
  if (!least.empty() && !most.empty()) {
    return option.above_least ? above + least + " and ≤ " + most : least + " … " + most;
  }
  if (!least.empty()) return above + least;
  return most.empty() ? "" : "≤ " + most;
}

std::string OptionTable::Help() const {
  std::string usage = "usage: " + tool + (operands ? " " + operand_names : "") + " [--config=FILE]";
  for (const Option& option : options)
    if (option.required) usage += " --" + option.key + "=…";
  std::string text =
      tool + " " + DrapefitVersion() + ": " + summary + "\n\n" + usage +
      " [--key=value …]\nexample: " + example + "\n\n" +
      "  --config  <path>, default: none\n"
      "      JSON file with any of the keys below (// comments allowed); its paths are "
      "relative to its folder; options of the command line take precedence\n";
  for (const Option& option : options) text += Describe(option);
  return text + "  --help, --version\n\n" + notes +
         "exit codes: 0 done, 2 bad input (one line on stderr, earlier results are unchanged), 130 "
         "cancelled by Ctrl-C\nThe flags --v, --vmodule, --logtostderr, --minloglevel and "
         "--log_dir of glog work as "
         "well.\n";
}

}  // namespace drape
