// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/metrics/metrics_dataset.h"

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "losses/dataset/index_list.h"
#include "physics/util/errors.h"
#include "tools/programs/metrics/metrics_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

Selection MakeSelection(const DatasetInput& input) {
  Selection selection{.fabrics = ParseIndexList(input.fabric, "option 'fabric'"),
                      .samples = ParseIndexList(input.samples, "option 'samples'"),
                      .captures = ParseIndexList(input.captures, "option 'captures'")};
  if (input.face != "both") selection.face = input.face == "up" ? ClothFace::kUp : ClothFace::kDown;
  return selection;
}

// The captures of `all` that are among the usable ones.
std::vector<Capture> Usable(const std::vector<Capture>& all, const std::vector<Capture>& usable) {
  std::vector<Capture> kept;
  for (const Capture& capture : all)
    for (const Capture& other : usable)
      if (capture.image == other.image) kept.push_back(other);
  return kept;
}

void UseStoredSplit(const DatasetInput& input, const Dataset& dataset, DatasetReport* report) {
  const bool selects = !(input.fabric + input.samples + input.captures).empty();
  if (selects || input.face != "both") {
    throw InputError("option 'split'",
                     "a stored split names its captures, expected none of fabric, samples, "
                     "captures, face beside it");
  }
  report->split = ReadSplit(input.split, dataset);
  std::vector<Capture> both = report->split.train;
  both.insert(both.end(), report->split.held_out.begin(), report->split.held_out.end());
  report->captures = KeepUsable(both, &report->skipped);
  report->split.train = Usable(report->split.train, report->captures);
  report->split.held_out = Usable(report->split.held_out, report->captures);
}

void DrawSplit(const DatasetInput& input, const Dataset& dataset, DatasetReport* report) {
  report->captures = KeepUsable(Select(dataset, MakeSelection(input)), &report->skipped);
  report->in_turn = input.train == 0;
  report->split = report->in_turn ? Split{0, report->captures, report->captures}
                                  : SplitBySample(report->captures, input.train, input.seed);
}

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
  return text + "; learnt from " + samples(report.split.train) + "; held out " +
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

DatasetReport EvaluateDataset(const DatasetInput& input, const Camera& camera,
                              const RunControl& control) {
  const Dataset dataset = ReadDataset(input.folder);
  DatasetReport report;
  report.training_images = dataset.training_images.size();
  report.skipped = dataset.skipped;
  report.notes = dataset.notes;
  if (input.split.empty()) {
    DrawSplit(input, dataset, &report);
  } else {
    UseStoredSplit(input, dataset, &report);
  }
  if (!input.save_split.empty() && report.in_turn)
    throw InputError("option 'save_split'", "there is no split to store with train = 0");
  if (control.cancelled()) return report;
  report.seen_train = ObserveCaptures(report.split.train, camera, input.hard_edged);
  report.seen_held_out = report.in_turn
                             ? report.seen_train
                             : ObserveCaptures(report.split.held_out, camera, input.hard_edged);
  report.predictors =
      EvaluateTrivialPredictors(report.seen_train, report.seen_held_out, camera, input.aligned);
  if (!input.save_split.empty()) WriteSplit(input.save_split, report.split);
  return report;
}

std::string DatasetText(const DatasetReport& report) {
  std::string text = std::to_string(report.captures.size()) + " captures, " +
                     std::to_string(report.training_images) + " training images\n";
  for (const int fabric : ListFabrics(report.captures)) text += FabricLine(report, fabric);
  text += NotesText("note:", report.notes) + NotesText("skipped:", report.skipped);
  text += report.in_turn ? "each sample held out in turn\n"
                         : "split by seed " + std::to_string(report.split.seed) + "\n";
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
