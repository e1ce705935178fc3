// SPDX-License-Identifier: Apache-2.0
// All programs in one executable: drapefit VERB, or a link drape_VERB to it, runs one of them, and
// drapefit PICTURE or drapefit SAMPLES all steps to a report.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "physics/util/stored/build.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"
#include "tools/cli/program_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/samples.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A program: drapefit VERB, or drape_VERB, a link to drapefit.
struct Program {
  const char* verb;
  const char* task;                    // heading of the list of verbs
  const char* summary;                 // one line of the list, at most 74 columns
  int (*main)(int argc, char** argv);  // nullptr: an executable of its own beside drapefit
};

constexpr char kReport[] = "from a photograph to a report";
constexpr char kDrapes[] = "drapes and garments";
constexpr char kFabrics[] = "many fabrics and models";
constexpr char kScene[] = "your own scene, and the solver";
constexpr char kStudies[] = "studies of accuracy and cost";

constexpr Program kPrograms[] = {
    {"photo", kReport, "find the outline of a drape in a photograph", nullptr},
    {"fit", kReport, "estimate the stiffness of a fabric from silhouettes or tests", FitMain},
    {"predict", kReport, "predict how further samples of a fabric drape", PredictMain},
    {"report", kReport, "show results in one HTML page", ReportMain},
    {"serve", kReport, "measure, fit and compare on a page of your own browser", nullptr},
    {"export", kReport, "write a fitted fabric for other simulators and for statistics",
     ExportMain},
    {"simulate", kDrapes, "drape a fabric of known stiffness", SimulateMain},
    {"fabrics", kDrapes, "list the fabrics that programs know by name", FabricsMain},
    {"metrics", kDrapes, "measure and compare drapes: coefficient, folds, outline", MetricsMain},
    {"equilibria", kDrapes, "find all stable drapes of a fabric", EquilibriaMain},
    {"garment", kDrapes, "dress a moving body in a garment of a fitted fabric", GarmentMain},
    {"space", kFabrics, "measure distances between fabrics, find outliers, recognise fabrics",
     SpaceMain},
    {"compare", kFabrics, "compare material models on drapes that no fit has seen", CompareMain},
    {"check", kScene, "check forces, energies and derivatives of a scene", CheckMain},
    {"bench", kStudies, "measure cost and error over lists of settings", BenchMain},
    {"speed", kStudies, "time a simulation step beside published times", SpeedMain},
    {"stability", kStudies, "map where solvers of a drape succeed and fail", StabilityMain},
    {"gradients", kStudies, "show where gradients of a drape fail", GradientsMain},
    {"compare_optimisers", kStudies, "compare optimisers at equal cost, start and budget",
     CompareOptimisersMain}};

// "compare_optimisers" or "compare-optimisers"; nullptr: there is none.
const Program* FindProgram(std::string verb) {
  std::replace(verb.begin(), verb.end(), '-', '_');
  for (const Program& program : kPrograms)
    if (verb == program.verb) return &program;
  return nullptr;
}

// drapefit PHOTO --mass=150: from one photograph to a report, by the programs that do each step.
struct ShortWayOptions {
  std::vector<std::string> operands;  // one picture, table of samples or folder
  double mass = 0.0;                  // of the fabric by area [g/m²]; 0: not given
  double specimen = 0.30;             // diameter [m]
  double support = 0.18;              // diameter [m]
  double focal_35mm = 0.0;       // of the lens, as for a full-frame camera [mm]; 0: from the file
  std::string picture = "auto";  // "photo", "silhouette"
  std::string warp = kUnknownWarp;  // ParseWarp
  ScaleInput scale;                 // of a silhouette or a scan
  std::string fit_config;           // of drape_fit; empty: that of two numbers and a posterior
  int draws = 16;                   // of the prediction
  int threads = 0;                  // 0: all cores
  std::string out;                  // empty: out/<name of the picture>
};

constexpr StoredFormat kStepsFormat = {"drapefit-steps", 4};
constexpr double kGramsPerKilogram = 1000.0;

struct Step {
  std::string verb;
  std::vector<std::string> arguments;  // beside the program's path
  std::string result;                  // a file that is there when the step has ended
};

bool ShowsSilhouette(const ShortWayOptions& options, const std::string& picture) {
  return options.picture == "silhouette" ||
         (options.picture == "auto" && IsSilhouette(ReadImage(picture)));
}

// The mass of a fabric [g/m²].
double FindMass(const ShortWayOptions& options, const SampleTable& table,
                const std::string& fabric) {
  for (const SampleRow& row : table.rows)
    if (row.of("fabric") == fabric && row.mass > 0) return row.mass;
  if (options.mass > 0) return options.mass;
  const bool is_table = !table.path.empty();
  throw InputError(is_table ? table.path : "option 'mass'",
                   (is_table ? "has no mass of the fabric '" + fabric + "'" : "is missing") +
                       ", expected the mass by area in g/m2, as weighed, as --mass or in the "
                       "column 'mass': a drape shows stiffness over weight");
}

// The folder of the fit of a fabric, in a path without what other programs read as a pattern.
std::string FitFolder(const std::string& out, std::string fabric) {
  for (char& c : fabric)
    if (std::string_view("#?*[]/ ,").find(c) != std::string_view::npos) c = '_';
  return fabric.empty() ? out + "/fit" : out + "/fit_" + fabric;
}

using Words = std::vector<std::string>;

Words ScaleWords(const ScaleInput& scale) {
  Words words;
  if (scale.dpi) words.push_back("--dpi");
  std::string ruler;
  for (const double number : scale.ruler)
    ruler += Format("%s%.9g", ruler.empty() ? "--ruler=" : ",", number);
  if (!ruler.empty()) words.push_back(ruler);
  return words;
}

Step PhotoStep(const ShortWayOptions& options, const std::string& folder, const Words& discs,
               const std::string& out) {
  if (!HasProgram(folder, "photo"))
    throw InputError("drape_photo",
                     "is not among the programs here, expected for a photograph; "
                     "make a silhouette of it, black cloth on white");
  const Words scale = ScaleWords(options.scale);
  Words focal;
  if (!scale.empty()) focal.push_back("--marker=none");
  if (options.focal_35mm > 0) focal.push_back(Format("--focal_35mm=%g", options.focal_35mm));
  return {"photo",
          Concatenate(options.operands, discs, scale, focal, Words{"--warp=" + options.warp},
                      Words{"--out=" + out}),
          out + "/summary.json"};
}

Step FitStep(const ShortWayOptions& options, const std::string& config, const Words& images,
             double mass, const std::string& out) {
  return {"fit",
          Concatenate(
              Words{"--config=" + config}, images,
              Words{Format("--density=%.9g", mass / kGramsPerKilogram), "--warp=" + options.warp,
                    Format("--threads=%d", options.threads), "--out=" + out}),
          out + "/summary.json"};
}

// The steps that make sense for a picture, or a table with rows, and the programs that are here.
std::vector<Step> PlanSteps(const ShortWayOptions& options, const SampleTable& table,
                            const std::string& folder, const std::string& config,
                            const std::string& out) {
  std::string images = options.operands[0];
  const bool many = !table.rows.empty();
  const Words fabrics = many ? table.Fabrics() : Words{""};
  for (const std::string& fabric : fabrics) FindMass(options, table, fabric);  // or throws
  Words discs = {Format("--support=%g", options.support)};
  if (!many || table.rows[0].diameter == 0.0)
    discs.insert(discs.begin(), Format("--specimen=%g", options.specimen));
  std::vector<Step> steps;
  Words results, of_images = Concatenate(ScaleWords(options.scale), discs);
  if (!ShowsSilhouette(options, many ? table.rows[0].file : images)) {
    const std::string photo = out + "/photo";
    steps.push_back(PhotoStep(options, folder, discs, photo));
    images = photo + (many ? "/samples.csv" : "/silhouette.png");
    of_images = {"--camera_file=" + (many ? "beside" : photo + "/camera.json")};
    if (many) results = {photo};
    if (!many) of_images = Concatenate(of_images, discs);
  } else if (many) {
    results = {out + "/metrics.json"};
    const Words files = {"--csv=" + out + "/metrics.csv", "--statistics=" + out + "/statistics.csv",
                         "--out=" + results[0]};
    steps.push_back({"metrics", Concatenate(Words{images}, of_images, files), results[0]});
  }
  for (const std::string& fabric : fabrics) {
    results.push_back(FitFolder(out, fabrics.size() > 1 ? fabric : ""));
    const Words own = {"--images=" + (fabric.empty() ? images : images + "#" + fabric)};
    steps.push_back(FitStep(options, config, Concatenate(own, of_images),
                            FindMass(options, table, fabric), results.back()));
  }
  if (!many) {
    results.push_back(out + "/predict");
    steps.push_back(
        {"predict",
         Concatenate(Words{"--fabric=" + out + "/fit", "--mesh=disc:600"}, discs,
                     Words{Format("--draws=%d", options.draws),
                           Format("--threads=%d", options.threads), "--out=" + results.back()}),
         results.back() + "/summary.json"});
  }
  const std::string page = out + "/report.html";
  if (HasProgram(folder, "report"))
    steps.push_back({"report", Concatenate(results, Words{"--out=" + page}), page});
  return steps;
}

// steps.json of an output folder: its picture and, of each step, by its result, its key and the
// SHA-256 of its result, once it has ended. A key is the command with the contents of files for
// their paths, so that picture, config and folder may move.
class StepRecord {
 public:
  // files: those of the picture, or the table or folder of samples, and the config. Throws
  // InputError where the folder has results of another picture. Samples may change.
  StepRecord(std::string out, const std::string& operand, const std::vector<std::string>& files)
      : out_(std::move(out)), path_(out_ + "/steps.json") {
    std::string all;
    for (const std::string& file : files) all += sums_[file] = Sha256(ReadWholeFile(file));
    const bool is_one = sums_.contains(operand) && !IsSampleTable(operand);
    sums_.emplace(operand, Sha256(all));  // of a folder
    CheckReplaceable(path_);
    CheckStored(path_, kStepsFormat);
    try {
      if (fs::exists(path_)) record_ = ReadStoredJson(path_, kStepsFormat);
    } catch (const InputError&) {  // damaged, or of another version: the steps are run again
    }
    const json picture = {{"path", MakeUtf8(operand)},
                          {"sha256", is_one ? sums_.at(operand) : "samples"}};
    const json earlier = record_.value("picture", picture);
    if (earlier["sha256"] != picture["sha256"])
      throw InputError(out_, "holds the results of another picture, " +
                                 earlier["path"].get<std::string>() +
                                 "; choose another folder with --out, or remove this one");
    earlier_out_ = record_.value("out", MakeUtf8(out_));
    record_.update({{"picture", picture}, {"out", MakeUtf8(out_)}});
  }

  // before: the steps whose results this one may read.
  std::string Key(const Step& step, std::span<const Step> before) const {
    std::string key = step.verb + " " + BuildCommit();
    for (const std::string& argument : step.arguments) {
      const std::size_t value = argument.starts_with("--") ? argument.find('=') + 1 : 0;
      const std::string path = argument.substr(value);
      const auto file = sums_.find(path);
      key.append(" ").append(argument, 0, value);
      key += file != sums_.end()            ? file->second
             : path.starts_with(out_ + "/") ? path.substr(out_.size())
                                            : MakeUtf8(path);
    }
    for (const Step& earlier : before) key.append(" ").append(SumOfResult(earlier));
    return key;
  }
  bool HasDone(const Step& step, const std::string& key) const {
    return record_.value(Name(step), json()) == json{{"key", key}, {"result", SumOfResult(step)}} &&
           (!step.result.ends_with("/summary.json") || HasSameInputs(step.result));
  }
  bool WasStopped(const Step& step, const std::string& key) const {
    return step.verb == "fit" &&
           fs::exists(fs::path(step.result).parent_path() / "checkpoint.json") &&
           record_.value(Name(step), json()) == json{{"key", key}, {"result", nullptr}};
  }
  void Set(const Step& step, const std::string& key, bool done) {
    record_[Name(step)] = {{"key", key}, {"result", done ? json(SumOfResult(step)) : json()}};
    WriteStoredJson(path_, kStepsFormat, record_);
  }

 private:
  // The result of a step, in the output folder.
  std::string Name(const Step& step) const { return step.result.substr(out_.size() + 1); }
  static std::string SumOfResult(const Step& step) {
    return fs::exists(step.result) ? Sha256(ReadWholeFile(step.result)) : "none";
  }

  // Returns whether all files that a step had read, by its summary, are unchanged.
  bool HasSameInputs(const std::string& summary_path) const try {
    const json summary = json::parse(ReadWholeFile(summary_path));
    for (const char* list : {"configs", "inputs"})
      for (const json& file : summary.at("provenance").at(list)) {
        const std::string path = file.at("path"), sum = file.at("sha256");
        const bool is_own = path.starts_with(earlier_out_ + "/");
        const bool is_here = std::any_of(sums_.begin(), sums_.end(),
                                         [&](const auto& here) { return here.second == sum; });
        if (!is_here &&
            sum != Sha256(ReadWholeFile(is_own ? out_ + path.substr(earlier_out_.size()) : path)))
          return false;
      }
    return true;
  } catch (const std::exception&) {  // no summary, or a file is gone
    return false;
  }

  std::string out_, path_, earlier_out_;
  std::map<std::string, std::string> sums_;  // of picture and config
  json record_ = json::object();
};

std::string CommandText(const Step& step) {
  std::vector<std::string> words = {"drapefit", step.verb};
  words.insert(words.end(), step.arguments.begin(), step.arguments.end());
  return ShellLine(words);
}

volatile std::sig_atomic_t running_child = 0, interrupted = 0;

extern "C" void PassOn(int signal) {
  interrupted = 1;
  if (running_child > 0) kill(static_cast<pid_t>(running_child), signal);
}

// Runs a program with the standard streams of this process and returns its exit code, or 128 and
// the signal that ended it. A process of its own: a step that runs out of memory leaves the others,
// and the record of its command and inputs is its own. It gets SIGINT and SIGTERM that arrive
// meanwhile, and this process waits for it to save its results. It ends with this process.
int RunAttached(const std::vector<std::string>& command) {
  if (interrupted) return kExitCancelled;
  const pid_t child = StartProgram(command, STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO);
  running_child = child;
  if (interrupted) kill(child, SIGTERM);  // the signal came before there was a process to get it
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  running_child = 0;
  if (interrupted) {
    std::signal(SIGALRM, [](int) { _exit(kExitCancelled); });
    alarm(1);  // the messages that follow may find a full pipe
    return kExitCancelled;
  }
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

bool IsOfSamples(const std::string& operand) {
  return IsSampleTable(operand) || fs::is_directory(operand);
}

void Check(const ShortWayOptions& options) {
  ParseWarp(options.warp);
  if (options.operands.size() != 1)
    throw InputError("command line",
                     Format("found %zu pictures, expected one, or a table or folder of samples",
                            options.operands.size()));
}

std::vector<Option> ShortWayOptionList(ShortWayOptions& options) {
  const auto metres = [](const char* key, double* value, const char* doc) {
    return NumberOption(key, value, 0.05, 1, doc, "m");
  };
  std::vector<Option> list = {
      Usual(NumberOption("mass", &options.mass, 0, 10000,
                         "mass of the fabric by area, as weighed; needed, but for samples with a "
                         "column mass",
                         "g/m2"),
            10, 1500),
      metres("specimen", &options.specimen, "diameter of the flat specimen"),
      metres("support", &options.support, "diameter of the support"),
      Usual(NumberOption("focal_35mm", &options.focal_35mm, 0, 2000,
                         "focal length of the photograph's lens as for a full-frame camera; 0: "
                         "from the file",
                         "mm"),
            10, 1000),
      ChoiceOption("picture", &options.picture, {"auto", "photo", "silhouette"},
                   "what the picture is; auto: a silhouette where nearly all pixels are black or "
                   "white, which is taken as seen by the camera of the published images"),
      PlainOption("warp", &options.warp, kWarpDoc),
      PathOption("fit_config", &options.fit_config,
                 "config file of drape_fit; empty: configs/programs/fit_bayes.json, a posterior "
                 "of two numbers"),
      NumberOption("draws", &options.draws, 2, 4096, "number of predicted drapes"),
      NumberOption("threads", &options.threads, 0, 4096,
                   "number of threads of each step; 0: all cores"),
      PathOption("out", &options.out, "output folder; empty: out/ and the name of the picture")};
  return Concatenate(list, FieldOptionList(options.scale));
}

// Points into `options`, which outlives it. verbs: a line for each program, for the help.
OptionTable ShortWayTable(ShortWayOptions& options, const std::string& verbs) {
  return {
      .tool = "drapefit",
      .summary =
          "runs the programs of drapefit by their verbs; given a picture of a drape, or a table "
          "of samples, runs all that leads to a report: photo, fit, predict, report",
      .example = "drapefit photo.jpg --mass=150 --specimen=0.30",
      .notes =
          "VERB [options]: runs drape_VERB, which is beside drapefit; help VERB: its help\n"
          "PICTURE: photo/, fit/, predict/ and report.html are written to the output folder. "
          "SAMPLES: a table samples.csv (drape_photo --help) or a folder of pictures: all are "
          "measured, each fabric is fitted to all of its pictures, and the report has a "
          "certificate of each and their differences. "
          "The same command again runs only what is not done; it continues a fit that was "
          "interrupted. A step that fails ends the run with its line and exit code.\n" +
          verbs,
      .options = ShortWayOptionList(options),
      .operands = &options.operands,
      .operand_names = "PICTURE|SAMPLES|VERB"};
}

// Runs the steps that are not done yet, with the standard streams of this process, and prints the
// command of each. Stops at the first step that fails and returns its exit code. `folder`: where
// the programs are (ProgramFolder). steps.json in the output folder records the picture and what is
// done: a step is done when it has ended with the same command, build and contents of its inputs.
// Throws InputError for bad options, and for a folder with results of another picture, and IoError.
int RunShortWay(const ShortWayOptions& options, const std::string& folder) {
  Check(options);
  const std::string operand = options.operands[0];
  const std::string given = !options.out.empty() ? options.out
                            : fs::is_directory(operand)
                                ? "out/" + fs::weakly_canonical(operand).filename().string()
                                : "out/" + fs::path(operand).stem().string();
  const std::string out = (given.starts_with("-") ? "./" : "") + given;  // the report takes a word
  const std::string config =
      options.fit_config.empty()
          ? FindConfigs(folder, "option 'fit_config'") + "/programs/fit_bayes.json"
          : options.fit_config;
  SampleTable table;
  std::vector<std::string> files = {operand};
  if (IsOfSamples(operand)) {
    table = ReadSamples(operand);
    files = table.Files();
    if (fs::is_regular_file(table.path)) files.push_back(table.path);
  }
  const std::vector<Step> steps = PlanSteps(options, table, folder, config, out);
  files.push_back(config);
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw IoError(out, "cannot be made: " + error.message());
  StepRecord record(out, operand, files);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    const std::string key = record.Key(step, {steps.data(), k});
    if (record.HasDone(step, key)) {
      std::printf("drapefit: done before: %s\n", CommandText(step).c_str());
      continue;
    }
    Step now = step;
    if (record.WasStopped(step, key)) now.arguments.push_back("--resume");
    record.Set(step, key, false);
    int code = RunStep(now, folder);
    if (code == kExitBadInput && now.arguments.size() > step.arguments.size())
      code = RunStep(step, folder);  // an input has changed since it was stopped
    if (code != 0) return code;
    record.Set(step, key, true);
  }
  std::printf("drapefit: see %s\n", MakePrintable(steps.back().result).c_str());
  return 0;
}

constexpr char kUsage[] =
    "usage: drapefit VERB [options]          runs drape_VERB\n"
    "       drapefit help VERB               its options\n"
    "       drapefit PICTURE --mass=G_PER_M2 from a photograph of a drape to a report: photo, "
    "fit,\n"
    "                                        predict, report (options: drapefit --help=all)\n"
    "       drapefit SAMPLES                 the same from a folder, or a table samples.csv\n";

int Fail(const std::string& message) {
  std::fprintf(stderr, "drapefit: error: %s\n", MakePrintableLine(message).c_str());
  return kExitBadInput;
}

// Returns whether the program is here. A build may leave out one with an executable of its own.
bool IsHere(const Program& program, const std::string& folder) {
  return program.main != nullptr || HasProgram(folder, program.verb);
}

int ShowVerbs(const std::string& folder) {
  std::string text =
      "drapefit " + BuildVersion() + ": stiffness of fabrics from drapes\n\n" + kUsage;
  std::string task;
  for (const Program& program : kPrograms) {
    if (!IsHere(program, folder)) continue;
    if (task != program.task) text += "\n" + (task = program.task) + ":\n";
    text += Format("  %-20s  %s\n", program.verb, program.summary);
  }
  std::fputs(text.c_str(), stdout);
  return std::fflush(stdout) == 0 ? kExitOk : Fail("stdout: cannot be written");
}

// `words`: the command line of the program after its name. A program with an executable of its own
// replaces this one.
int RunProgram(const Program& program, const std::string& folder, std::vector<std::string> words) {
  const std::string path = ProgramPath(folder, program.verb);
  words.insert(words.begin(), path);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (program.main != nullptr)
    return program.main(static_cast<int>(words.size()), arguments.data());
  execv(path.c_str(), arguments.data());
  throw InputError(path, std::string("cannot be run: ") + std::strerror(errno));
}

int FailUnknown(const std::string& verb, const std::string& folder) {
  std::vector<std::string> names = {"help"};
  for (const Program& program : kPrograms)
    if (IsHere(program, folder)) names.push_back(program.verb);
  const std::string nearest = SuggestName(verb, names);
  return Fail("command line: unknown verb '" + verb + "'" +
              (nearest.empty() ? "" : ", did you mean '" + nearest + "'?") +
              " (drapefit --help lists all)");
}

int RunPicture(int argc, char** argv, const std::string& folder) {
  ShortWayOptions options;
  std::string verbs;
  for (const Program& program : kPrograms)
    verbs += std::string(program.verb) + ": " + program.summary + "\n";
  if (ParseCommandLine(ShortWayTable(options, verbs), argc, argv) == ParseOutcome::kHelpShown)
    return kExitOk;
  struct sigaction pass_on = {};  // it ends system calls, such as the wait for a pipe
  pass_on.sa_handler = PassOn;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &pass_on, nullptr);
  try {
    const int code = RunShortWay(options, folder);
    return interrupted ? kExitCancelled : code;
  } catch (const std::exception&) {  // what a signal has cut short is no error
    if (!interrupted) throw;
    return kExitCancelled;
  }
}

// Returns whether a word names a picture rather than a verb: it has a dot or slash, or is a file.
bool IsPicture(const std::string& word) {
  return word.starts_with("-") || word.find_first_of("./") != std::string::npos ||
         std::filesystem::exists(word);
}

int Run(int argc, char** argv) {
  constexpr char kPrefix[] = "drape_";
  const std::string name = std::filesystem::path(argv[0]).filename();
  if (name.starts_with(kPrefix)) {
    const Program* program = FindProgram(name.substr(std::size(kPrefix) - 1));
    if (program != nullptr && program->main != nullptr) return program->main(argc, argv);
  }
  const std::string folder = ProgramFolder();
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool help = !words.empty() && words[0] == "help";
  if (words.empty() || words[0] == "--help" || words[0] == "-h" ||
      (help && (words.size() == 1 || words[1] == "help" || words[1].starts_with("-"))))
    return ShowVerbs(folder);
  if (help) {
    words.erase(words.begin());
    words.insert(words.begin() + 1, "--help");
  }
  const std::string verb = words[0];
  const Program* program = FindProgram(verb);
  if (program != nullptr && IsHere(*program, folder))
    return RunProgram(*program, folder, {words.begin() + 1, words.end()});
  if (!help && IsPicture(verb)) return RunPicture(argc, argv, folder);
  return FailUnknown(verb, folder);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  try {
    return drape::Run(argc, argv);
  } catch (const std::exception& error) {
    return drape::Fail(error.what());
  }
}
