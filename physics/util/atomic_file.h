// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace drape {

// Reading and writing of whole files, and the text of numbers in them.

// A refusal of the system: a full disk, a folder without rights, a file that ends early. It says
// nothing about the input, so no program remembers it as a result. The tools treat it like an
// InputError: one line, exit status 2.
class IoError : public std::runtime_error {
 public:
  // where: the path; problem: "cannot be written: No space left on device".
  IoError(const std::string& where, const std::string& problem)
      : std::runtime_error(where + ": " + problem) {}
};

// Replaces the file at `path` in one step: the content is written to a temporary file in the same
// folder, which is flushed to the disk and then renamed. A reader sees the old file or the new one,
// never a part of it. On any failure the old file survives and the temporary file is removed. Links
// are replaced, never followed. Throws IoError when the folder is missing or not writable, when
// the disk is full, or when the path is a folder.
void WriteFileAtomically(const std::string& path, std::string_view content);

// Removes the unfinished files of this process, which is about to end. No file is begun or replaced
// afterwards: who tries waits for the end.
void AbandonTemporaries();

// Throws IoError when WriteFileAtomically cannot replace the path: a folder is in its place, or no
// file can be made in its folder; InputError when its name is too long. To be called before long
// work.
void CheckReplaceable(const std::string& path);

// Throws InputError when the name of a file, made of the name of the input `source`, is too long.
void CheckNameLength(const std::string& source, const std::string& name);

// A new name for a temporary file or folder, ".drapefit_0123456789abcdef.tmp". The program that
// uses it holds its lock (flock).
std::string TemporaryName();

// Removes the temporary files and folders in a folder, if there is one, that programs which are
// gone have left. levels: how many folders deep, 1 for those in the folder itself. Follows no
// links.
void RemoveTemporaries(const std::string& folder, int levels);

// A text file that grows, such as a log.
class AppendFile {
 public:
  enum class Content { kKeep, kDrop };  // what the file had before
  // Throws IoError where it cannot be opened; a link, which could lead to the file of somebody
  // else, is refused like anything else that is not a regular file.
  AppendFile(const std::string& path, Content content);
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;
  ~AppendFile();

  // Throws the errors of the constructor and of CheckReplaceable and leaves the file as it is.
  static void Check(const std::string& path);

  // Returns false when the text cannot be written.
  bool TryAppend(std::string_view text) noexcept;

 private:
  int descriptor_;
};

// Returns the bytes of the file. Throws InputError when it is missing, a folder, a pipe or a
// device, which may be endless, or larger than 1 GiB, and IoError when it cannot be read. part:
// what the caller takes of it, such as "#felt", for the ReadRecord.
std::string ReadWholeFile(const std::string& path, const std::string& part = {});

// Reads a file that a run has written for itself or for its continuation. It is no input and is
// not observed.
std::string ReadOwnFile(const std::string& path);

// From now on each call of ReadWholeFile gives the observer the path and the bytes that it has
// read, in the thread that reads, and passes on what it throws; nullptr: no more. For who records
// the inputs of a run. To be called while no other thread reads.
void ObserveReads(std::function<void(const std::string& path, std::string_view content)> observer);

// The files that this thread has read by ReadWholeFile since the object was made, in order: a file
// that is read twice is there twice, so that the list tells which file was read as what. A record
// that is made within the life of another one fills both.
class ReadRecord {
 public:
  struct File {
    std::string path, sha256;  // with the part that was taken
  };

  ReadRecord();
  ReadRecord(const ReadRecord&) = delete;
  ReadRecord& operator=(const ReadRecord&) = delete;
  ~ReadRecord();

  const std::vector<File>& files() const { return files_; }

 private:
  friend std::string ReadWholeFile(const std::string& path, const std::string& part);
  static void Add(const File& file);

  ReadRecord* outer_;
  std::vector<File> files_;
};

// The paths of a list that is separated by commas. A comma, at most 16 of them, belongs to a path
// where one of the longer name exists.
std::vector<std::string> SplitPaths(const std::string& list);

// Appends the shortest decimal text (at most 17 digits) that reads back to the same double, on
// every platform and in every locale. Throws std::domain_error unless the value is finite.
void AppendNumber(std::string& text, double value);

}  // namespace drape
