// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/measure/metrics/metrics_tool.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/job/plot/chart.h"
#include "tools/cli/field_options.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/measure/metrics/metrics_input.h"
#include "tools/programs/measure/metrics/metrics_report.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// How drapes are looked at by themselves and in a comparison. files: what says of which discs they
// are, which have to agree.
View MakeView(const MetricsOptions& options, CentreMode by_default,
              std::vector<std::string> files) {
  const CentreMode centre =
      options.centre == "auto" ? by_default : ParseName<CentreMode>(options.centre, "centre");
  const std::size_t count = files.size();
  for (std::size_t i = 0; i < count; ++i) files.push_back(options.camera.FileFor(files[i]));
  return {options.camera, centre, options.data.hard_edged, FindDiscs(options.discs, files)};
}

void AppendNotes(const ViewedFile& file, std::vector<std::string>* notes) {
  if (!file.quality) return;
  for (const std::string& note : file.quality->notes) notes->push_back(file.path + ": " + note);
}

ComparedPair Compare(const std::string& a, const std::string& b, const View& view,
                     const Camera& camera) {
  const ViewedFile first = ViewFileBeside(a, view, camera);
  const ViewedFile second = ViewFileBeside(b, view, camera);
  ComparedPair pair{
      a, b, CompareDrapes(first.seen, second.seen, camera), {}, first.seen.shape, second.seen.shape,
      {}};
  AppendNotes(first, &pair.notes);
  AppendNotes(second, &pair.notes);
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

MeasuredDrape Measure(const std::string& path, const View& view, ViewedFile* viewed) {
  *viewed = ViewFile(path, view);
  return {path,
          {},
          viewed->camera,
          viewed->quality,
          ProfileArea(viewed->seen.radius),
          viewed->seen.radius.mean(),
          viewed->seen.shape,
          MeasureLaboratoryDrape(viewed->seen.radius, view.discs)};
}

Found MeasureOne(const MetricsOptions& options, const std::string& path) {
  const View view = MakeView(options, CentreMode::kOutline, {path});
  ViewedFile viewed;
  const MeasuredDrape drape = Measure(path, view, &viewed);
  if (!options.csv.empty()) WriteFileAtomically(options.csv, MeasuredCsv({drape}));
  if (!options.overlay.empty()) {
    const GrayImage picture = viewed.surface ? viewed.seen.image : ReadImage(path);
    const Eigen::VectorXd radius_px = viewed.seen.radius * viewed.camera.pixels_per_metre();
    WritePng(RenderMeasurement(picture, radius_px, viewed.camera, view.discs), options.overlay);
  }
  return {MeasuredText(drape), MeasuredJson(drape)};
}

// A drape that cannot be measured becomes a line with the reason.
Found MeasureEach(const MetricsOptions& options, const std::vector<std::string>& files,
                  const RunControl& control) {
  std::vector<MeasuredDrape> drapes;
  std::string first_error;
  size_t measured = 0;
  for (const std::string& file : files) {
    if (control.cancelled()) return {};
    control.Report(static_cast<double>(drapes.size()) / static_cast<double>(files.size()), file);
    try {
      ViewedFile viewed;
      drapes.push_back(Measure(file, MakeView(options, CentreMode::kOutline, {file}), &viewed));
      ++measured;
    } catch (const InputError& error) {
      const std::string reason = error.what();
      const bool named = reason.starts_with(file + ": ");
      drapes.push_back(
          {file, named ? reason.substr(file.size() + 2) : reason, {}, {}, 0, 0, {}, {}});
      if (first_error.empty()) first_error = reason;
    }
  }
  if (measured == 0)
    throw InputError(options.operands[0], "none of " + std::to_string(files.size()) +
                                              " drapes can be measured; " + first_error);
  if (!options.csv.empty()) WriteFileAtomically(options.csv, MeasuredCsv(drapes));
  Found found{MeasuredTable(drapes), {{"drapes", Json::array()}}};
  for (const MeasuredDrape& drape : drapes) found.json["drapes"].push_back(MeasuredJson(drape));
  return found;
}

Found CompareRuns(const MetricsOptions& options, const RunControl& control) {
  Found found{"", {{"pairs", Json::array()}, {"alone", Json::array()}}};
  const View view =
      MakeView(options, CentreMode::kNominal,
               {options.operands[0] + "/summary.json", options.operands[1] + "/summary.json"});
  const Camera camera = MakeCamera(options.camera, view.discs);
  found.json["camera"] = CameraJson(camera);
  std::vector<std::string> alone;
  for (const auto& [a, b] : PairDrapes(options.operands[0], options.operands[1], &alone)) {
    if (control.cancelled()) break;
    const ComparedPair pair = Compare(a, b, view, camera);
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
Found CompareDistributions(const MetricsOptions& options, const RunControl& control) {
  std::vector<std::string> files[2];
  for (int side = 0; side < 2; ++side)
    files[side] = DrapesIn(options.operands[side], side == 0 ? 2 : 1);
  std::vector<std::string> all = files[0];
  all.insert(all.end(), files[1].begin(), files[1].end());
  const View view = MakeView(options, CentreMode::kNominal, all);
  const Camera camera = FindCamera(options.camera, view.discs, all);
  std::vector<ObservedDrape> drapes[2];
  DistributionScorer::Drapes views[2];
  for (int side = 0; side < 2; ++side) {
    for (const std::string& path : files[side]) {
      if (control.cancelled()) return {};
      drapes[side].push_back(ViewFileBeside(path, view, camera).seen);
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
  found.json["camera"] = CameraJson(camera);
  return found;
}

Found CompareTwo(const MetricsOptions& options, const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  const OperandKind a = KindOfOperand(operands[0]), b = KindOfOperand(operands[1]);
  if (a == OperandKind::kRun && b == OperandKind::kRun) return CompareRuns(options, control);
  if (a != OperandKind::kFile && b != OperandKind::kFile)
    return CompareDistributions(options, control);
  if (a != b)
    throw InputError(operands[a == OperandKind::kFile],
                     "is a folder, expected a file like " + operands[b == OperandKind::kFile]);
  const View view = MakeView(options, CentreMode::kNominal, operands);
  const Camera camera = FindCamera(options.camera, view.discs, operands);
  const ComparedPair pair = Compare(operands[0], operands[1], view, camera);
  Found found{PairText(pair), PairJson(pair)};
  found.json["camera"] = CameraJson(camera);
  return found;
}

void RequireOnlyWith(const std::string& option, const std::string& value, bool fits,
                     const std::string& expected) {
  if (!value.empty() && !fits) throw InputError("option '" + option + "'", "expected " + expected);
}

Found EvaluateOperands(const MetricsOptions& options, const RunControl& control) {
  const std::vector<std::string>& operands = options.operands;
  if (operands.empty())
    throw InputError("command line",
                     "found no file or folder, expected a drape, a folder of them, "
                     "two to compare (A and B), or --data");
  const bool one = operands.size() == 1, folder = one && fs::is_directory(operands[0]);
  RequireOnlyWith("overlay", options.overlay, one && !folder, "one drape");
  RequireOnlyWith("csv", options.csv, operands.size() != 2, "drapes that are not compared");
  if (operands.size() == 2) return CompareTwo(options, control);
  if (folder) return MeasureEach(options, DrapesIn(operands[0], 1), control);
  for (const std::string& operand : operands) {
    if (KindOfOperand(operand) != OperandKind::kFile)
      throw InputError(operand, "is a folder among files, expected one folder, or files");
  }
  return one ? MeasureOne(options, operands[0]) : MeasureEach(options, operands, control);
}

Found EvaluateData(const MetricsOptions& options, const RunControl& control) {
  const Camera camera = MakeCamera(options.camera, DrapeDiscs());
  if (FindDiscs(options.discs) != DrapeDiscs())
    throw InputError("option 'specimen' or 'support'",
                     "found " + ToString(FindDiscs(options.discs)) +
                         " beside the published data set, expected its " + ToString(DrapeDiscs()));
  if (!options.operands.empty())
    throw InputError("command line", "found '" + options.operands[0] + "' beside --data");
  const DatasetReport report = EvaluateDataset(options.data, camera, control);
  Found found{DatasetText(report), DatasetJson(report)};
  found.json["camera"] = CameraJson(camera);
  return found;
}

// How drapes are looked at.
std::vector<Option> ViewOptions(MetricsOptions& options) {
  return {{.key = "centre",
           .value = &options.centre,
           .doc = "where the support's centre is: nominal: at camera_cx, camera_cy; outline: "
                  "found from the outline of each drape; auto: outline for drapes by "
                  "themselves, nominal for those that are compared",
           .choices = {"auto", "nominal", "outline"}},
          {.key = "aligned",
           .value = &options.data.aligned,
           .doc = "with --data: also evaluate after the best rotation and reflection, which "
                  "takes longer"}};
}

std::vector<Option> FileOptions(MetricsOptions& options) {
  return {
      {.key = "csv",
       .value = &options.csv,
       .doc = "drapes by themselves: file with one line for each",
       .is_path = true},
      {.key = "overlay",
       .value = &options.overlay,
       .doc = "one drape by itself: PNG of its outline (blue), the support (green) and the flat "
              "cloth (brown)",
       .is_path = true},
      {.key = "out", .value = &options.out, .doc = "JSON file for the results", .is_path = true}};
}

}  // namespace

OptionTable MetricsTable(MetricsOptions& options) {
  std::vector<Option> all =
      Concatenate(Grouped("camera", CameraOptions(options.camera)), FieldOptionList(options.discs),
                  ViewOptions(options), Grouped("data set", DatasetOptions(options.data)),
                  OfOneRun(FileOptions(options)));
  return {
      .tool = "drape_metrics",
      .summary =
          "measures drapes, compares two, scores predicted drapes, and evaluates predictors "
          "without a model on a data set",
      .example = "drape_metrics photo.jpg --image_width_mm=400 --overlay=outline.png",
      .notes =
          "one image or OBJ mesh: drape coefficient, folds, area, radii and other features of the "
          "outline; a folder, or three or more files: a line for each; what cannot be measured "
          "becomes a line with the reason (exit code 2 only if nothing can be measured)\n"
          "two, A and B, are compared: two images or OBJ meshes; two output folders of "
          "drape_simulate or drape_fit, whose drapes of the same name are compared; or two other "
          "folders of images and meshes: A holds samples of a distribution, B what was observed\n"
          "aligned: after the rotation and reflection of B that brings its outline closest to "
          "that of A\n",
      .options = std::move(all),
      .common = {"image_width_mm", "camera_scale", "specimen", "support", "centre", "csv",
                 "overlay", "data", "data_fabric", "out"},
      .operands = &options.operands,
      .operand_names = "[A [B …]]"};
}

std::string RunMetrics(const MetricsOptions& options, const RunControl& control) {
  for (const std::string& file : {options.out, options.csv, options.overlay})
    if (!file.empty()) CheckReplaceable(file);
  const Found found = options.data.folder.empty() ? EvaluateOperands(options, control)
                                                  : EvaluateData(options, control);
  if (control.cancelled()) return "";
  if (!options.out.empty()) WriteWithProvenance(options.out, found.json);
  return found.text;
}

namespace {

ToolOutcome Run(const MetricsOptions& options, const RunControl& control) {
  return {.text = RunMetrics(options, control), .cancelled = control.cancelled()};
}

}  // namespace

int MetricsMain(int argc, char** argv) { return ToolMain(argc, argv, MetricsTable, Run); }

}  // namespace drape
