// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace drape {

// The finished cells of a study in a folder, one file each, and settings.json, which says what all
// cells share. Several processes may have the same folder: a file appears as a whole, and two
// processes that run the same cell write the same.
class CellFolder {
 public:
  // Neither makes nor changes anything. `settings`: one line. Throws InputError where the folder
  // has cells of other settings.
  CellFolder(std::string folder, std::string settings);

  // Whether cells of these settings were there.
  bool continues() const { return continues_; }

  // Makes the folder and its settings.json. Throws InputError when it cannot.
  void Create();

  // What was written for the cell of that name; none where it is missing. Throws InputError for a
  // file that is damaged or of another cell.
  std::optional<std::string> Read(const std::string& cell) const;
  // Writes the file of the cell atomically. Throws InputError when it cannot.
  void Write(const std::string& cell, const std::string& result) const;

  // The file of a cell: a hash of its name, which may have any characters.
  std::string Path(const std::string& cell) const;

 private:
  std::string folder_, settings_;
  bool continues_ = false;
};

}  // namespace drape
