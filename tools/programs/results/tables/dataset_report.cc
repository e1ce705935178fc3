// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/dataset_report.h"

#include <nlohmann/json.hpp>
#include <set>

#include "losses/dataset/dataset_split.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

std::vector<int> Numbers(const std::vector<Capture>& captures, int fabric, int Capture::*number) {
  std::set<int> numbers;
  for (const Capture& capture : captures)
    if (capture.fabric == fabric) numbers.insert(capture.*number);
  return {numbers.begin(), numbers.end()};
}

std::set<int> ListFabrics(const std::vector<Capture>& captures) {
  std::set<int> fabrics;
  for (const Capture& capture : captures) fabrics.insert(capture.fabric);
  return fabrics;
}

std::string FabricLine(const DatasetReport& report, int fabric) {
  int captures = 0, meshes = 0, turned = 0;
  for (const Capture& capture : report.captures) {
    if (capture.fabric != fabric) continue;
    ++captures;
    meshes += !capture.mesh.empty();
    turned += capture.mesh_quarters != 0;
  }
  const auto samples = [&](const std::vector<Capture>& side) {
    return IndexListText(Numbers(side, fabric, &Capture::sample));
  };
  std::string text = "fabric " + std::to_string(fabric) + ": " + std::to_string(captures) +
                     " captures of samples " + samples(report.captures) + ", " +
                     std::to_string(meshes) + " meshes";
  if (turned > 0) text += " (" + std::to_string(turned) + " turned against their images)";
  if (report.in_turn) return text + "\n";
  return text + "; training samples " + samples(report.split.train) + "; held-out samples " +
         samples(report.split.held_out) + "\n";
}

Json SideJson(const std::vector<Capture>& captures) {
  Json side = Json::array();
  for (const Capture& c : captures) {
    Json json = {{"fabric", c.fabric},
                 {"sample", c.sample},
                 {"capture", c.capture},
                 {"face", ClothFaceName(c.face)},
                 {"image", c.image}};
    if (!c.mesh.empty()) json["mesh"] = {{"file", c.mesh}, {"quarter_turns", c.mesh_quarters}};
    side.push_back(json);
  }
  return side;
}

Json NotesJson(const std::vector<FileNote>& notes) {
  Json json = Json::array();
  for (const FileNote& note : notes) json.push_back({{"file", note.path}, {"why", note.text}});
  return json;
}

std::string NotesText(const char* what, const std::vector<FileNote>& notes) {
  std::string text;
  for (const FileNote& note : notes) {
    const bool named = note.text.starts_with(note.path);
    text += std::string(what) + " " + (named ? "" : note.path + ": ") + note.text + "\n";
  }
  return text;
}

}  // namespace

std::string DatasetText(const DatasetReport& report) {
  std::string text = std::to_string(report.captures.size()) + " captures, " +
                     std::to_string(report.training_images) + " training images\n";
  for (const int fabric : ListFabrics(report.captures)) text += FabricLine(report, fabric);
  text += NotesText("note:", report.notes) + NotesText("skipped:", report.skipped);
  text += report.in_turn ? "each sample is held out in turn\n"
                         : "split of seed " + std::to_string(report.split.seed) + "\n";
  return text + PredictorsText(report.predictors);
}

Json DatasetJson(const DatasetReport& report) {
  Json json = {{"captures", report.captures.size()},
               {"training_images", report.training_images},
               {"skipped", NotesJson(report.skipped)},
               {"notes", NotesJson(report.notes)}};
  if (report.in_turn) {
    json["held_out_in_turn"] = SideJson(report.captures);
  } else {
    json["split"] = {{"seed", report.split.seed},
                     {"train", SideJson(report.split.train)},
                     {"held_out", SideJson(report.split.held_out)}};
  }
  json["trivial_predictors"] = PredictorsJson(report.predictors);
  return json;
}

}  // namespace drape
