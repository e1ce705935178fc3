// SPDX-License-Identifier: Apache-2.0
#include "physics/util/stored/csv_log.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

// Reads row after row of a text.
class CsvReader {
 public:
  CsvReader(const std::string& text, std::string path, int line)
      : text_(text), path_(std::move(path)), line_(line) {}

  // The next row; none at the end of the text, where a row without an end of line is left out.
  std::optional<NumberedCsvRow> Next() {
    NumberedCsvRow row{path_ + ":" + std::to_string(line_), {}};
    while (true) {
      std::optional<std::string> field = Field(row.where);
      if (!field || at_ == text_.size()) return std::nullopt;
      row.fields.push_back(std::move(*field));
      if (text_[at_++] == ',') continue;
      ++line_;
      return row;
    }
  }

 private:
  // Up to the comma or the end of line that follows it; none where its quotation mark is not
  // closed.
  std::optional<std::string> Field(const std::string& where) {
    if (at_ == text_.size() || text_[at_] != '"') {
      const std::size_t end = std::min(text_.find_first_of(",\n", at_), text_.size());
      const std::string field = text_.substr(at_, end - at_);
      if (field.find('"') != std::string::npos) FailAtQuote(where);
      at_ = end;
      return field;
    }
    std::string field;
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n') ++line_;
      if (text_[at_] != '"') {
        field += text_[at_];
      } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
        field += text_[at_++];
      } else {
        ++at_;
        if (at_ < text_.size() && text_[at_] != ',' && text_[at_] != '\n') FailAtQuote(where);
        return field;
      }
    }
    return std::nullopt;
  }

  [[noreturn]] static void FailAtQuote(const std::string& where) {
    throw InputError(where, "found a quotation mark within a field, expected it around the field");
  }

  const std::string& text_;
  std::string path_;
  std::size_t at_ = 0;
  int line_;
};

void ExpectFields(const CsvRow& row, std::size_t count, const std::string& where) {
  if (row.size() != count)
    throw InputError(where, "found " + std::to_string(row.size()) + " fields, expected " +
                                std::to_string(count));
}

std::string Head(const std::string& shared, const CsvRow& columns) {
  return "# " + shared + "\n" + FormatCsvRow(columns) + "\n";
}

}  // namespace

std::string FormatCsvRow(const CsvRow& fields) {
  std::string text;
  for (const std::string& field : fields) {
    if (&field != &fields.front()) text += ',';
    const bool quoted = field.find_first_of(",\"\r\n") != std::string::npos;
    if (quoted) text += '"';
    for (const char c : field) text += c == '"' ? "\"\"" : std::string(1, c);
    if (quoted) text += '"';
  }
  return text;
}

CsvRow ParseCsvRow(const std::string& text, const std::string& where) {
  const std::string line = text + "\n";
  std::optional<NumberedCsvRow> row = CsvReader(line, where, 1).Next();
  if (!row) throw InputError(where, "found a field whose quotation mark is not closed");
  return std::move(row->fields);
}

std::vector<NumberedCsvRow> ReadCsvLog(const std::string& path, const std::string& shared,
                                       const CsvRow& columns) {
  const std::string text = ReadOwnFile(path), head = Head(shared, columns);
  if (!text.starts_with(head)) {
    const std::string first = text.substr(0, text.find('\n'));
    if (first == "# " + shared)
      throw InputError(path + ":2",
                       "found other columns than those of this program: the file was "
                       "made by another version, or was cut");
    throw InputError(path + ":1", "found '" + first + "', expected '# " + shared +
                                      "': the file was made with other settings");
  }
  const auto lines_of_head = static_cast<int>(std::count(head.begin(), head.end(), '\n'));
  const std::string rest = text.substr(head.size());
  CsvReader reader(rest, path, 1 + lines_of_head);
  std::vector<NumberedCsvRow> rows;
  while (std::optional<NumberedCsvRow> row = reader.Next()) {
    ExpectFields(row->fields, columns.size(), row->where);
    rows.push_back(std::move(*row));
  }
  return rows;
}

void WriteCsvLog(const std::string& path, const std::string& shared, const CsvRow& columns,
                 const std::vector<CsvRow>& rows) {
  std::string text = Head(shared, columns);
  for (const CsvRow& row : rows) text += FormatCsvRow(row) + "\n";
  WriteFileAtomically(path, text);
}

void AppendCsvRow(const std::string& path, const CsvRow& row) {
  AppendFile(path, AppendFile::Content::kKeep).Append(FormatCsvRow(row) + "\n");
}

double ParseCsvNumber(const std::string& field, const std::string& where) {
  double value = 0.0;
  const char* const end = field.data() + field.size();
  const auto [parsed, error] = std::from_chars(field.data(), end, value);
  if (error != std::errc() || parsed != end || !std::isfinite(value))
    throw InputError(where, "found '" + field + "', expected a number");
  return value;
}

}  // namespace drape
