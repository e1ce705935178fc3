// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"

namespace drape {

// What a program has left in a folder, or drape_metrics in a file.
struct ResultFolder {
  std::string path;        // as the user named it
  std::string name;        // for headings: the last part of the path
  std::string program;     // "drape_fit"
  std::string file;        // its summary.json, comparison.json, bench.json, …
  nlohmann::json summary;  // what that holds

  bool IsFit() const { return program == "drape_fit"; }
  std::string File(const std::string& file) const {
    return file.empty() ? path : path + "/" + file;
  }
  // Of its drapes; none for results that do not say so.
  std::optional<DrapeDiscs> Discs() const;
  // The names of the files that end so, in order: draw_2 before draw_10.
  std::vector<std::string> Files(const std::string& end) const;
};

// Of a folder, or of a JSON file of drape_metrics, which has no files. Throws InputError for
// anything else, and for a folder without results of a known program.
ResultFolder ReadResultFolder(const std::string& path);

// The folder of drape_photo from which an image of a fit is, as long as it is there, with its
// overlay. What the photograph says of the drape is in the image itself, as "photograph".
std::optional<ResultFolder> FindPhotograph(const nlohmann::json& image);

// A member by its JSON pointer, "/verdict/grade"; nullptr where there is none, or null.
const nlohmann::json* Find(const nlohmann::json& json, const std::string& pointer);
std::optional<double> FindNumber(const nlohmann::json& json, const std::string& pointer);
std::string FindText(const nlohmann::json& json, const std::string& pointer);
std::vector<std::string> FindTexts(const nlohmann::json& json, const std::string& pointer);
// The items of a list; none where there is no list.
const nlohmann::json& FindList(const nlohmann::json& json, const std::string& pointer);
// A number times a factor, "none" where there is none.
std::string NumberText(const nlohmann::json& json, const std::string& pointer, double factor,
                       const char* format);
// "27.3 ± 0.3": the drape coefficient of a photograph and its standard deviation [%].
std::string CoefficientText(const nlohmann::json& photograph);

// A page while its parts are written: the markup, and what its script shows in it.
struct ReportPage {
  std::string body;
  std::vector<std::pair<std::string, std::string>> sections = {};     // id, heading
  nlohmann::ordered_json pictures = nlohmann::ordered_json::array();  // PictureJson
  nlohmann::ordered_json drapes = nlohmann::ordered_json::array();    // a list for each viewer

  // What may still be put into the page [bytes], beside the texts of its parts.
  std::size_t room = 0;
  std::vector<std::string> left_out = {};  // what found no room

  // Whether so many bytes find room, which they take; else `what` is left out.
  bool TakeRoom(std::size_t bytes, const std::string& what);
  // The markup, or a line that says that it found no room.
  std::string IfItFits(const std::string& what, std::string markup);
  // A section of the page; one without content is left out.
  void AddSection(const std::string& id, const std::string& heading, const std::string& content);
  // A PNG or JPEG file with its caption, if it fits.
  std::string AddImage(const std::string& file, const std::string& alt, const std::string& caption);
  // The place of a chart; a line where it found no room.
  std::string AddPicture(const nlohmann::ordered_json& picture, const std::string& caption);
};

// What `part` says of each folder, side by side, each under its name; of one alone, without.
std::string SideBySide(const std::vector<ResultFolder>& folders,
                       const std::function<std::string(const ResultFolder&)>& part);

}  // namespace drape
