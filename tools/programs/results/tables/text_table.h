// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// A table of texts, for a file of Markdown and for a terminal.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> columns);

  // Missing cells at the end are empty. CHECKs that there are not more cells than columns.
  void Add(std::vector<std::string> cells);

  std::string Markdown() const;  // "| a | b |"
  // Columns two blanks apart, the first flush left, the others flush right, a rule below the names.
  std::string Aligned() const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the names of the columns, then the cells
};

}  // namespace drape
