// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/metrics/metrics_tool.h"

#include <nlohmann/json.hpp>

#include "losses/metrics/report_json.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "tools/cli/versions.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/metrics/metrics_input.h"
#include "tools/programs/metrics/metrics_report.h"
#include "tools/programs/reports/dataset_report.h"
#include "tools/programs/reports/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

ComparedPair Compare(const std::string& a, const std::string& b, const Camera& camera,
                     const MetricsOptions& options) {
  const ViewedFile first = ViewFile(a, camera, options.data.hard_edged);
  const ViewedFile second = ViewFile(b, camera, options.data.hard_edged);
  ComparedPair pair{a,
                    b,
                    CompareDrapes(first.seen, second.seen, camera),
                    {},
                    first.seen.shape,
                    second.seen.shape};
  if (first.surface && second.surface) {
    pair.surfaces = CompareSurfaces(*first.surface, *second.surface, pair.comparison.alignment,
                                    a + " and " + b);
  }
  return pair;
}

// What a mode has found: the table and its part of the JSON file.
struct Found {
  std::string text;
  Json json;
};

Found CompareRuns(const MetricsOptions& options, const Camera& camera, const RunControl& control) {
  Found found{"", {{"pairs", Json::array()}, {"alone", Json::array()}}};
  std::vector<std::string> alone;
  for (const auto& [a, b] : PairDrapes(options.operands[0], options.operands[1], &alone)) {
    if (control.cancelled()) break;
    const ComparedPair pair = Compare(a, b, camera, options);
    found.text += PairText(pair);
    found.json["pairs"].push_back(PairJson(pair));
  }
  for (const std::string& path : alone) {
    found.text += "without a drape of the same name: " + path + "\n";
    found.json["alone"].push_back(path);
  }
  return found;
}

// The drapes in A as draws of a distribution that those in B were drawn from.
Found CompareDistributions(const MetricsOptions& options, const Camera& camera,
                           const RunControl& control) {
  std::vector<ObservedDrape> drapes[2];
  DistributionScorer::Drapes views[2];
  for (int side = 0; side < 2; ++side) {
    for (const std::string& path : DrapesIn(options.operands[side], side == 0 ? 2 : 1)) {
      if (control.cancelled()) return {};
      drapes[side].push_back(ViewFile(path, camera, options.data.hard_edged).seen);
    }
    for (const ObservedDrape& drape : drapes[side]) views[side].push_back(&drape);
  }
  DistributionScorer scorer;
  scorer.Add(views[0], views[1]);
  const DistributionScore score = scorer.Score();
  Found found{std::to_string(views[0].size()) + " draws in " + options.operands[0] +
                  ", observed in " + options.operands[1] + "\n" + ScoreText(score),
              ScoreJson(score)};
  found.json["draws"] = views[0].size();
  return found;
}

Found CompareOperands(const MetricsOptions& options, const Camera& camera,
                      const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  if (operands.size() != 2) {
    throw InputError("command line", "found " + std::to_string(operands.size()) +
                                         " files or folders, expected two (A and B) or --data");
  }
  const OperandKind a = KindOfOperand(operands[0]), b = KindOfOperand(operands[1]);
  if (a == OperandKind::kRun && b == OperandKind::kRun)
    return CompareRuns(options, camera, control);
  if (a != OperandKind::kFile && b != OperandKind::kFile)
    return CompareDistributions(options, camera, control);
  if (a != b)
    throw InputError(operands[a == OperandKind::kFile],
                     "is a folder, expected a file like " + operands[b == OperandKind::kFile]);
  const ComparedPair pair = Compare(operands[0], operands[1], camera, options);
  return {PairText(pair), PairJson(pair)};
}

Found EvaluateData(const MetricsOptions& options, const Camera& camera, const RunControl& control) {
  if (!options.operands.empty())
    throw InputError("command line", "found '" + options.operands[0] + "' beside --data");
  const DatasetReport report = EvaluateDataset(options.data, camera, control);
  return {DatasetText(report), DatasetJson(report)};
}

}  // namespace

OptionTable MetricsTable(MetricsOptions& options) {
  std::vector<Option> all = Grouped("camera", CameraOptions(options.camera));
  DatasetQuery& data = options.data;
  all.push_back({.key = "aligned",
                 .value = &data.aligned,
                 .doc = "with --data: also evaluate after the best rotation and reflection, which "
                        "takes longer"});
  for (const Option& option : Grouped("data set", DatasetOptions(data))) all.push_back(option);
  all.push_back(
      {.key = "out", .value = &options.out, .doc = "JSON file for the results", .is_path = true});
  return {.tool = "drape_metrics",
          .summary =
              "compares two drapes, scores predicted drapes, and evaluates predictors without a "
              "model on a data set",
          .example = "drape_metrics silhouette.png out/drape/drape.obj --out=metrics.json",
          .notes =
              "A and B: two images or OBJ meshes; two output folders of drape_simulate or "
              "drape_fit, whose drapes of the same name are compared; or two other folders of "
              "images and meshes: A holds samples of a distribution, B what was observed\n"
              "aligned: after the rotation and reflection of B that brings its outline closest to "
              "that of A\n",
          .options = std::move(all),
          .operands = &options.operands,
          .operand_names = "[A B]"};
}

std::string RunMetrics(const MetricsOptions& options, const RunControl& control) {
  const Camera camera = MakeCamera(options.camera);
  const Found found = options.data.folder.empty() ? CompareOperands(options, camera, control)
                                                  : EvaluateData(options, camera, control);
  if (control.cancelled()) return "";
  if (!options.out.empty()) {
    Json json = found.json;
    json["camera"] = CameraJson(camera);
    for (const auto& [name, version] : Versions()) json["versions"][name] = version;
    WriteFileAtomically(options.out, json.dump(2) + "\n");
  }
  return found.text;
}

}  // namespace drape
