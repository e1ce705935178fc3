// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// The files of one run, which appear together or not at all: they are written to a hidden folder
// inside the output folder and moved from there at the end, so that an error or a full disk leaves
// an earlier result as it was. While it exists, no other program can have the same output folder.
class OutputFolder {
 public:
  enum class Use {
    kAlone,  // of this program alone
    kShared  // of several that write files of their own below it, such as cells of a study: no
             // other program can have it alone; nothing is removed, staged or published
  };

  // Makes the folder when it is missing, locks it, removes what programs that were killed have left
  // behind, and makes the hidden folder, under a name of its own; all before any work is done.
  // `names`: files that will be published, or written to it meanwhile. Throws InputError when the
  // folder cannot be made or written to, when another program writes to it, or when one of the
  // files cannot be replaced.
  explicit OutputFolder(std::string path, const std::vector<std::string>& names = {},
                        Use use = Use::kAlone);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();  // what was not published is dropped

  // Where to write the file `name` until Publish.
  std::string Staged(const std::string& name) const { return staging_ + "/" + name; }

  // Moves all files into the folder, summary.json last, over older ones of the same names; others
  // stay. Throws InputError; when a folder is in the place of a file, before anything is replaced.
  void Publish() const;

  // Whether this process has one: something to save.
  static bool IsAnyOpen();
  // Whether one has published its files.
  static bool HasAnyPublished();

  // Drops what the folders of this process have not published, for a process that ends at once.
  // Nothing is published afterwards.
  static void Abandon();

 private:
  void Lock(Use use);
  void MakeStaging();
  void RemoveLeftovers() const;
  void Drop() const;

  std::string path_, staging_;
  int lock_ = -1;      // descriptor of the folder
  bool made_ = false;  // by this object: removed again when nothing is published
};

}  // namespace drape
