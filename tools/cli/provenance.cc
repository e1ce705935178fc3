// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/provenance.h"

#include <ceres/version.h>
#include <cholmod.h>
#include <gnu/libc-version.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "cuda/make_backend.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/sha256.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr int kMostBytes = 1 << 30;  // of a file that ReadWholeFile reads

bool IsSha256(const std::string& text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isdigit(c) != 0 || (c >= 'a' && c <= 'f');
         });
}

InputFile ReadInputFile(const JsonInput& input) {
  input.ExpectKeys({"path", "bytes", "sha256"});
  InputFile file{input.At("path").String(),
                 static_cast<std::uintmax_t>(input.At("bytes").IntegerWithin(0, kMostBytes)),
                 input.At("sha256").String()};
  if (!IsSha256(file.sha256)) input.At("sha256").Fail("64 hexadecimal digits");
  return file;
}

// "3,210 bytes with SHA-256 12ab34cd56ef…".
std::string ContentText(const InputFile& file) {
  constexpr std::size_t kDigits = 12;
  return std::to_string(file.bytes) + " bytes with SHA-256 " + file.sha256.substr(0, kDigits) + "…";
}

struct Record {
  std::mutex mutex;
  pid_t process = 0;  // its children record nothing
  std::string program, started;
  Clock::time_point start;
  ordered_json command, working_directory;
  // Once they are read:
  ordered_json options, operands, given, threads;
  std::string out;                  // the option of that name
  bool may_use_gpu = false;         // the option `backend` does not say cpu
  bool is_repetition = false;       // the config is a summary
  std::vector<std::string> places;  // paths of inputs, as options and operands name them
  std::set<InputFile> configs, inputs;
  std::shared_ptr<const StoredRun> repeated;
};

// Never destroyed: threads may read until the process ends.
Record& TheRecord() {
  static Record* const record = new Record;
  return *record;
}

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc = {};
  gmtime_r(&now, &utc);
  char text[32] = {};
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string Dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

// Lists everything that may change the last bit of a number.
ordered_json BuildJson() {
#if defined(__AVX512F__)
  constexpr char kInstructions[] = "AVX-512";
#elif defined(__AVX2__)
  constexpr char kInstructions[] = "AVX2";
#else
  constexpr char kInstructions[] = "baseline";
#endif
  return {{"drapefit", BuildVersion()},
          {"commit", BuildCommit()},
          {"compiler", __VERSION__},
          {"build_type", BuildType()},
          {"instructions", kInstructions},
          {"ceres", CERES_VERSION_STRING},
          {"cholmod", Dotted(CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION)},
          {"eigen", Dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"glibc", gnu_get_libc_version()}};
}

std::string Canonical(const std::string& path) {
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(fs::absolute(path, error), error);
  std::string text = (error ? fs::path(path) : canonical).lexically_normal().string();
  if (text.size() > 1 && text.ends_with('/')) text.pop_back();
  return text;
}

bool IsInside(const std::string& path, const std::string& folder) {
  return path == folder || path.starts_with(folder == "/" ? folder : folder + "/");
}

// Returns whether a file is an input. Files in the output folder come from the run itself or from
// one that it continues, unless an option names the file, its folder, or a file beside it.
bool IsInput(const Record& record, const std::string& path) {
  if (record.out.empty()) return true;
  const std::string file = Canonical(path), out = Canonical(record.out);
  if (!IsInside(file, out)) return true;
  const std::string parent = fs::path(file).parent_path().string();
  for (const std::string& named : record.places) {
    const std::string place = Canonical(named);
    std::error_code ignored;
    if (!fs::is_directory(place, ignored) ? parent == fs::path(place).parent_path()
        : IsInside(out, place)            ? parent == place
                                          : IsInside(file, place))
      return true;
  }
  return false;
}

void RecordRead(const std::string& path, std::string_view content) {
  Record& record = TheRecord();
  if (getpid() != record.process) return;
  const bool is_config = record.options.is_null();
  if (!is_config && !IsInput(record, path)) return;
  InputFile file = DescribeInput(path, content);
  const std::lock_guard guard(record.mutex);
  (is_config ? record.configs : record.inputs).insert(std::move(file));
}

ordered_json FilesJson(const std::set<InputFile>& files) {
  ordered_json list = ordered_json::array();
  for (const InputFile& file : files)
    list.push_back({{"path", file.path}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return list;
}

void AddPlaces(const Option& option, std::vector<std::string>* places) {
  static const std::set<std::string> kOutputs = {"out", "csv", "overlay", "save_split",
                                                 "statistics"};
  if (!option.is_path || kOutputs.contains(option.key)) return;
  const auto add = [&](std::string text) {
    std::error_code ignored;
    if (!fs::exists(text, ignored)) text = text.substr(0, text.rfind('#'));  // FILE#name
    if (!text.empty()) places->push_back(std::move(text));
  };
  if (const auto* text = std::get_if<std::string*>(&option.value)) add(**text);
  if (const auto* texts = std::get_if<std::vector<std::string>*>(&option.value))
    for (const std::string& text : **texts) add(text);
}

// Records an option and what the common ones mean: output folder, backend and threads.
void RecordOption(const Option& option, Record* record) {
  record->options[option.key] = ValueJson(option);
  AddPlaces(option, &record->places);
  const std::string text = ValueText(option);
  if (option.key == "out") record->out = text;
  if (option.key == "backend") record->may_use_gpu = text != "cpu";
  if (const auto* count = std::get_if<int*>(&option.value); count && option.key == "threads")
    record->threads = **count > 0 ? **count : CountCores();
}

// Checks the inputs of a run before it is repeated, and notes another build.
void CheckRepeated(const OptionTable& table, const StoredRun& run) {
  CheckInputs(run);
  if (run.build.empty() || run.build == nlohmann::json(BuildJson()).dump()) return;
  std::fprintf(
      stderr, "%s: note: %s\n", table.tool.c_str(),
      MakePrintableLine(run.summary + " is of another build or other libraries: results may differ")
          .c_str());
}

// Throws InputError where a repetition has read what its run had not, such as a new file of a
// folder.
void CheckRead(const Record& record) {
  if (!record.repeated) return;
  const std::vector<InputFile>& expected = record.repeated->inputs;
  for (const InputFile& file : record.inputs)
    if (std::find(expected.begin(), expected.end(), file) == expected.end())
      throw InputError(file.path, "was read, and the run of " + record.repeated->summary +
                                      " did not read it: expected the same files");
}

ordered_json CommandJson(const Record& record) {
  if (record.program.empty()) return ordered_json::object();  // a library's own use
  return {{"program", record.program},
          {"command", record.command},
          {"working_directory", record.working_directory}};
}

void AddMachineAndBuild(const Record& record, ordered_json* json) {
  (*json)["host"] = MakeUtf8(HostName());
  (*json)["processor"] = MakeUtf8(ProcessorName());
  (*json)["cores"] = CountCores();
  if (!record.threads.is_null()) (*json)["threads"] = record.threads;
  if (const std::string gpu = record.may_use_gpu ? UsableGpu() : ""; !gpu.empty())
    (*json)["gpu"] = gpu;
  (*json)["build"] = BuildJson();
  if (!record.program.empty()) (*json)["started"] = record.started;
}

}  // namespace

int CountCores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

InputFile DescribeInput(const std::string& path, std::string_view content) {
  return {MakeUtf8(path), content.size(), Sha256(content)};
}

std::string MakeUtf8(std::string_view text) {
  std::string valid;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    if (length == 0)
      valid += Format("\\x%02x", static_cast<unsigned char>(text[at]));
    else
      valid += text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return valid;
}

StoredRun ReadStoredRun(const JsonInput& provenance, const std::string& summary,
                        const std::string& tool) {
  const std::string program = provenance.At("program").String();
  if (program != tool) provenance.At("program").Fail("\"" + tool + "\", whose run is repeated");
  if (!provenance.Has("options"))
    throw InputError(summary, "is of a part of a run of " + program +
                                  ", expected the summary of the whole run, which has its options");
  StoredRun run;
  run.summary = summary;
  run.working_directory = provenance.At("working_directory").String();
  if (provenance.Has("build")) run.build = provenance.At("build").value().dump();
  const JsonInput inputs = provenance.At("inputs").ExpectArray();
  for (int i = 0; i < inputs.Size(); ++i) run.inputs.push_back(ReadInputFile(inputs.At(i)));
  return run;
}

void CheckInputs(const StoredRun& run) {
  for (const InputFile& expected : run.inputs) {
    const std::string origin = "is an input of the run of " + run.summary + " in " +
                               run.working_directory + ", " + ContentText(expected);
    std::string content;
    try {
      content = ReadOwnFile(expected.path);
    } catch (const std::exception& error) {
      throw InputError(error.what(), "it " + origin);
    }
    const InputFile found = DescribeInput(expected.path, content);
    if (found != expected)
      throw InputError(expected.path, origin + ", and has changed: found " + ContentText(found));
  }
}

void RecordCommand(int argc, char** argv) {
  Record& record = TheRecord();
  record.process = getpid();
  record.started = Now();
  record.start = Clock::now();
  record.command = ordered_json::array();
  for (int i = 0; i < argc; ++i) record.command.push_back(MakeUtf8(argv[i]));
  std::error_code error;
  record.working_directory = MakeUtf8(fs::current_path(error).string());
  ObserveReads(RecordRead);
}

void RecordRunOptions(const OptionTable& table, std::shared_ptr<const StoredRun> repeated) {
  Record& record = TheRecord();
  record.program = table.tool;
  record.is_repetition = repeated != nullptr;
  ObserveReads(nullptr);
  if (repeated && !repeated->is_changed) {
    CheckRepeated(table, *repeated);
    record.repeated = std::move(repeated);
  }
  if (table.operands != nullptr) {
    record.operands = *table.operands;
    record.places = *table.operands;
  }
  if (table.given != nullptr) record.given = *table.given;
  record.options = ordered_json::object();
  for (const Option& option : table.options) RecordOption(option, &record);
  ObserveReads(RecordRead);
}

void CheckKeeps(const std::string& path) {
  Record& record = TheRecord();
  const std::lock_guard guard(record.mutex);
  const std::string target = MakeUtf8(Canonical(path));
  const auto is_place = [&](const std::string& file) {
    return MakeUtf8(Canonical(file)) == target;
  };
  const auto is_file = [&](const InputFile& file) { return is_place(file.path); };
  if (std::any_of(record.places.begin(), record.places.end(), is_place) ||
      std::any_of(record.inputs.begin(), record.inputs.end(), is_file) ||
      (!record.is_repetition && std::any_of(record.configs.begin(), record.configs.end(), is_file)))
    throw InputError(path, "is an input of this run, expected another place for its results");
  std::error_code ignored;
  if (!path.ends_with("/summary.json") || !fs::is_regular_file(path, ignored)) return;
  const std::string begin = "\"program\": \"drape_", text = ReadOwnFile(path);
  const std::size_t at = text.rfind(begin);
  if (!record.program.empty() && at != std::string::npos &&
      !text.substr(at).starts_with("\"program\": \"" + record.program + '"'))
    throw InputError(path, "is of another program, expected another folder for the results of " +
                               record.program);
}

void RecordChoice(const std::string& key, const nlohmann::json& chosen) {
  TheRecord().options[key] = chosen;
}

ordered_json MakeProvenance() {
  Record& record = TheRecord();
  const std::lock_guard guard(record.mutex);
  CheckRead(record);
  ordered_json json = CommandJson(record);
  if (!record.program.empty()) {
    json["options"] = record.options;
    if (!record.operands.is_null()) json["operands"] = record.operands;
    if (!record.given.is_null()) json["given"] = record.given;
    json["configs"] = FilesJson(record.configs);
    json["inputs"] = FilesJson(record.inputs);
  }
  AddMachineAndBuild(record, &json);
  if (!record.program.empty())
    json["seconds"] = std::chrono::duration<double>(Clock::now() - record.start).count();
  return json;
}

ordered_json MakePartProvenance() {
  const Record& record = TheRecord();
  ordered_json json = CommandJson(record);
  AddMachineAndBuild(record, &json);
  return json;
}

void WriteWithProvenance(const std::string& path, ordered_json summary) {
  summary["provenance"] = MakeProvenance();
  WriteFileAtomically(path, summary.dump(2) + "\n");
}

}  // namespace drape
