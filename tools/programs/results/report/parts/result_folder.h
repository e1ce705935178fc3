// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"

namespace drape {

// What a program has left in a folder.
struct ResultFolder {
  std::string path;        // as the user named it
  std::string name;        // for headings: the last part of the path
  std::string program;     // "drape_fit"
  std::string file;        // its summary.json, comparison.json, bench.json, …
  nlohmann::json summary;  // what that holds

  bool IsFit() const { return program == "drape_fit"; }
  std::string File(const std::string& file) const { return path + "/" + file; }
  // Of its drapes; none for results that do not say so.
  std::optional<DrapeDiscs> Discs() const;
  // The names of the files that end so, in order.
  std::vector<std::string> Files(const std::string& end) const;
};

// Throws InputError for what is not a folder, and for one without results of a known program.
ResultFolder ReadResultFolder(const std::string& path);

// A member by its JSON pointer, "/verdict/grade"; nullptr where there is none, or null.
const nlohmann::json* Find(const nlohmann::json& json, const std::string& pointer);
std::optional<double> FindNumber(const nlohmann::json& json, const std::string& pointer);
std::string FindText(const nlohmann::json& json, const std::string& pointer);
std::vector<std::string> FindTexts(const nlohmann::json& json, const std::string& pointer);

// A page while its parts are written: the markup, and what its script shows in it.
struct ReportPage {
  std::string body;
  std::vector<std::pair<std::string, std::string>> sections = {};     // id, heading
  nlohmann::ordered_json pictures = nlohmann::ordered_json::array();  // PictureJson
  nlohmann::ordered_json drapes = nlohmann::ordered_json::array();    // a list for each viewer

  // A section of the page; one without content is left out.
  void AddSection(const std::string& id, const std::string& heading, const std::string& content);
  // The place of a chart.
  std::string AddPicture(const nlohmann::ordered_json& picture, const std::string& caption);
};

// The contents of several folders side by side, each under its name; of one alone, without.
std::string SideBySide(const std::vector<ResultFolder>& folders,
                       const std::vector<std::string>& contents);

}  // namespace drape
