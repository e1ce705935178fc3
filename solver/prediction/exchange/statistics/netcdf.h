// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace drape {

// Arrays with named dimensions, in groups, as netCDF-4 files hold them.

struct NetcdfDimension {
  std::string name;
  int size = 0;
  // Of its coordinate, texts or numbers; both empty: 0, 1, 2, …
  std::vector<std::string> labels = {};
  std::vector<double> numbers = {};
  std::string units = {};  // of the numbers
};

struct NetcdfVariable {
  std::string name;
  std::vector<std::string> dimensions;  // of its group, slowest first
  std::vector<double> values;           // row-major
  std::string units;                    // "1" where there is none
  std::string long_name;
};

using NetcdfAttributes = std::vector<std::pair<std::string, std::string>>;

struct NetcdfGroup {
  std::string name;
  std::vector<NetcdfDimension> dimensions;  // each has a coordinate in the file
  std::vector<NetcdfVariable> variables;
  NetcdfAttributes attributes;
};

// Whether this build has libnetcdf.
bool HasNetcdf();

// Writes the groups to a new file at `path`, which nothing else writes to. CHECKs that each
// variable has as many values as its dimensions say. Throws InputError when the file cannot be
// written, or when this build has no libnetcdf.
void WriteNetcdf(const std::string& path, const std::vector<NetcdfGroup>& groups,
                 const NetcdfAttributes& attributes);

}  // namespace drape
