// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// The output folder of one run. Its files appear together or not at all: the run writes them to a
// hidden folder inside, and Publish moves them. An error or a full disk leaves an earlier result as
// it was. No other program can have the same folder while the object exists.
class OutputFolder {
 public:
  enum class Use {
    kAlone,  // this program is the only one
    kShared  // several programs write files of their own below it, such as cells of a study;
             // nothing is removed, staged or published
  };

  // Makes the folder if it is missing, locks it, removes the leftovers of programs that were
  // killed, and makes the hidden folder, before any work is done. `names`: files that the run will
  // publish, or write to the folder meanwhile. Throws IoError when the folder cannot be made or
  // written to or one of the files cannot be replaced, and InputError when another program writes
  // to it or has its summary there, or one of the files is an input.
  explicit OutputFolder(std::string path, const std::vector<std::string>& names = {},
                        Use use = Use::kAlone);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();  // drops files that were not published

  // Where to write the file `name` until Publish.
  std::string Staged(const std::string& name) const { return staging_ + "/" + name; }

  // Moves all files into the folder, summary.json last. They replace older files of the same names;
  // other files stay. Throws IoError if a folder, and InputError if an input stands where a file
  // should go, before anything is replaced.
  void Publish() const;

  // Returns whether this process has an output folder, and so something to save. Never waits.
  static bool IsAnyOpen();
  // Returns whether an output folder of this process has published its files.
  static bool HasAnyPublished();

  // Drops all unpublished files of this process, which is about to end. Nothing is published
  // afterwards.
  static void Abandon();

 private:
  void Lock(Use use);
  void MakeStaging();
  void Drop() const;

  std::string path_, staging_;
  int lock_ = -1, staging_lock_ = -1;  // descriptors of the folders
  bool made_ = false;                  // by this object: removed again when nothing is published
};

}  // namespace drape
