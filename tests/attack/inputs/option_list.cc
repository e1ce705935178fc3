// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/option_list.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace drape::attack {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// "list of numbers" → number, list.
void ReadType(std::string type, ListedOption* option) {
  constexpr char kListOf[] = "list of ";
  option->is_list = type.rfind(kListOf, 0) == 0;
  if (option->is_list) type = type.substr(sizeof kListOf - 1, type.size() - sizeof kListOf);
  if (type == "integer")
    option->type = OptionType::kInteger;
  else if (type == "number")
    option->type = OptionType::kNumber;
  else if (type == "switch")
    option->type = OptionType::kSwitch;
  else if (type == "path")
    option->type = OptionType::kPath;
  else if (type == "text")
    option->type = OptionType::kText;
  else if (!type.empty() && !Contains(type, " ")) {  // "smooth|reference", or one name alone
    option->type = OptionType::kChoice;
    option->choices = Split(type, '|');
  } else {
    throw std::runtime_error("--help=all: type <" + type + "> of --" + option->key);
  }
}

// "> 0 and ≤ 10", "≥ 0", "0 … 1000" in what follows the type.
void ReadRange(const std::string& text, ListedOption* option) {
  const auto number_after = [&](const std::string& sign, double* value) {
    const auto at = text.find(sign);
    if (at != std::string::npos) *value = std::stod(text.substr(at + sign.size()));
    return at != std::string::npos;
  };
  const auto between = text.find(" … ");
  if (between != std::string::npos) {
    const auto begin = text.rfind(' ', between - 1) + 1;
    option->least = std::stod(text.substr(begin, between - begin));
    option->most = std::stod(text.substr(between + std::string(" … ").size()));
    return;
  }
  option->above_least = number_after("> ", &option->least);
  number_after("≥ ", &option->least);
  number_after("≤ ", &option->most);
}

ListedOption ReadOption(const std::string& line) {
  const auto begin = line.find('<'), end = line.find('>', begin);
  ListedOption option;
  option.key = line.substr(4, line.find(' ', 4) - 4);
  ReadType(line.substr(begin + 1, end - begin - 1), &option);
  const auto value = std::min(line.find(", default: ", end), line.find(", required", end));
  const std::string rest = line.substr(end + 1, value - end - 1);
  option.required = line.find(", required", end) == value && value != std::string::npos;
  if (option.type == OptionType::kInteger || option.type == OptionType::kNumber)
    ReadRange(rest, &option);
  return option;
}

using Values = std::vector<OptionValue>;

void Append(Values* values, const Values& more) {
  values->insert(values->end(), more.begin(), more.end());
}

std::string NumberText(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

bool IsWithin(double value, const ListedOption& option) {
  return value <= option.most &&
         (option.above_least ? value > option.least : value >= option.least);
}

// A number is refused outside its range; inside, another option may forbid it.
Values MakeNumbersIn(const ListedOption& option, const std::vector<double>& numbers) {
  Values values;
  for (const double number : numbers)
    values.push_back({NumberText(number), !IsWithin(number, option)});
  return values;
}

Values MakeNoNumbers() {
  Values values;
  for (const char* text : {"",
                           "abc",
                           "nan",
                           "NaN",
                           "inf",
                           "-inf",
                           "Infinity",
                           "1e999",
                           "0x10",
                           " 1",
                           "1 ",
                           "+1",
                           "1e",
                           "--",
                           "1;2",
                           "1\n2",
                           "1\xc2\xa0",
                           "\xef\xbc\x91",
                           "99999999999999999999999999999999999x",
                           "%s%n",
                           "1\x1b[31m"})
    values.push_back({text, true});
  return values;
}

std::vector<double> MakeEdges(const ListedOption& option) {
  std::vector<double> edges;
  const double step = option.type == OptionType::kInteger ? 1.0 : 0.0;
  for (const double edge : {option.least, option.most}) {
    if (!std::isfinite(edge)) continue;
    edges.push_back(edge);
    edges.push_back(step > 0 ? edge - step : std::nextafter(edge, -1e300));
    edges.push_back(step > 0 ? edge + step : std::nextafter(edge, 1e300));
  }
  return edges;
}

Values MakeIntegers(const ListedOption& option) {
  Values values = MakeNoNumbers();
  Append(&values, MakeNumbersIn(option, {0, 1, 2, -1, 7, 31, 1000000, 2147483647, -2147483648.0}));
  Append(&values, MakeNumbersIn(option, MakeEdges(option)));
  for (const char* text : {"1.5", "1e3", "2147483648", "-2147483649", "9223372036854775808"})
    values.push_back({text, true});
  return values;
}

Values MakeNumbers(const ListedOption& option) {
  Values values = MakeNoNumbers();
  Append(&values, MakeNumbersIn(option, {0, -0.0, 1, -1, 0.5, 1e-6, 1e6, 1e20, -1e20, 1e-30, 1e154,
                                         1e300, 1e-300, -1e-300, 1.7976931348623157e308, 5e-324}));
  Append(&values, MakeNumbersIn(option, MakeEdges(option)));
  return values;
}

Values MakeTexts() {
  Values values;
  for (const char* text : {"",
                           " ",
                           "/",
                           ".",
                           "..",
                           "\n",
                           "\x1b[31mred\x1b[0m",
                           "\x1b]0;title\x07",
                           "\xff\xfe",
                           "a`touch PLANTED`b",
                           "$(touch PLANTED)",
                           "a;touch PLANTED",
                           "|touch PLANTED",
                           "a'b\"c",
                           "%s%s%n",
                           "a#b",
                           "a,b",
                           "\xe2\x80\xae",
                           "-",
                           "--out",
                           "*",
                           "?",
                           "[",
                           "[a",
                           "{a,b}",
                           "~",
                           "a\tb",
                           "a\rb"})
    values.push_back({text});
  values.push_back({std::string(300, 'L')});
  values.push_back({std::string(5000, 'x')});
  return values;
}

// Where results go must stay within the sandbox, whatever rights the attack has.
bool LeavesFolder(const OptionValue& value) {
  return value.text.rfind('/', 0) == 0 || Contains(value.text, "..");
}

Values MakeResultPaths() {
  Values values = MakeTexts();
  std::erase_if(values, LeavesFolder);
  for (const char* text : {"no/such/folder", "here", "here/", "./here", "here/notes.txt"})
    values.push_back({text});
  for (const char* text : {"here/notes.txt/x", "/dev/full/x", "/proc/x", "/dev/null/x"})
    values.push_back({text, true});
  return values;
}

Values MakePaths(const ListedOption& option) {
  for (const char* result : {"out", "csv", "statistics", "overlay", "table", "save_split"})
    if (option.key == result) return MakeResultPaths();
  Values values = MakeTexts();
  for (const char* text : {"/no/such",
                           "no/such.json",
                           "here",
                           "disc:",
                           "disc:0",
                           "disc:-1",
                           "disc:1e9",
                           "disc:99999999999",
                           "disc:100,radius=nan",
                           "disc:100,radius=1e300",
                           "disc:100,radius=0.1,support=0.2",
                           "disc:100,radius=",
                           "disc:100,,",
                           "strip:1x1",
                           "strip:1e300x1x2",
                           "strip:0.1x0.1x1000000",
                           "strip:-1x1x4",
                           "disc:100,radius=1e-300",
                           "disc:200000",
                           "file.json#",
                           "#",
                           "a.json#b#c",
                           "/dev/null",
                           "/dev/zero",
                           "/proc/self/mem",
                           "/dev/full"})
    values.push_back({text});
  return values;
}

Values MakeSwitches() {
  Values values;
  for (const char* text : {"", "yes", "TRUE", "2", "-1", "on", "tru", "true ", "0x1", "\x1b[31m"})
    values.push_back({text, true});
  for (const char* text : {"true", "false", "1", "0"}) values.push_back({text});
  return values;
}

Values MakeChoices(const ListedOption& option) {
  Values values = MakeTexts();
  for (OptionValue& value : values) value.refused = true;
  for (const std::string& choice : option.choices) {
    values.push_back({choice});
    values.push_back({choice + " ", true});
    if (!option.is_list) values.push_back({choice + "," + choice, true});
    std::string upper = choice;
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (upper != choice) values.push_back({upper, true});
  }
  return values;
}

// Of items that are lists of one, and lists of them.
Values MakeLists(const Values& items, const std::string& good) {
  Values values = items;
  for (OptionValue& value : values)
    if (value.text.empty()) value.refused = false;  // no item
  for (const char* text : {",", ",,", ",x,", "1,,2"}) values.push_back({text, good == "1"});
  for (const OptionValue& item : items)
    if (item.refused && item.text != "" && item.text.size() < 40)
      values.push_back({good + "," + item.text, true});
  std::string many = good;
  for (int i = 0; i < 2000; ++i) many += "," + good;
  values.push_back({many});
  return values;
}

}  // namespace

std::vector<ListedOption> ParseHelp(const std::string& help) {
  std::vector<ListedOption> options;
  std::istringstream lines(help);
  std::string option, line;
  const auto finish = [&] {
    if (!option.empty()) options.push_back(ReadOption(option));
    option.clear();
  };
  while (std::getline(lines, line)) {
    const bool begins = line.rfind("  --", 0) == 0 && line.find("  <") == line.find(' ', 2);
    if (begins && line.find("  <") != std::string::npos) {
      finish();
      option = line;
    } else if (!option.empty() && line.rfind("      ", 0) == 0) {
      option += " " + line.substr(6);
    } else {
      finish();
    }
  }
  finish();
  if (options.empty()) throw std::runtime_error("--help=all lists no options");
  return options;
}

std::vector<OptionValue> MakeValues(const ListedOption& option) {
  switch (option.type) {
    case OptionType::kInteger: {
      const Values values = MakeIntegers(option);
      return option.is_list ? MakeLists(values, "1") : values;
    }
    case OptionType::kNumber: {
      const Values values = MakeNumbers(option);
      return option.is_list ? MakeLists(values, "1") : values;
    }
    case OptionType::kSwitch:
      return MakeSwitches();
    case OptionType::kChoice:
      return option.is_list ? MakeLists(MakeChoices(option), option.choices.front())
                            : MakeChoices(option);
    case OptionType::kPath:
      return option.is_list ? MakeLists(MakePaths(option), "no") : MakePaths(option);
    case OptionType::kText:
      return option.is_list ? MakeLists(MakeTexts(), "no") : MakeTexts();
  }
  return {};
}

}  // namespace drape::attack
