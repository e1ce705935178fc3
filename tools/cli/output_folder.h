// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// The files of one run, which appear together or not at all: they are written to a hidden folder
// inside the output folder and moved from there at the end, so that an error or a full disk leaves
// an earlier result as it was.
class OutputFolder {
 public:
  // Makes the folder when it is missing and tries it out, before any work is done. Throws
  // InputError when it cannot be made or written to.
  explicit OutputFolder(std::string path);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();  // what was not published is dropped

  // Where to write the file `name` until Publish.
  std::string Staged(const std::string& name) const { return staging_ + "/" + name; }

  // Moves all files into the folder, summary.json last, over older ones of the same names; others
  // stay. Throws InputError.
  void Publish() const;

 private:
  void Move(const std::string& name) const;

  std::string path_, staging_;
  bool made_ = false;  // by this object: removed again when nothing is published
};

}  // namespace drape
