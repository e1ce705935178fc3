// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/wear_job.h"
#include "solver/prediction/prediction.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

// The options of drape_garment.
struct GarmentOptions {
  WearSpec spec;
  FabricInput fabric;
  int threads = 0;
  std::string backend = "auto";  // MakeStepLinearSolver
  std::string out;
  bool resume = false, preview = false;
  std::set<std::string> given;  // OptionTable::given
};

// The garment, the body and the simulation, with what --preview sets where it is not given.
WearSpec ChosenSpec(const GarmentOptions& options) {
  WearSpec spec = options.spec;
  const OptionTable table{{}, {}, {}, {}, FieldOptionList(spec)};
  for (const auto& [key, text] : {std::pair("time_step", "0.04"),
                                  {"creep_speed", "0.01"},
                                  {"friction_rounds", "1"},
                                  {"tolerance", "0.01"}})
    if (options.preview && !options.given.contains(key)) table.Set(key, text, "preview");
  return spec;
}

std::vector<Option> ComputationOptions(GarmentOptions& options) {
  return {
      {.key = "preview",
       .value = &options.preview,
       .doc = "fast and less exact: sets time_step, creep_speed, friction_rounds and tolerance "
              "where they are not given"},
      ThreadsOption(options.threads),
      ChoiceOption(
          "backend", &options.backend, {"auto", "cpu", "cuda"},
          "device of the factorisations; auto: a CUDA device if there is one, else the CPU. "
          "The rest is on the CPU"),
  };
}

MaterialSource MakeMaterials(const GarmentOptions& options, const ClothModel& model) {
  const FabricSource fabric = ReadFabric(
      options.fabric.path, ReadingPolicy(model.law, options.fabric.min_relative_stiffness));
  if (!fabric.posterior && options.spec.draws > 1 && options.spec.wear.start_noise == 0.0)
    throw InputError("option 'draws'",
                     "found more than one of a material, expected a posterior or a positive "
                     "--start_noise");
  return MakeSpecimens(fabric, model.mesh, static_cast<uint64_t>(options.spec.seed));
}

OptionTable GarmentTable(GarmentOptions& options) {
  std::vector<Option> spec = FieldOptionList(options.spec);
  spec.front().required = true;
  return {
      .tool = "drape_garment",
      .summary = "dresses a moving body in a garment of a fitted fabric",
      .example =
          "drape_garment --garment=configs/garments/circle_skirt.json "
          "--body=mannequin:walk --fabric=configs/fabrics/cotton_blue.json "
          "--out=out/skirt",
      .notes =
          "files: garment.obj and garment.pc2 (its points in 25 frames a second), the same of "
          "the body, summary.json; of several draws each in a folder. drape_report plays them; in "
          "Blender load_in_blender.py (share/drapefit/garment) loads them.\n"
          "A body of your own stands upright. Axes, unit and place are guessed and reported. "
          "An open surface is wrapped. A garment that slides off has failed.\n"
          "Ctrl-C keeps the frames so far; --resume continues. exit code 3: a step did not "
          "converge, or the garment is not worn at the end; the frames are there\n",
      .options = Concatenate(
          Grouped("garment, body and simulation", spec),
          Grouped("fabric", FieldOptionList(options.fabric)),
          Grouped("computation", ComputationOptions(options)),
          Grouped("results", std::vector<Option>{OutOption(options.out),
                                                 {.key = "resume",
                                                  .value = &options.resume,
                                                  .doc = "continue from the frames in --out",
                                                  .repeated = false}})),
      .common = {"garment", "body", "fabric", "draws", "edge", "seconds", "preview", "friction",
                 "out"},
      .given = &options.given};
}

std::string GarmentText(const GarmentResult& result) {
  std::string text =
      Format("%-10s %8s %7s %10s %11s %9s %9s %9s %9s\n", "", "vertices", "frames", "gap [mm]",
             "stretch [%]", "body hits", "self hits", "hem [cm]", "s/frame");
  for (const GarmentRun& run : result.runs)
    text += Format("%-10s %8d %7d %10.2f %11.1f %9d %9d %9.1f %9.2f\n", run.name.c_str(),
                   run.vertices, run.wear.frames, 1e3 * run.smallest_gap,
                   100.0 * run.largest_stretch, run.body_intersections, run.self_intersections,
                   100.0 * run.hem_height, run.seconds / std::max(1, run.wear.frames - 1));
  if (result.body_files == 0) return text;
  const BodyFiles& files = result.spec.body_files;
  text += Format("body: %d file%s, which end%s at %.2f s%s", result.body_files,
                 result.body_files == 1 ? "" : "s", result.body_files == 1 ? "s" : "",
                 result.body_rests_after, files.grow ? ", of which it grows for 0.50 s" : "");
  const bool rests = result.body_rests_after < result.spec.seconds;
  return text + (rests ? Format("; then it rests until %.2f s\n", result.spec.seconds) : "\n");
}

// The reason why a run has not reached its end, or empty.
std::string GarmentFailure(const GarmentResult& result) {
  for (const GarmentRun& run : result.runs)
    if (run.wear.status == WearStatus::kFailed)
      return (run.name.empty() ? "" : run.name + ": ") + run.wear.reason +
             ", see the frames before";
  return "";
}

ToolOutcome Run(const GarmentOptions& options, const RunControl& control) {
  const OutputFolder out(options.out, {"summary.json", "garment.obj", "garment.pc2", "body.obj",
                                       "body.pc2", "checkpoint.json"});
  const GarmentResult result = RunWearJob(
      ChosenSpec(options),
      {.threads = CountThreads(options.threads),
       .step_threads = options.threads,
       .backend = options.backend,
       .out = options.out,
       .resume = options.resume},
      [&](const ClothModel& model) { return MakeMaterials(options, model); }, control);
  nlohmann::ordered_json summary = WearSummary(result);
  summary["material"] = options.fabric.path;
  summary["min_relative_stiffness"] = options.fabric.min_relative_stiffness;
  WriteWithProvenance(out.Staged("summary.json"), std::move(summary));
  out.Publish();
  return {.text = GarmentText(result),
          .cancelled = result.cancelled,
          .failure = GarmentFailure(result)};
}

}  // namespace

int GarmentMain(int argc, char** argv) { return ToolMain(argc, argv, GarmentTable, Run); }

}  // namespace drape
