// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/run_control.h"

namespace drape {

// A study is a list of independent runs, its cells. Its folder OUT keeps each finished cell as
// OUT/cells/<id>.json, a file {key, result}. The key holds whatever the result depends on: the
// version of drapefit, the settings of the study, the input of the cell, and the SHA-256 of each
// file that was read. It holds no path and no name of a file. So the same command continues a study
// that was stopped, on this machine or on others, and never takes over a cell of changed inputs.

struct StudyCell {
  std::string name;           // "step time_step=0.1": one line, for a person
  nlohmann::json input = {};  // what this cell adds to the settings, and no other cell has
  nlohmann::json names = nlohmann::json::object();  // of its files, beside the input, for a person
  std::vector<ReadRecord::File> files = {};         // those that it reads beside Study::files
  double work = 1.0;                                // its share of the time, in any unit
};

// Makes a cell and records the files that `check` reads: `check` reads all files that the run of
// this cell will read, and refuses bad input before hours are spent.
StudyCell CheckedCell(std::string name, nlohmann::json input, const std::function<void()>& check);

// clang-tidy sees a throw in its move, which moves JSON.
struct Study {                   // NOLINT(bugprone-exception-escape)
  std::string name;              // "stability"
  nlohmann::json settings = {};  // what all cells have in common: numbers and names, no paths
  std::vector<ReadRecord::File> files = {};  // those that every cell reads
  std::vector<StudyCell> cells = {};         // of different names
  // Words that the member "outcome" of a result may hold; empty: any.
  std::vector<std::string> outcomes = {};
  // Where given, is called before a cell runs, for what several cells share: in this process, so
  // that its memory counts for no cell. Returns false when it was cancelled.
  std::function<bool(std::size_t cell, const RunControl& control)> prepare = {};
  // Runs the cell of this index. Returns its result, or nothing when it was cancelled. A result
  // with the member "failure", a text, counts as failed. An InputError or IoError ends the study;
  // neither is ever stored. May be called by several threads at once.
  std::function<std::optional<nlohmann::json>(std::size_t cell, const RunControl& control)> run =
      {};
  // Returns, where given, whether what a finished cell has beside its stored result is still its
  // own; where it is not, the cell runs again.
  std::function<bool(std::size_t cell, const nlohmann::json& result)> is_whole = {};
};

// What a user of a study asks for.
struct StudyOptions {
  std::string out = {};    // folder
  bool list = false;       // only the names of the cells
  std::string share = {};  // "i/n", 0 ≤ i < n: the cells k with k mod n = i; empty: all
  int threads = 1;         // cells at once; 1 with `processes`
  // Each cell runs in a forked process, whose memory is measured: the result, an object, gets the
  // member "peak_mb", the peak less that of a process that does nothing [MB].
  bool processes = false;
};

struct StudyResult {
  bool cancelled = false;
  // Whether `results` holds all cells of the study, so that tables can be made.
  bool complete = false;
  std::vector<std::optional<nlohmann::json>> results = {};  // by cell; nothing: it has not ended
  std::string text = {};  // the list of cells, or what a share has to say; otherwise empty
};

// The 32 digits that name the files of a cell, a hash of its key.
std::string CellId(const Study& study, std::size_t cell);

// The name of a file without its folder: "wool.json" of "a/wool.json", "bank.json#felt" of
// "a/bank.json#felt", and "disc:300" of itself.
std::string NameWithoutFolder(const std::string& path);

// The same for a key, where contents stand for a file: "file" of the first two.
std::string NameInKey(const std::string& path);

// Throws InputError for a share that cannot be.
void CheckShare(const StudyOptions& options);

// Lists the cells, or takes finished cells over and runs and stores the missing ones. Several
// processes may run shares in one folder at the same time. Throws InputError for two cells of one
// name, for a cell file that is damaged and where an input changes while the study runs, and
// IoError where a result cannot be written; finished cells are kept.
StudyResult RunStudy(const Study& study, const StudyOptions& options, const RunControl& control);

}  // namespace drape
