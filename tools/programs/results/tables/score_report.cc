// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/score_report.h"

#include <nlohmann/json.hpp>
#include <set>

#include "losses/dataset/dataset.h"
#include "losses/metrics/metrics.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kGreyImage[] = "grey mean image";  // has no outline

std::string PredictorLine(const PredictorRow& row) {
  std::string text =
      Format("%-26s %6d %8.4f %8.4f", row.name.c_str(), row.pairs, row.mean.mse, row.median.mse);
  if (row.name == kGreyImage) return text + Format(" %7s %8s\n", "-", "-");
  text += Format(" %7.3f %8.2f", row.mean.iou, row.mean.outline_hausdorff / kMm);
  if (row.aligned_mean)
    text +=
        Format(" %9.4f %8.2f", row.aligned_mean->mse, row.aligned_mean->outline_hausdorff / kMm);
  return text + "\n";
}

Json PredictorJson(const PredictorRow& row) {
  Json json = {{"name", row.name}, {"pairs", row.pairs}};
  if (row.name == kGreyImage) {
    json["mean"] = {{"mse", row.mean.mse}};
    json["median"] = {{"mse", row.median.mse}};
    return json;
  }
  json["mean"] = DistanceJson(row.mean);
  json["median"] = DistanceJson(row.median);
  if (row.aligned_mean) json["aligned_mean"] = DistanceJson(*row.aligned_mean);
  return json;
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

std::string PredictorsText(const TrivialPredictors& predictors) {
  std::string text = Format("%-26s %6s %8s %8s %7s %8s %9s %8s\n", "predicted by", "pairs", "MSE",
                            "median", "IoU", "H [mm]", "aligned", "H [mm]");
  for (const PredictorRow& row : predictors.rows) text += PredictorLine(row);
  if (predictors.other_samples)
    text += "other samples of the fabric and face, as a distribution\n" +
            ScoreText(*predictors.other_samples);
  if (predictors.normal)
    text += Format(
        "normal distribution of their features: energy score of the features %.3f, %.2f of them in "
        "the intervals of 90 %% of DC\n",
        predictors.normal->feature_energy, predictors.normal->features[0].ninety.coverage);
  if (predictors.circle)
    text += "circle of the mean area, as a distribution\n" + ScoreText(*predictors.circle);
  return text;
}

Json PredictorsJson(const TrivialPredictors& predictors) {
  Json json = {{"rows", Json::array()}};
  for (const PredictorRow& row : predictors.rows) json["rows"].push_back(PredictorJson(row));
  json["other_samples"] =
      predictors.other_samples ? ScoreJson(*predictors.other_samples) : Json(nullptr);
  json["normal"] = predictors.normal ? ScoreJson(*predictors.normal) : Json(nullptr);
  json["circle"] = predictors.circle ? ScoreJson(*predictors.circle) : Json(nullptr);
  return json;
}

}  // namespace

Json DistanceJson(const DrapeDistance& distance) {
  return {{"mse", distance.mse},
          {"iou", distance.iou},
          {"outline_rms_m", distance.profile_rms},
          {"outline_hausdorff_m", distance.outline_hausdorff}};
}

std::string ScoreText(const DistributionScore& score) {
  std::string text = Format("%-12s %10s %10s %10s %10s %15s %15s\n", "", "observed", "predicted",
                            "sd", "CRPS", "in 50 % (of)", "in 90 % (of)");
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureScore& f = score.features[k];
    const double unit = k < 2 ? 1 : kMm2;
    text += Format("%-12s %10.4g %10.4g %10.3g %10.3g %8.2f (%.2f) %8.2f (%.2f)%s\n",
                   kFeatureNames[k], f.observed_mean / unit, f.predicted_mean / unit,
                   f.predicted_sd / unit, f.crps / unit, f.half.coverage, f.half.nominal,
                   f.ninety.coverage, f.ninety.nominal, k < 2 ? "" : "  mm2");
  }
  return text + Format(
                    "MSE of the mean image %.4f, energy score of the features %.3f, of the "
                    "outlines %.2f mm, %d observed\n",
                    score.mean_image_mse, score.feature_energy, score.outline_energy / kMm,
                    score.observed);
}

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
