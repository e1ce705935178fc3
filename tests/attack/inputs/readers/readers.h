// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace drape::attack {

// A reader that is called in this process, and a good file for it.
struct Reader {
  std::string name;     // "material"
  std::string file;     // name of its file, within a folder of its own
  std::string content;  // of a good one
  // Reads a file; what it says is wrong with what was read, empty: nothing.
  std::function<std::string(const std::string& path)> read;
  // The text of a file with these members, for readers that check the format and a checksum; the
  // content is then that of the members. None: the content is the file.
  std::function<std::string(const nlohmann::json& members)> seal = {};
  bool is_json = true;  // damaged by rule, too
  // Pointers to members and values that no run finds, each of which is refused.
  std::vector<std::pair<std::string, std::string>> impossible = {};
};

// All of them. Each keeps what it needs. `valid`: the folder of the valid inputs; `scratch`: a
// folder for files that are made here.
std::vector<Reader> MakeReaders(const std::string& valid, const std::string& scratch);

// By kind.
std::vector<Reader> MakeClothReaders(const std::string& valid, const std::string& scratch);
std::vector<Reader> MakeSettingReaders(const std::string& valid, const std::string& scratch);
std::vector<Reader> MakeImageReaders(const std::string& valid);
std::vector<Reader> MakeObservationReaders();
std::vector<Reader> MakeRecordReaders(const std::string& scratch);
std::vector<Reader> MakeResultReaders(const std::string& scratch);
std::vector<Reader> MakeSpaceReaders(const std::string& valid);
std::vector<Reader> MakeGarmentReaders(const std::string& valid);

}  // namespace drape::attack
