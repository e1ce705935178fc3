// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// A CSV file of finished runs, which grows by one row as a run ends, so that a study that was
// stopped can be resumed: a line "# <what all runs share>", the names of the columns, the rows.
// Fields are as in RFC 4180: one with a comma, a quotation mark or an end of line is quoted.

using CsvRow = std::vector<std::string>;

// One row without its end of line, and back (throws InputError, prefix `where`).
std::string FormatCsvRow(const CsvRow& fields);
CsvRow ParseCsvRow(const std::string& text, const std::string& where);

struct NumberedCsvRow {
  std::string where;  // "runs.csv:3", for errors
  CsvRow fields;
};

// The rows of such a file; an unfinished last one, of a run that was cut off, is left out. Throws
// InputError when the file is missing, was begun with another `shared` or other columns, or has a
// row of another number of fields or with a misplaced quotation mark.
std::vector<NumberedCsvRow> ReadCsvLog(const std::string& path, const std::string& shared,
                                       const CsvRow& columns);
// Replaces the file atomically.
void WriteCsvLog(const std::string& path, const std::string& shared, const CsvRow& columns,
                 const std::vector<CsvRow>& rows);
// Appends one row to the disk. Throws InputError when it cannot.
void AppendCsvRow(const std::string& path, const CsvRow& row);

// A finite number of a field. Throws InputError for any other text.
double ParseCsvNumber(const std::string& field, const std::string& where);

}  // namespace drape
