// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/text_table.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

namespace drape {
namespace {

// In characters of UTF-8: bytes that do not continue one.
std::size_t CountCharacters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6) != 2; }));
}

void TrimRight(std::string* line) { line->erase(line->find_last_not_of(' ') + 1); }

}  // namespace

TextTable::TextTable(std::vector<std::string> columns) : rows_{std::move(columns)} {}

void TextTable::Add(std::vector<std::string> cells) {
  CHECK_LE(cells.size(), rows_.front().size());
  cells.resize(rows_.front().size());
  rows_.push_back(std::move(cells));
}

std::string TextTable::Markdown() const {
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    text += "|";
    for (const std::string& cell : rows_[r]) text += " " + cell + (cell.empty() ? "|" : " |");
    text += "\n";
    if (r > 0) continue;
    text += "|";
    for (std::size_t c = 0; c < rows_.front().size(); ++c) text += "---|";
    text += "\n";
  }
  return text;
}

std::string TextTable::Aligned() const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (std::size_t c = 0; c < row.size(); ++c)
      widths[c] = std::max(widths[c], CountCharacters(row[c]));
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    std::string line;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string blanks(widths[c] - CountCharacters(rows_[r][c]), ' ');
      if (c > 0) line += "  ";
      line += c == 0 ? rows_[r][c] + blanks : blanks + rows_[r][c];
    }
    TrimRight(&line);
    text += line + "\n";
    if (r == 0) text += std::string(CountCharacters(line), '-') + "\n";
  }
  return text;
}

}  // namespace drape
