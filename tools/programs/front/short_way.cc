// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/short_way.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "tools/programs/front/child.h"
#include "tools/programs/front/programs.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr StoredFormat kStepsFormat = {"drapefit-steps", 1};
constexpr double kGramsPerKilogram = 1000.0;

struct Step {
  std::string verb;
  std::vector<std::string> arguments;  // beside the program's path
  std::string result;                  // a file that is there when the step has ended
};

// Whether nearly all pixels are black or white. The edges of a drape are few, whatever its size.
bool IsSilhouette(const GrayImage& image) {
  constexpr float kBlack = 0.15F, kWhite = 0.85F;
  constexpr double kLeastShare = 0.97;
  const auto plain = std::count_if(image.coverage.begin(), image.coverage.end(),
                                   [](float v) { return v < kBlack || v > kWhite; });
  return double(plain) >= kLeastShare * double(image.coverage.size());
}

// Where configs/ is: installed, in a bundle, or in the sources of a build.
std::string FindConfigs(const std::string& folder) {
  for (const char* place : {"../share/drapefit/configs", "../configs", "../../../configs"}) {
    const fs::path configs = (fs::path(folder) / place).lexically_normal();
    if (fs::exists(configs / "programs/fit_bayes.json")) return configs;
  }
  throw InputError("option 'fit_config'",
                   "not given, and the configs of drapefit are not beside its programs");
}

void RequireProgram(const std::string& folder, const std::string& verb, const std::string& why) {
  if (!HasProgram(folder, verb))
    throw InputError("drape_" + verb, "is not among the programs here, " + why);
}

// The steps that make sense for the picture and the programs that are here.
std::vector<Step> PlanSteps(const ShortWayOptions& options, const std::string& folder,
                            const std::string& out) {
  const std::string picture = options.operands[0];
  const bool silhouette = options.picture == "silhouette" ||
                          (options.picture == "auto" && IsSilhouette(ReadImage(picture)));
  const std::vector<std::string> discs = {Format("--specimen=%g", options.specimen),
                                          Format("--support=%g", options.support)};
  std::vector<Step> steps;
  Step fit = {"fit", {}, out + "/fit/summary.json"};
  const std::string config = options.fit_config.empty()
                                 ? FindConfigs(folder) + "/programs/fit_bayes.json"
                                 : options.fit_config;
  fit.arguments = {"--config=" + config, "--images=" + picture};
  if (!silhouette) {
    RequireProgram(folder, "photo",
                   "expected for a photograph; make a silhouette of it, black cloth on white");
    Step photo = {"photo", {picture}, out + "/photo/summary.json"};
    photo.arguments.insert(photo.arguments.end(), discs.begin(), discs.end());
    if (options.focal_35mm > 0)
      photo.arguments.push_back(Format("--focal_35mm=%g", options.focal_35mm));
    photo.arguments.push_back("--out=" + out + "/photo");
    steps.push_back(photo);
    fit.arguments[1] = "--images=" + out + "/photo/silhouette.png";
    fit.arguments.push_back("--camera_file=" + out + "/photo/camera.json");
  }
  const std::string threads = Format("--threads=%d", options.threads);
  fit.arguments.insert(fit.arguments.end(), discs.begin(), discs.end());
  fit.arguments.push_back(Format("--density=%.9g", options.mass / kGramsPerKilogram));
  fit.arguments.push_back(threads);
  fit.arguments.push_back("--out=" + out + "/fit");
  steps.push_back(fit);
  steps.push_back({"predict",
                   {"--posterior=" + out + "/fit", "--mesh=disc:600", discs[0], discs[1],
                    Format("--draws=%d", options.draws), threads, "--out=" + out + "/predict"},
                   out + "/predict/summary.json"});
  if (HasProgram(folder, "report"))
    steps.push_back({"report",
                     {out + "/fit", out + "/predict", "--out=" + out + "/report.html"},
                     out + "/report.html"});
  return steps;
}

// What is known of a step: its key, and whether it has ended.
json ReadRecord(const std::string& path) {
  if (!fs::exists(path)) return json::object();
  try {
    return ReadStoredJson(path, kStepsFormat);
  } catch (const InputError&) {  // damaged, or of another version: the steps are run again
    return json::object();
  }
}

// A text that differs where the step would: its command, and what the steps before it had.
std::string StepKey(const Step& step, const std::string& before) {
  std::string text = step.verb;
  for (const std::string& argument : step.arguments) text += "\n" + argument;
  return Format("%016zx", std::hash<std::string>{}(text + "\n" + before));
}

std::string Quoted(const std::string& argument) {
  const bool plain = argument.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWX"
                         "YZ0123456789_-+=./:,@%") == std::string::npos;
  return plain && !argument.empty() ? argument : "'" + argument + "'";
}

std::string CommandText(const Step& step) {
  std::string text = "drapefit " + step.verb;
  for (const std::string& argument : step.arguments) text += " " + Quoted(argument);
  return MakePrintable(text);
}

void Check(const ShortWayOptions& options) {
  if (options.operands.size() != 1)
    throw InputError("command line",
                     Format("found %zu pictures, expected one", options.operands.size()));
  if (options.mass <= 0)
    throw InputError("option 'mass'",
                     "is missing, expected the mass of the fabric by area in g/m2, as weighed: a "
                     "drape shows stiffness over weight");
}

std::vector<Option> ShortWayOptionList(ShortWayOptions& options) {
  const auto metres = [](const char* key, double* value, const char* doc) {
    return Option{.key = key, .value = value, .doc = doc, .unit = "m", .least = 0.05, .most = 1};
  };
  return {{.key = "mass",
           .value = &options.mass,
           .doc = "mass of the fabric by area, as weighed; needed",
           .unit = "g/m2",
           .least = 0,
           .most = 10000},
          metres("specimen", &options.specimen, "diameter of the flat specimen"),
          metres("support", &options.support, "diameter of the support"),
          {.key = "focal_35mm",
           .value = &options.focal_35mm,
           .doc = "focal length of the photograph's lens as for a full-frame camera; 0: from the "
                  "file",
           .unit = "mm",
           .least = 0,
           .most = 2000},
          {.key = "picture",
           .value = &options.picture,
           .doc = "what the picture is; auto: a silhouette where nearly all pixels are black or "
                  "white, which is taken as seen by the camera of the published images",
           .choices = {"auto", "photo", "silhouette"}},
          {.key = "fit_config",
           .value = &options.fit_config,
           .doc = "config file of drape_fit; empty: configs/programs/fit_bayes.json, a posterior "
                  "of two numbers",
           .is_path = true},
          {.key = "draws",
           .value = &options.draws,
           .doc = "number of predicted drapes",
           .least = 2,
           .most = 4096},
          {.key = "threads",
           .value = &options.threads,
           .doc = "number of threads of each step; 0: all cores",
           .least = 0,
           .most = 4096},
          {.key = "out",
           .value = &options.out,
           .doc = "output folder; empty: out/ and the name of the picture",
           .is_path = true}};
}

}  // namespace

OptionTable ShortWayTable(ShortWayOptions& options) {
  std::string verbs;
  for (const Program& program : Programs())
    verbs += std::string(program.verb) + ": " + program.summary + "\n";
  return {.tool = "drapefit",
          .summary =
              "runs the programs of drapefit by their verbs; given a picture of a drape, runs "
              "all that leads to a report: photo, fit, predict, report",
          .example = "drapefit photo.jpg --mass=150 --specimen=0.30",
          .notes =
              "VERB [options]: runs drape_VERB, which is beside drapefit; help VERB: its help\n"
              "PICTURE: photo/, fit/, predict/ and report.html are written to the output folder. "
              "The same command again runs only what is not done; it continues a fit that was "
              "interrupted. A step that fails ends the run with its line and exit code.\n" +
              verbs,
          .options = ShortWayOptionList(options),
          .operands = &options.operands,
          .operand_names = "PICTURE|VERB"};
}

int RunShortWay(const ShortWayOptions& options, const std::string& folder) {
  Check(options);
  const std::string picture = options.operands[0];
  const std::string out =
      options.out.empty() ? "out/" + fs::path(picture).stem().string() : options.out;
  const std::vector<Step> steps = PlanSteps(options, folder, out);
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw InputError(out, "cannot be made: " + error.message());
  const std::string record_path = out + "/steps.json";
  CheckReplaceable(record_path);
  json record = ReadRecord(record_path);
  std::string key = ReadWholeFile(picture);
  if (!options.fit_config.empty()) key += ReadWholeFile(options.fit_config);
  for (const Step& step : steps) {
    key = StepKey(step, key);
    const json known = record.value(step.verb, json::object());
    const bool same = known.value("key", "") == key;
    if (same && known.value("done", false) && fs::exists(step.result)) {
      std::printf("drapefit: done before: %s\n", CommandText(step).c_str());
      continue;
    }
    Step now = step;
    const bool stopped = same && step.verb == "fit" && fs::exists(out + "/fit/checkpoint.json");
    if (stopped) now.arguments.push_back("--resume");
    record[step.verb] = {{"key", key}, {"done", false}};
    WriteStoredJson(record_path, kStepsFormat, record, 2);
    std::printf("drapefit: %s\n", CommandText(now).c_str());
    std::fflush(stdout);
    std::vector<std::string> command = {ProgramPath(folder, step.verb)};
    command.insert(command.end(), now.arguments.begin(), now.arguments.end());
    if (const int code = RunAttached(command); code != 0) {
      std::fprintf(stderr,
                   "drapefit: drape_%s ended with exit code %d; the same command continues "
                   "from here\n",
                   step.verb.c_str(), code);
      return code;
    }
    record[step.verb]["done"] = true;
    WriteStoredJson(record_path, kStepsFormat, record, 2);
  }
  std::printf("drapefit: see %s\n", MakePrintable(steps.back().result).c_str());
  return 0;
}

}  // namespace drape
