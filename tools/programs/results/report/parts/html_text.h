// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace drape {

// Texts of files and users as they may be put into a page: none of them becomes markup or script.

// For the text of an element and for attributes between double quotes.
std::string EscapeHtml(std::string_view text);

// A JSON text that may stand inside <script>: "<" as \u003c, U+2028 and U+2029 as \u2028 and
// \u2029, as Lighthouse's reports do. Bytes that are not UTF-8 are replaced.
std::string ScriptJson(const nlohmann::ordered_json& json);

std::string Base64(std::string_view bytes);

// "data:image/png;base64,…" of a PNG or JPEG.
std::string ImageUri(std::string_view bytes);

// One line of a number, as JSON or as a person reads it: up to 4 digits; "none" for null; texts as
// they are; lists of up to four numbers or texts joined by commas.
std::string ValueText(const nlohmann::json& value);

struct Cell {
  std::string text;  // escaped here, not by the caller
  enum class Kind { kText, kNumber, kHeader, kMeasured, kPrior } kind = Kind::kText;
  bool markdown = false;  // "**" is around what is strong
};
Cell NumberCell(std::string text);
// Where a value is from, as results store it: "measured", "from the prior", "given", …
Cell OriginCell(const std::string& origin);

using CellRow = std::vector<Cell>;
// A table that can be scrolled sideways. `head` may be empty; a caption too.
std::string HtmlTable(const std::string& caption, const std::vector<std::string>& head,
                      const std::vector<CellRow>& rows);

// "<details><summary>…</summary>…</details>"; the content is markup.
std::string HtmlDetails(const std::string& summary, const std::string& content);
// "<tag class="…">escaped text</tag>".
std::string HtmlElement(const std::string& tag, const std::string& text,
                        const std::string& style_class = "");

// Names and numbers of an object and, with their paths, of the objects in it, as rows of a table.
// Lists of objects and long lists are counted.
std::vector<CellRow> FlatRows(const nlohmann::json& object);

// A table of a list of objects with the same keys; of more than `most` rows the first, and how many
// are left out. Members that are objects themselves are left out. keys: of the first columns; the
// others follow by the alphabet.
std::string HtmlFromObjects(const std::string& caption, const nlohmann::json& objects,
                            std::size_t most, std::vector<std::string> keys = {});

// The tables and paragraphs of a report in Markdown, with "**" as strong, and a table of a CSV
// file, with `most` as above.
std::string HtmlFromMarkdown(const std::string& text);
std::string HtmlFromCsv(const std::string& where, const std::string& text, std::size_t most);

}  // namespace drape
