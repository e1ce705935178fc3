// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/job/fit_data.h"
#include "solver/job/fit_spec.h"

namespace drape {

// A picture of a table of samples.
struct SampleRow {               // NOLINT(bugprone-exception-escape)
  std::string file;              // path of the picture
  std::string name;              // of results of it: that of the file, with its folder where needed
  nlohmann::ordered_json cells;  // a text for each column, "" where the row has none
  double mass = 0.0;             // by area [g/m²]; 0: not given
  double diameter = 0.0;         // of the flat specimen [m]; 0: not given

  // The text of a column; "" where the table has no such column.
  std::string of(const std::string& column) const { return cells.value(column, ""); }
};

struct SampleTable {
  std::string path;  // of the table or folder, without "#fabric"
  std::vector<std::string> columns;
  std::vector<SampleRow> rows;

  std::vector<std::string> Files() const;
  std::vector<std::string> Fabrics() const;  // by their first rows
  // The value of all rows of a column; "" without one. Throws InputError for rows that differ.
  std::string Common(const std::string& column) const;
  // The number of the specimen of each row, from 1; empty where a row names none.
  std::vector<int> SpecimenNumbers() const;
};

// Returns whether a path is a table (.csv), a folder with samples.csv, or one of both with a fabric
// ("samples.csv#felt").
bool IsSampleTable(const std::string& path);

// Reads a table of samples as spreadsheets write it, with commas, or semicolons and decimal commas.
// Columns, of which only `file` is needed: file (relative to the table), fabric, sample, specimen,
// face (up, down), warp, mass [g/m²], diameter [m], date, operator, customer. Others are kept. A
// row whose column `error` is filled is left out: it could not be measured. A folder stands for its
// samples.csv or else for its pictures and those in its folders, which are the fabrics. "#felt"
// keeps the rows of that fabric. Throws InputError that names file, line, column, value and what
// was expected.
SampleTable ReadSamples(const std::string& path);

// A table of files of one fabric.
SampleTable SamplesOfFiles(const std::vector<std::string>& files, const std::string& fabric);

// The images of an option --images (ExpandImages). A table of samples among them gives its
// pictures, and, where it is the only item, their specimens, mass, size and warp, unless they are
// given. Throws InputError for a table of several fabrics.
void AddImages(const std::string& text, FitSpec* spec, FitData* data);

// A text as a field of a CSV file.
std::string CsvField(const std::string& text);

}  // namespace drape
