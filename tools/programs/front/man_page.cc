// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/man_page.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::json;

// The code point of the character of UTF-8 at `at`, of `length` bytes.
unsigned long CodePoint(const std::string& text, std::size_t at, std::size_t length) {
  constexpr unsigned kFirst[] = {0x7F, 0x1F, 0x0F, 0x07}, kNext = 0x3F, kNextBits = 6;
  unsigned long code = static_cast<unsigned char>(text[at]) & kFirst[length - 1];
  for (std::size_t i = 1; i < length; ++i)
    code = (code << kNextBits) | (static_cast<unsigned char>(text[at + i]) & kNext);
  return code;
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string OptionText(const json& option) {
  std::string type = option.at("type");
  for (const std::string word : option.at("words")) type += " or " + word;
  std::string facts;
  const std::string range = option.at("range"), unit = option.at("unit");
  if (!range.empty()) facts += range;
  if (!unit.empty()) facts += (facts.empty() ? "[" : " [") + unit + "]";
  const std::string value = option.at("default");
  const bool required = option.at("required");
  facts += (facts.empty() ? "" : ", ") +
           (required ? "required" : "default: " + (value.empty() ? "none" : value));
  const std::string key = option.at("key"), doc = option.at("doc");
  return ".TP\n\\fB" + RoffText("--" + key) + "\\fR=\\fI" + RoffText(type) + "\\fR\n" +
         RoffText(doc) + "\n(" + RoffText(facts) + ")\n";
}

std::string Paragraphs(const std::string& text) {
  std::istringstream lines(text);
  std::string roff;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) roff += ".PP\n" + RoffText(line) + "\n";
  return roff;
}

std::string Synopsis(const json& table) {
  std::string text = ".B " + RoffText(table.at("tool")) + "\n";
  const std::string operands = table.at("operands");
  if (!operands.empty()) text += ".I " + RoffText(operands) + "\n";
  text += RoffText("[--config=FILE]");
  for (const json& section : table.at("sections"))
    for (const json& option : section.at("options"))
      if (option.at("required"))
        text += RoffText(" --" + option.at("key").get<std::string>() + "=…");
  return text + RoffText(" [--key=value …]") + "\n";
}

}  // namespace

std::string RoffText(const std::string& text) {
  std::string roff;
  for (std::size_t i = 0, length = 0; i < text.size(); i += length) {
    length = std::max<std::size_t>(1, Utf8Length(text, i));
    if (length > 1) {
      roff += Format("\\[u%04lX]", CodePoint(text, i, length));
    } else if (text[i] == '\\') {
      roff += "\\(rs";
    } else if (text[i] == '-') {
      roff += "\\-";
    } else if ((text[i] == '.' || text[i] == '\'') && (i == 0 || text[i - 1] == '\n')) {
      roff += std::string("\\&") + text[i];
    } else {
      roff += text[i];
    }
  }
  return roff;
}

std::string ManPage(const json& table, const std::string& see_also, const std::string& body) {
  const std::string tool = table.at("tool"), version = table.at("version");
  std::string page = ".\\\" Made from the option table of " + tool + ".\n.TH " + Upper(tool) +
                     " 1 \"\" \"drapefit " + version + "\" \"User commands\"\n.SH NAME\n" +
                     RoffText(tool) + " \\- " + RoffText(table.at("summary")) + "\n.SH SYNOPSIS\n" +
                     Synopsis(table) + body + ".SH OPTIONS\n";
  for (const json& section : table.at("sections")) {
    page += ".SS " + RoffText(section.at("title")) + "\n";
    for (const json& option : section.at("options")) page += OptionText(option);
  }
  page += ".SH EXAMPLES\n.nf\n" + RoffText(table.at("example")) + "\n.fi\n.SH NOTES\n" +
          Paragraphs(table.at("notes"));
  return page + ".SH SEE ALSO\n" + RoffText(see_also) + "\n";
}

}  // namespace drape
