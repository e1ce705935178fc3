// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/option_text.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/stored/build.h"

namespace drape {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

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

nlohmann::json ValueJson(const Option& option) {
  return std::visit(Overloaded{[](const EnumField& v) { return nlohmann::json(v.name()); },
                               [](const auto* v) { return nlohmann::json(*v); }},
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
                 [&](const std::vector<std::string>*) {
                   return "list of " +
                          (option.choices.empty() ? text + "s" : JoinChoices(option.choices, "|"));
                 }},
      option.value);
}

// The space at which to break a line of UTF-8 of more than 100 columns; npos for a shorter line.
std::size_t FindBreak(const std::string& line) {
  constexpr int kColumns = 100;
  const std::size_t begin = line.find_first_not_of(' ');
  std::size_t last_space = std::string::npos;
  int columns = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == ' ' && i > begin) last_space = i;
    if ((line[i] & 0xC0) != 0x80 && ++columns > kColumns) return last_space;
  }
  return std::string::npos;
}

// Breaks long lines; what is left of one begins with `indent`.
std::string Wrap(const std::string& text, const std::string& indent) {
  std::istringstream lines(text);
  std::string wrapped;
  for (std::string line; std::getline(lines, line); wrapped += line + "\n") {
    for (std::size_t at = 0; (at = FindBreak(line)) != std::string::npos;) {
      wrapped += line.substr(0, at) + "\n";
      line = indent + line.substr(at + 1);
    }
  }
  return wrapped;
}

// Words that are no paths; one that ends in a colon is a prefix.
std::string WordsText(const std::vector<std::string>& words) {
  return Join(words, ", ", [](std::string& text, const std::string& word) {
    text += word;
    if (word.back() == ':') text += "…";
  });
}

// "  --key  <number>, 0 … 5 [m], default: 1", and what it means.
std::string Describe(const Option& option) {
  std::string text = "  --" + option.key + "  <" + TypeText(option) + ">";
  if (!option.words.empty()) text += " or " + WordsText(option.words);
  const std::string range = RangeText(option), value = ValueText(option);
  if (!range.empty()) text += ", " + range;
  if (!option.unit.empty()) text += " [" + option.unit + "]";
  text += option.required ? ", required" : ", default: " + (value.empty() ? "none" : value);
  return Wrap(text + "\n      " + option.doc, "      ");
}

// Options and their headings, in the order in which they are shown.
struct HelpSection {
  std::string title;
  std::vector<const Option*> options;
};

HelpSection CommonSection(const OptionTable& table) {
  HelpSection section{"common options", {}};
  for (const std::string& key : table.common) {
    const Option* option = table.Find(key);
    CHECK(option != nullptr) << table.tool << " has no option " << key;
    section.options.push_back(option);
  }
  return section;
}

// The options that are not in `shown`, by their groups.
std::vector<HelpSection> OtherSections(const OptionTable& table, const HelpSection& shown) {
  std::vector<HelpSection> sections;
  for (const Option& option : table.options) {
    if (std::find(shown.options.begin(), shown.options.end(), &option) != shown.options.end())
      continue;
    const std::string title = option.group.empty() ? "options" : option.group;
    const auto same = std::find_if(sections.begin(), sections.end(),
                                   [&](const HelpSection& one) { return one.title == title; });
    if (same == sections.end()) {
      sections.push_back({title, {&option}});
    } else {
      same->options.push_back(&option);
    }
  }
  return sections;
}

std::string SectionText(const HelpSection& section) {
  std::string text = section.title + ":\n";
  for (const Option* option : section.options) text += Describe(*option);
  return text + "\n";
}

std::string OptionsText(const OptionTable& table, HelpScope scope) {
  const HelpSection common = CommonSection(table);
  const std::vector<HelpSection> others = OtherSections(table, common);
  std::string text = table.common.empty() ? "" : SectionText(common), titles;
  if (scope == HelpScope::kAll || table.common.empty()) {
    for (const HelpSection& section : others) text += SectionText(section);
    return text;
  }
  for (const HelpSection& section : others) titles += (titles.empty() ? "" : "; ") + section.title;
  const std::size_t count = table.options.size() - common.options.size();
  return text + Wrap(std::to_string(count) + " more with --help=all: " + titles, "  ") + "\n";
}

constexpr char kCommonNotes[] =
    "exit codes: 0 done, 2 bad input (one line on stderr, earlier results are unchanged), "
    "130 cancelled by Ctrl-C\n"
    "--config: JSON file with any of these keys (// comments allowed); its paths are relative to "
    "its folder; options of the command line take precedence. A summary of an earlier run: its "
    "options again, which repeats it\n"
    "--version: the version. The environment variable GLOG_v=1 shows more messages.\n";

}  // namespace

std::string JoinChoices(const std::vector<std::string>& choices, const char* separator) {
  return Join(choices, separator,
              [](std::string& text, const std::string& choice) { text += choice; });
}

std::string RangeText(const Option& option) {
  const FieldRange& range = option.range;
  const std::string least = NumberText(range.least), most = NumberText(range.most);
  const std::string above = range.above_least ? "> " : "≥ ";
  if (!least.empty() && !most.empty()) {
    return range.above_least ? above + least + " and ≤ " + most : least + " … " + most;
  }
  if (!least.empty()) return above + least;
  return most.empty() ? "" : "≤ " + most;
}

std::vector<Option> Grouped(const std::string& group, std::vector<Option> options) {
  for (Option& option : options) option.group = group;
  return options;
}

std::vector<Option> OfOneRun(std::vector<Option> options) {
  for (Option& option : options) option.repeated = false;
  return options;
}

namespace {

std::string UsageText(const OptionTable& table) {
  std::string usage =
      table.tool + (table.operands ? " " + table.operand_names : "") + " [--config=FILE]";
  for (const Option& option : table.options)
    if (option.required) usage += " --" + option.key + "=…";
  return usage + " [--key=value …]";
}

// A text as roff shows it as it is.
std::string RoffText(const std::string& text) {
  std::string roff;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins_line = i == 0 || text[i - 1] == '\n';
    if (begins_line && (text[i] == '.' || text[i] == '\'')) roff += "\\&";
    if (text[i] == '-') roff += '\\';
    roff += text[i] == '\\' ? "\\(rs" : std::string(1, text[i]);
  }
  return roff;
}

}  // namespace

std::string ManPage(const OptionTable& table) {
  return ".\\\" -*- coding: UTF-8 -*-\n.TH " + table.tool + " 1 \"\" \"drapefit " + BuildVersion() +
         "\" \"User commands\"\n.SH NAME\n" + RoffText(table.tool) + " \\- " +
         RoffText(table.summary) + "\n.SH OPTIONS\n.nf\n" + RoffText(table.Help(HelpScope::kAll)) +
         ".fi\n.SH SEE ALSO\ndrapefit(1)\n";
}

std::string OptionTable::Help(HelpScope scope) const {
  const std::string heading = tool + " " + BuildVersion() + ": " + summary +
                              "\n\nusage: " + UsageText(*this) + "\nexample: " + example + "\n\n";
  return Wrap(heading, "  ") + OptionsText(*this, scope) + Wrap(notes + kCommonNotes, "  ");
}

}  // namespace drape
