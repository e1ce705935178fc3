// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/short_way.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "physics/util/stored/build.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/programs/front/programs.h"

extern char** environ;

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr StoredFormat kStepsFormat = {"drapefit-steps", 2};
constexpr double kGramsPerKilogram = 1000.0;

struct Step {
  std::string verb;
  std::vector<std::string> arguments;  // beside the program's path
  std::string result;                  // a file that is there when the step has ended
};

// Returns whether nearly all pixels are black or white, as in a silhouette of any size.
bool IsSilhouette(const GrayImage& image) {
  constexpr float kBlack = 0.15F, kWhite = 0.85F;
  constexpr double kLeastShare = 0.97;
  const auto plain = std::count_if(image.coverage.begin(), image.coverage.end(),
                                   [](float v) { return v < kBlack || v > kWhite; });
  return double(plain) >= kLeastShare * double(image.coverage.size());
}

// Finds configs/ of an installation, of a bundle, or of the sources of a build.
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
                   {"--fabric=" + out + "/fit", "--mesh=disc:600", discs[0], discs[1],
                    Format("--draws=%d", options.draws), threads, "--out=" + out + "/predict"},
                   out + "/predict/summary.json"});
  if (HasProgram(folder, "report"))
    steps.push_back({"report",
                     {out + "/fit", out + "/predict", "--out=" + out + "/report.html"},
                     out + "/report.html"});
  return steps;
}

// Returns whether all files that a step had read, by its summary, are unchanged.
bool HasSameInputs(const std::string& summary_path) try {
  const json summary = json::parse(ReadWholeFile(summary_path));
  for (const char* list : {"configs", "inputs"})
    for (const json& file : summary.at("provenance").at(list))
      if (Sha256(ReadWholeFile(file.at("path"))) != file.at("sha256").get<std::string>())
        return false;
  return true;
} catch (const std::exception&) {  // no summary, or a file is gone
  return false;
}

// steps.json of an output folder: its picture and, of each step, its key and whether it has ended.
class StepRecord {
 public:
  // Throws InputError where the folder has results of another picture.
  StepRecord(const std::string& out, const json& picture) : path_(out + "/steps.json") {
    CheckReplaceable(path_);
    try {
      if (fs::exists(path_)) record_ = ReadStoredJson(path_, kStepsFormat);
    } catch (const InputError&) {  // damaged, or of another version: the steps are run again
    }
    const json earlier = record_.value("picture", picture);
    if (earlier["sha256"] != picture["sha256"])
      throw InputError(out, "holds the results of another picture, " +
                                earlier["path"].get<std::string>() +
                                "; choose another folder with --out, or remove this one");
    record_["picture"] = picture;
  }

  bool HasDone(const Step& step, const std::string& key) const {
    return Is(step, key, true) && fs::exists(step.result) &&
           (!step.result.ends_with("/summary.json") || HasSameInputs(step.result));
  }
  bool WasStopped(const Step& step, const std::string& key) const {
    return step.verb == "fit" && Is(step, key, false);
  }
  void Set(const Step& step, const std::string& key, bool done) {
    record_[step.verb] = {{"key", key}, {"done", done}};
    WriteStoredJson(path_, kStepsFormat, record_, 2);
  }

 private:
  bool Is(const Step& step, const std::string& key, bool done) const {
    return record_.value(step.verb, json()) == json{{"key", key}, {"done", done}};
  }

  std::string path_;
  json record_ = json::object();
};

// A word as a shell reads it. Bytes that a terminal would not show as a character are escaped.
std::string ShellWord(const std::string& word) {
  constexpr char kPlain[] =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted;
  for (std::size_t i = 0, length = 0; i < word.size(); i += length) {
    length = std::max<std::size_t>(1, Utf8Length(word, i));
    const std::string character = word.substr(i, length);
    const bool is_shown = Utf8Length(word, i) > 0 && MakePrintableLine(character) == character;
    if (character == "'") {
      quoted += "'\\''";
    } else if (is_shown && character != "\t") {
      quoted += character;
    } else {
      for (const char byte : character)
        quoted += Format("'$'\\x%02x''", static_cast<unsigned char>(byte));
    }
  }
  return "'" + quoted + "'";
}

std::string CommandText(const Step& step) {
  std::string text = "drapefit " + step.verb;
  for (const std::string& argument : step.arguments) text += " " + ShellWord(argument);
  return text;
}

volatile std::sig_atomic_t running_child = 0;

extern "C" void PassOn(int signal) {
  if (running_child > 0) kill(static_cast<pid_t>(running_child), signal);
}

// Runs a program with the standard streams of this process and returns its exit code, or 128 and
// the signal that ended it. A process of its own: a step that runs out of memory leaves the others,
// and the record of its command and inputs is its own. It gets SIGINT and SIGTERM that arrive
// meanwhile, and this process waits for it to save its results.
int RunAttached(std::vector<std::string> command) {
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, PassOn);
  pid_t child = 0;
  const int error = posix_spawn(&child, words[0], nullptr, nullptr, words.data(), environ);
  if (error != 0) throw InputError(command[0], std::string("cannot be run: ") + strerror(error));
  running_child = child;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  running_child = 0;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  constexpr int kSignalled = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
}

// Prints the command of a step and runs it. Returns its exit code.
int RunStep(const Step& step, const std::string& folder) {
  std::printf("drapefit: %s\n", CommandText(step).c_str());
  std::fflush(stdout);
  std::vector<std::string> command = {ProgramPath(folder, step.verb)};
  command.insert(command.end(), step.arguments.begin(), step.arguments.end());
  const int code = RunAttached(command);
  if (code != 0)
    std::fprintf(stderr, "drapefit: drape_%s ended with exit code %d%s\n", step.verb.c_str(), code,
                 code == kExitBadInput ? "" : "; the same command continues from here");
  return code;
}

void Check(const ShortWayOptions& options) {
  if (options.operands.size() != 1)
    throw InputError("command line",
                     Format("found %zu pictures, expected one", options.operands.size()));
  if (options.mass <= 0)
    throw InputError("option 'mass'",
                     "is missing, expected the mass of the fabric by area in g/m2, as weighed: a "
                     "drape shows stiffness over weight");
  constexpr double kLightest = 10, kHeaviest = 1500;
  if (options.mass < kLightest || options.mass > kHeaviest)
    std::fprintf(stderr, "drapefit: note: a mass of %g g/m2; fabrics have %g to %g\n", options.mass,
                 kLightest, kHeaviest);
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
  StepRecord record(out, {{"path", MakeUtf8(picture)}, {"sha256", Sha256(ReadWholeFile(picture))}});
  bool run_all = false;  // what follows a step that was run again is run again
  for (const Step& step : steps) {
    std::string key = MakeUtf8(CommandText(step) + " # " + BuildCommit());
    if (step.verb == "fit" && !options.fit_config.empty())
      key += " " + Sha256(ReadWholeFile(options.fit_config));
    if (!run_all && record.HasDone(step, key)) {
      std::printf("drapefit: done before: %s\n", CommandText(step).c_str());
      continue;
    }
    run_all = true;
    Step now = step;
    if (record.WasStopped(step, key) && fs::exists(out + "/fit/checkpoint.json"))
      now.arguments.push_back("--resume");
    record.Set(step, key, false);
    if (const int code = RunStep(now, folder); code != 0) return code;
    record.Set(step, key, true);
  }
  std::printf("drapefit: see %s\n", MakePrintable(steps.back().result).c_str());
  return 0;
}

}  // namespace drape
