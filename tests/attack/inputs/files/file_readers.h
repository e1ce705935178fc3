// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace drape::attack {

// Tables of bad files, by the reader that they are for.

struct BadFile {
  std::string name;
  std::string content;
  bool refused = true;     // false: some of what it asks for may be possible
  std::string named = {};  // the error holds this; empty: the name of the file where it is refused
};

struct FileReader {
  std::string name;                                // "material"
  std::string file;                                // where its file lies: "in/material.json"
  std::vector<std::vector<std::string>> commands;  // that read it
  std::vector<std::string> beside = {};            // valid files that are copied to its folder
  std::vector<BadFile> bad;
};

// All of them; `valid` is the folder of the valid inputs.
std::vector<FileReader> MakeFileReaders(const std::string& valid);

// By kind.
std::vector<BadFile> MakeBadMeshes();
std::vector<BadFile> MakeBadMaterials(const std::string& valid);
std::vector<BadFile> MakeBadFields(const std::string& valid);
std::vector<BadFile> MakeBadStarts(const std::string& valid);
std::vector<BadFile> MakeBadStates(const std::string& valid);
std::vector<BadFile> MakeBadScenes(const std::string& valid);
std::vector<BadFile> MakeBadConfigs();
std::vector<BadFile> MakeBadSummaries(const std::string& valid);
std::vector<BadFile> MakeBadPosteriors(const std::string& valid);
std::vector<BadFile> MakeBadSplits(const std::string& valid);
std::vector<BadFile> MakeBadAccuracyTables(const std::string& valid);
std::vector<BadFile> MakeBadLabTests(const std::string& valid);

std::vector<BadFile> MakeBadGarments(const std::string& valid);
std::vector<BadFile> MakeBadGarmentCodes(const std::string& valid);
std::vector<BadFile> MakeBadBodies(const std::string& valid);
std::vector<BadFile> MakeBadContacts(const std::string& valid);
std::vector<BadFile> MakeBadSpaces(const std::string& valid);

// What is wrong with any file of JSON, made from a valid one.
std::vector<BadFile> MakeBadJson(const std::string& valid_text);

// One member of a JSON document replaced; a discarded value removes it.
struct Change {
  std::string pointer;
  std::string value;  // JSON; empty: the member is removed
  bool refused = true;
  std::string named = {};  // BadFile
};
// The document of a file, changed in turn by each; comments are allowed.
std::vector<BadFile> MakeChanged(const std::string& path, const std::vector<Change>& changes);

std::string ReadText(const std::string& path);

}  // namespace drape::attack
