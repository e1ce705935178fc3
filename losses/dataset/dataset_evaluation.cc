// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/dataset_evaluation.h"

#include "losses/dataset/dataset_split.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

Selection MakeSelection(const DatasetQuery& query) {
  return {.fabrics = ParseIndexList(query.fabric, "option 'fabric'"),
          .samples = ParseIndexList(query.samples, "option 'samples'"),
          .captures = ParseIndexList(query.captures, "option 'captures'"),
          .face = ParseClothFace(query.face)};
}

// The captures of `all` that are among the usable ones.
std::vector<Capture> Usable(const std::vector<Capture>& all, const std::vector<Capture>& usable) {
  std::vector<Capture> kept;
  for (const Capture& capture : all)
    for (const Capture& other : usable)
      if (capture.image == other.image) kept.push_back(other);
  return kept;
}

void UseStoredSplit(const DatasetQuery& query, const Dataset& dataset, DatasetReport* report) {
  const bool selects = !(query.fabric + query.samples + query.captures).empty();
  if (selects || query.face != "both") {
    throw InputError("option 'split'",
                     "a stored split names its captures, expected none of fabric, samples, "
                     "captures, face beside it");
  }
  report->split = ReadSplit(query.split, dataset);
  std::vector<Capture> both = report->split.train;
  both.insert(both.end(), report->split.held_out.begin(), report->split.held_out.end());
  report->captures = KeepUsable(both, &report->skipped);
  report->split.train = Usable(report->split.train, report->captures);
  report->split.held_out = Usable(report->split.held_out, report->captures);
}

void SampleSplit(const DatasetQuery& query, const Dataset& dataset, DatasetReport* report) {
  report->captures = KeepUsable(Select(dataset, MakeSelection(query)), &report->skipped);
  report->in_turn = query.train == 0;
  report->split = report->in_turn ? Split{0, report->captures, report->captures}
                                  : SplitBySample(report->captures, query.train, query.seed);
}

}  // namespace

DatasetReport EvaluateDataset(const DatasetQuery& query, const Camera& camera,
                              const RunControl& control) {
  const Dataset dataset = ReadDataset(query.folder);
  DatasetReport report;
  report.training_images = dataset.training_images.size();
  report.skipped = dataset.skipped;
  report.notes = dataset.notes;
  if (query.split.empty()) {
    SampleSplit(query, dataset, &report);
  } else {
    UseStoredSplit(query, dataset, &report);
  }
  if (!query.save_split.empty() && report.in_turn)
    throw InputError("option 'save_split'", "there is no split to store with train = 0");
  if (control.cancelled()) return report;
  report.seen_train = ObserveCaptures(report.split.train, camera, query.hard_edged);
  report.seen_held_out = report.in_turn
                             ? report.seen_train
                             : ObserveCaptures(report.split.held_out, camera, query.hard_edged);
  report.predictors =
      EvaluateTrivialPredictors(report.seen_train, report.seen_held_out, camera, query.aligned);
  if (!query.save_split.empty()) WriteSplit(query.save_split, report.split);
  return report;
}

}  // namespace drape
