// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/runner/study.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/sha256.h"
#include "physics/util/stored/build.h"
#include "physics/util/stored/stored_json.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr StoredFormat kStudyCellFormat = {"drapefit-cell", 3};

struct Share {
  std::size_t index = 0, count = 1;

  bool Has(std::size_t cell) const { return cell % count == index; }
};

std::optional<std::size_t> ParseShareNumber(const char* begin, const char* end) {
  constexpr std::size_t kMost = 1'000'000;
  std::size_t count = 0;
  const auto [parsed, error] = std::from_chars(begin, end, count);
  if (error != std::errc() || parsed != end || count > kMost) return std::nullopt;
  return count;
}

Share ParseShare(const std::string& share) {
  if (share.empty()) return {};
  const char* const begin = share.data();
  const char* const end = begin + share.size();
  const std::size_t slash = share.find('/');
  if (slash != std::string::npos) {
    const auto index = ParseShareNumber(begin, begin + slash);
    const auto count = ParseShareNumber(begin + slash + 1, end);
    if (index && count && *index < *count) return {*index, *count};
  }
  throw InputError("option 'share'",
                   "found '" + share + "', expected i/n with whole numbers 0 ≤ i < n, such as 0/8");
}

json Sums(const std::vector<ReadRecord::File>& files) {
  json sums = json::array();
  for (const ReadRecord::File& file : files) sums.push_back(file.sha256);
  return sums;
}

json MakeKey(const Study& study, const StudyCell& cell) {
  return {{"drapefit", BuildVersion()}, {"study", study.name},
          {"settings", study.settings}, {"input", cell.input},
          {"files", Sums(study.files)}, {"cell_files", Sums(cell.files)}};
}

std::string Id(const json& key) { return Sha256(key.dump()).substr(0, 32); }

bool HasFailed(const json& result) { return result.is_object() && result.contains("failure"); }

// Refuses what no run finds: a time, a length, an error or a count below 0. name: of the member
// that holds the value.
void CheckResult(const JsonInput& input, const std::string& name = "") {
  constexpr std::string_view kNotNegative[] = {
      "_s",    "seconds",  "_m",       "_mm",         "_px",       "mse",   "iou",  "residual",
      "steps", "vertices", "rollouts", "evaluations", "jacobians", "spent", "folds"};
  const json& value = input.value();
  if (value.is_number() && std::any_of(std::begin(kNotNegative), std::end(kNotNegative),
                                       [&](std::string_view end) { return name.ends_with(end); }))
    input.NotNegative();
  for (int i = 0; value.is_array() && i < input.Size(); ++i) CheckResult(input.At(i), name);
  if (value.is_object())
    for (const auto& [key, unused] : value.items()) CheckResult(input.At(key), key);
}

// One call of RunStudy.
class StudyRun {
 public:
  StudyRun(const Study& study, const StudyOptions& options, const RunControl& control)
      : study_(study),
        options_(options),
        control_(control),
        share_(ParseShare(options.share)),
        folder_(options.out + "/cells") {}
  StudyRun(const StudyRun&) = delete;
  StudyRun& operator=(const StudyRun&) = delete;
  ~StudyRun() {
    std::error_code ignored;
    fs::remove(folder_, ignored);  // only when it is empty
  }

  StudyResult Run() {
    if (options_.list) return List();
    CheckNames();
    MakeFolder();
    TakeOver();
    if (options_.processes)
      idle_bytes_ = RunInChild([] { return std::string(); }, nullptr).peak_bytes;
    RunInThreads(static_cast<int>(todo_.size()), options_.processes ? 1 : options_.threads,
                 control_.cancel, [&](int i) { RunAndStore(todo_[i]); });
    result_.cancelled = control_.cancelled();
    result_.complete = options_.share.empty() && !result_.cancelled;
    if (!options_.share.empty()) result_.text = ShareText();
    return std::move(result_);
  }

 private:
  StudyResult List() {
    for (std::size_t k = 0; k < study_.cells.size(); ++k)
      if (share_.Has(k)) result_.text += study_.cells[k].name + "\n";
    return std::move(result_);
  }

  void CheckNames() const {
    std::set<std::string> names;
    for (const StudyCell& cell : study_.cells)
      if (!names.insert(cell.name).second)
        throw InputError("cell '" + cell.name + "'",
                         "is there twice, expected files of different names");
  }

  void MakeFolder() const {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw IoError(folder_, "cannot make the folder: " + error.message());
  }

  std::string Path(const json& key) const { return folder_ + "/" + Id(key) + ".json"; }

  std::optional<json> Read(const json& key) const {
    const std::string path = Path(key);
    if (!fs::exists(path)) return std::nullopt;
    json stored = ReadStoredJson(path, kStudyCellFormat);
    const JsonInput input(stored, path);
    if (input.At("key").value() != key) input.At("key").Fail("that of the cell of this name");
    const JsonInput result = input.At("result");
    if (result.value().empty()) result.Fail("what the run has found");
    CheckResult(result);
    const std::vector<std::string>& words = study_.outcomes;
    if (!words.empty() && result.Has("outcome") &&
        std::find(words.begin(), words.end(), result.At("outcome").String()) == words.end())
      result.At("outcome").Fail("a word of this study, such as " + words.front());
    return result.value();
  }

  void TakeOver() {
    result_.results.resize(study_.cells.size());
    for (std::size_t k = 0; k < study_.cells.size(); ++k) {
      if (!share_.Has(k)) continue;
      std::optional<json> found = Read(MakeKey(study_, study_.cells[k]));
      if (found && (!study_.is_whole || study_.is_whole(k, *found))) {
        result_.results[k] = std::move(found);
        continue;
      }
      todo_.push_back(k);
      all_work_ += study_.cells[k].work;
    }
  }

  // Refuses a file that the key does not know, such as one that was changed meanwhile. Further
  // files below the folder of the study are its own results.
  void CheckReads(const StudyCell& cell, const std::vector<ReadRecord::File>& files) const {
    const auto knows = [&](const auto& is_same) {
      return std::any_of(study_.files.begin(), study_.files.end(), is_same) ||
             std::any_of(cell.files.begin(), cell.files.end(), is_same);
    };
    for (const ReadRecord::File& file : files) {
      const bool is_own =
          file.path.starts_with(options_.out + "/") &&
          !knows([&](const ReadRecord::File& known) { return known.path == file.path; });
      if (!is_own &&
          !knows([&](const ReadRecord::File& known) { return known.sha256 == file.sha256; }))
        throw InputError(file.path, "was read by '" + cell.name +
                                        "' and is not as it was when the study began, expected the "
                                        "input files to stay as they are");
    }
  }

  std::optional<json> RunCell(std::size_t k) const {
    const ReadRecord record;
    std::optional<json> result = study_.run(k, {.cancel = control_.cancel});
    CheckReads(study_.cells[k], record.files());
    if (result && HasFailed(*result))  // of what the cell says, not of a file that is gone
      for (const ReadRecord::File& file : study_.cells[k].files)
        if (!fs::exists(file.path)) throw IoError(file.path, "no such file any more");
    return result;
  }

  std::optional<json> RunInProcess(std::size_t k) const {
    const ChildResult child = RunInChild(
        [&] {
          const std::optional<json> result = RunCell(k);
          return result ? result->dump() : std::string();
        },
        control_.cancel);
    if (child.cancelled || child.output.empty()) return std::nullopt;
    json result = json::parse(child.output);
    result["peak_mb"] = (child.peak_bytes - idle_bytes_) / kBytesPerMegabyte;
    return result;
  }

  void RunAndStore(std::size_t k) {
    const StudyCell& cell = study_.cells[k];
    if (study_.prepare && !study_.prepare(k, {.cancel = control_.cancel})) return;
    std::optional<json> result = options_.processes ? RunInProcess(k) : RunCell(k);
    if (!result || control_.cancelled()) return;
    const json key = MakeKey(study_, cell);
    WriteStoredJson(Path(key), kStudyCellFormat, {{"key", key}, {"result", *result}});
    const std::scoped_lock lock(mutex_);
    result_.results[k] = std::move(result);
    done_work_ += cell.work;
    control_.Report(done_work_ / all_work_, cell.name);
  }

  std::string ShareText() const {
    std::size_t mine = 0, done = 0, failed = 0;
    for (std::size_t k = 0; k < study_.cells.size(); ++k) {
      const std::optional<json>& result = result_.results[k];
      mine += share_.Has(k);
      done += result.has_value();
      failed += result && HasFailed(*result);
    }
    return "share " + options_.share + ": " + std::to_string(done) + " of " + std::to_string(mine) +
           " cells are complete" +
           (failed > 0 ? ", of which " + std::to_string(failed) + " failed" : "") +
           "; the same command without --share gathers all shares\n";
  }

  const Study& study_;
  const StudyOptions& options_;
  const RunControl& control_;
  const Share share_;
  const std::string folder_;
  double idle_bytes_ = 0.0;
  std::vector<std::size_t> todo_;
  std::mutex mutex_;
  double all_work_ = 0.0, done_work_ = 0.0;
  StudyResult result_;
};

}  // namespace

StudyCell CheckedCell(std::string name, json input, const std::function<void()>& check) {
  const ReadRecord record;
  check();
  return {.name = std::move(name), .input = std::move(input), .files = record.files()};
}

std::string CellId(const Study& study, std::size_t cell) {
  return Id(MakeKey(study, study.cells[cell]));
}

std::string NameWithoutFolder(const std::string& path) { return path.substr(path.rfind('/') + 1); }

std::string NameInKey(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path.substr(0, path.rfind('#')), ignored) ? "file" : path;
}

void CheckShare(const StudyOptions& options) { ParseShare(options.share); }

StudyResult RunStudy(const Study& study, const StudyOptions& options, const RunControl& control) {
  return StudyRun(study, options, control).Run();
}

}  // namespace drape
