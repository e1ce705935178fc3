// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/html_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "physics/util/stored/csv_log.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

void Replace(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

std::string Trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// "12", "-3.1e-5", "0.1 … 0.2", "0.4 ± 0.1", "0.4 [0.3, 0.5]", "6/6", "45 %", "–", "none": what is
// read from below is aligned to the right.
bool LooksLikeNumber(std::string text) {
  if (text == "none") return true;
  for (const char* mark : {"…", "±", "–", "×"}) Replace(text, mark, "/");
  return !text.empty() && text.find_first_of("0123456789/") != std::string::npos &&
         text.find_first_not_of("0123456789+-.eE/%[], ") == std::string::npos;
}

Cell GuessCell(const std::string& text) {
  return {text, LooksLikeNumber(text) ? Cell::Kind::kNumber : Cell::Kind::kText};
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(Trimmed(line));
  return lines;
}

// "| a | b |" → a, b.
std::vector<std::string> MarkdownCells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(Trimmed(cell));
  if (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

// "**x**" of an escaped text → "<strong>x</strong>".
std::string WithBold(std::string text) {
  constexpr char kMark[] = "**";
  for (std::size_t open = 0; (open = text.find(kMark, open)) != std::string::npos;) {
    const std::size_t close = text.find(kMark, open + 2);
    if (close == std::string::npos) break;
    text.replace(close, 2, "</strong>");
    text.replace(open, 2, "<strong>");
  }
  return text;
}

bool IsRule(const std::string& line) { return line.find_first_not_of("|-: ") == std::string::npos; }

std::string MarkdownTable(const std::vector<std::string>& lines, std::size_t first,
                          std::size_t last) {
  std::vector<CellRow> rows;
  for (std::size_t i = first + 1; i < last; ++i) {
    if (IsRule(lines[i])) continue;
    CellRow row;
    for (const std::string& cell : MarkdownCells(lines[i])) {
      row.push_back(GuessCell(cell));
      row.back().markdown = true;
    }
    rows.push_back(std::move(row));
  }
  return HtmlTable("", MarkdownCells(lines[first]), rows);
}

void AddFlatRows(const nlohmann::json& value, const std::string& path, std::vector<CellRow>& rows) {
  constexpr std::size_t kMostItems = 12;
  const auto is_plain = [](const nlohmann::json& item) { return !item.is_structured(); };
  if (value.is_object()) {
    for (const auto& [key, item] : value.items())
      AddFlatRows(item, path.empty() ? key : path + " · " + key, rows);
  } else if (value.is_array() && value.size() <= kMostItems &&
             !std::all_of(value.begin(), value.end(), is_plain)) {
    for (std::size_t i = 0; i < value.size(); ++i)
      AddFlatRows(value[i], path + " · " + std::to_string(i + 1), rows);
  } else if (value.is_array() && value.size() > kMostItems) {
    rows.push_back({{path, Cell::Kind::kHeader}, {Format("%zu values", value.size())}});
  } else {
    rows.push_back({{path, Cell::Kind::kHeader}, {ValueText(value)}});
  }
}

// Only a long text may be broken into lines.
const char* ChooseClass(const Cell& cell) {
  constexpr std::size_t kLong = 40;
  switch (cell.kind) {
    case Cell::Kind::kNumber:
      return "number";
    case Cell::Kind::kMeasured:
      return "measured";
    case Cell::Kind::kPrior:
      return "prior";
    default:
      return cell.text.size() > kLong ? "text" : "";
  }
}

std::string HtmlCell(const Cell& cell) {
  const std::string html = HtmlElement("td", cell.text, ChooseClass(cell));
  return cell.markdown ? WithBold(html) : html;
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : MakePrintable(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string ScriptJson(const nlohmann::ordered_json& json) {
  std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  Replace(text, "<", "\\u003c");
  Replace(text, "\u2028", "\\u2028");
  Replace(text, "\u2029", "\\u2029");
  return text;
}

std::string Base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string ImageUri(std::string_view bytes) {
  const char* kind = bytes.starts_with("\x89PNG") ? "png" : "jpeg";
  return std::string("data:image/") + kind + ";base64," + Base64(bytes);
}

std::string ValueText(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return Format("%.4g", value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_null()) return "none";
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const nlohmann::json& item : value) text += (text.empty() ? "" : ", ") + ValueText(item);
  return text.empty() ? "none" : text;
}

Cell NumberCell(std::string text) { return {std::move(text), Cell::Kind::kNumber}; }

Cell OriginCell(const std::string& origin) {
  if (origin == "measured") return {origin, Cell::Kind::kMeasured};
  if (origin == "prior" || origin == "from the prior")
    return {"not measured: from the prior", Cell::Kind::kPrior};
  return {origin};
}

std::string HtmlTable(const std::string& caption, const std::vector<std::string>& head,
                      const std::vector<CellRow>& rows) {
  // A caption of the table itself would be as wide as the table and leave a narrow screen.
  std::string html = caption.empty() ? "" : HtmlElement("p", caption, "caption") + "\n";
  html += "<div class=\"scroll\" tabindex=\"0\"><table" +
          (caption.empty() ? "" : " aria-label=\"" + EscapeHtml(caption) + "\"") + ">\n";
  if (!head.empty()) {
    html += "<thead><tr>";
    for (std::size_t c = 0; c < head.size(); ++c) {
      const bool number =
          !rows.empty() && c < rows[0].size() && rows[0][c].kind == Cell::Kind::kNumber;
      html += head[c].empty()
                  ? "<td></td>"
                  : std::string("<th scope=\"col\"") + (number ? " class=\"number\">" : ">") +
                        EscapeHtml(head[c]) + "</th>";
    }
    html += "</tr></thead>\n";
  }
  html += "<tbody>\n";
  for (const CellRow& row : rows) {
    html += "<tr>";
    for (const Cell& cell : row)
      html += cell.kind == Cell::Kind::kHeader
                  ? "<th scope=\"row\">" + EscapeHtml(cell.text) + "</th>"
                  : HtmlCell(cell);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string HtmlDetails(const std::string& summary, const std::string& content) {
  return "<details>" + HtmlElement("summary", summary) + "\n" + content + "</details>\n";
}

std::string HtmlElement(const std::string& tag, const std::string& text,
                        const std::string& style_class) {
  return "<" + tag + (style_class.empty() ? "" : " class=\"" + style_class + "\"") + ">" +
         EscapeHtml(text) + "</" + tag + ">";
}

std::vector<CellRow> FlatRows(const nlohmann::json& object) {
  std::vector<CellRow> rows;
  AddFlatRows(object, "", rows);
  return rows;
}

std::string HtmlFromObjects(const std::string& caption, const nlohmann::json& objects,
                            std::size_t most, std::vector<std::string> keys) {
  for (const nlohmann::json& object : objects)
    for (const auto& [key, value] : object.items())
      if (!value.is_object() && std::find(keys.begin(), keys.end(), key) == keys.end())
        keys.push_back(key);
  std::vector<CellRow> rows;
  for (const nlohmann::json& object : objects) {
    if (rows.size() == most) break;
    CellRow row;
    for (const std::string& key : keys)
      row.push_back(object.contains(key) ? GuessCell(ValueText(object[key])) : Cell{});
    rows.push_back(std::move(row));
  }
  for (std::string& key : keys) Replace(key, "_", " ");
  std::string html = HtmlTable(caption, keys, rows);
  if (rows.size() < objects.size())
    html += HtmlElement("p", Format("and %zu more rows in the file", objects.size() - rows.size()),
                        "missing") +
            "\n";
  return html;
}

std::string HtmlFromMarkdown(const std::string& text) {
  const std::vector<std::string> lines = Lines(text);
  const auto is_prose = [&](std::size_t i) {
    return !lines[i].empty() && !lines[i].starts_with("|") && !lines[i].starts_with("#");
  };
  std::string html;
  for (std::size_t i = 0; i < lines.size();) {
    std::size_t next = i + 1;
    if (lines[i].starts_with("|")) {
      while (next < lines.size() && lines[next].starts_with("|")) ++next;
      html += MarkdownTable(lines, i, next);
    } else if (lines[i].starts_with("#")) {
      html += HtmlElement("h3", Trimmed(lines[i].substr(lines[i].find_first_not_of('#'))));
    } else if (is_prose(i)) {
      std::string paragraph = lines[i];
      for (; next < lines.size() && is_prose(next); ++next) paragraph += " " + lines[next];
      html += "<p>" + WithBold(EscapeHtml(paragraph)) + "</p>\n";
    }
    i = next;
  }
  return html;
}

std::string HtmlFromCsv(const std::string& where, const std::string& text, std::size_t most) {
  std::vector<std::string> head;
  std::vector<CellRow> rows;
  std::size_t left_out = 0;
  for (const std::string& line : Lines(text)) {
    if (line.empty() || line.starts_with("#")) continue;
    const std::vector<std::string> fields = ParseCsvRow(line, where);
    if (head.empty()) {
      head = fields;
    } else if (rows.size() == most) {
      ++left_out;
    } else {
      CellRow row;
      std::transform(fields.begin(), fields.end(), std::back_inserter(row), GuessCell);
      rows.push_back(std::move(row));
    }
  }
  std::string html = HtmlTable("", head, rows);
  if (left_out > 0)
    html += HtmlElement("p", Format("and %zu more rows in the file", left_out), "missing") + "\n";
  return html;
}

}  // namespace drape
