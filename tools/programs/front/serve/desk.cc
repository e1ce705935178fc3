// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/serve/desk.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr StoredFormat kRecordFormat = {"drapefit-desk-item", 1};
constexpr std::size_t kMostItems = 5000, kMostQueued = 500;
constexpr long kTailBytes = 2000;
constexpr int kNice = 10;  // a fit leaves the processor to the measurement of a photograph
constexpr auto kPoll = std::chrono::milliseconds(10);
constexpr auto kPatience = std::chrono::seconds(10);  // after SIGTERM

std::string MakeId(std::size_t number) { return Format("%04zu", number); }

bool IsId(const std::string& name) {
  return name.size() >= 4 && name.size() <= 6 &&
         name.find_first_not_of("0123456789") == std::string::npos;
}

bool IsPicture(const DeskItem& item) { return item.record.at("kind") == "picture"; }
bool IsIn(const DeskItem& item, const char* state) { return item.record.at("state") == state; }

// The line of an error, at the end of the log of a program.
std::string LastLine(const std::string& log) {
  std::string tail = ReadTail(log, kTailBytes);
  while (tail.ends_with('\n')) tail.pop_back();
  return tail.substr(tail.rfind('\n') + 1);
}

// Puts the photographs of a fit, by other names of the same files, and their table into its folder:
// it needs no other one.
void StagePictures(const std::string& out,
                   const std::vector<std::pair<std::string, json>>& pictures,
                   const std::string& staged) {
  for (const auto& [id, record] : pictures) {
    const fs::path from = fs::path(out) / id / record.at("file").get<std::string>();
    const std::string to = staged + "/" + id + from.extension().string();
    std::error_code error;
    fs::create_hard_link(from, to, error);
    if (error) fs::copy_file(from, to);  // a disk without them
  }
  if (!pictures.empty()) WriteFileAtomically(staged + "/samples.csv", SamplesText(pictures));
}

// A file for the output of a program; it is no link.
int OpenLog(const std::string& path) {
  const int log = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (log < 0) throw IoError(path, "cannot be written");
  return log;
}

}  // namespace

Desk::Desk(DeskOptions options) : options_(std::move(options)), folder_(options_.out) {
  setenv("DRAPEFIT_PROGRESS_SECONDS", "0.5", 1);  // of the programs
  Load();
  folder_.Publish();  // what is here is whole, and a message at an interruption says so
  runners_.emplace_back([this] { RunQueue(true); });
  for (int k = 0; k < options_.jobs; ++k) runners_.emplace_back([this] { RunQueue(false); });
}

void Desk::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (auto& [id, item] : items_) End(&item);
  }
  queued_.notify_all();
  for (std::thread& runner : std::exchange(runners_, {})) runner.join();
}

// Reads the items of the folder. What ran is queued again; what is no item is left alone.
void Desk::Load() {
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.out)) {
    const std::string id = entry.path().filename();
    if (!IsId(id) || !fs::is_directory(entry.symlink_status())) continue;
    try {
      DeskItem item{.record = ReadStoredJson(Folder(id) + "/record.json", kRecordFormat)};
      ListCommands(id, item.record, options_);  // or throws
      if (IsIn(item, "removed") && fs::remove_all(Folder(id)) > 0) continue;
      if (IsIn(item, "running")) item.record["state"] = "queued";
      item.changed = version_;
      last_ = std::max(last_, std::stoul(id));
      items_.emplace(id, std::move(item));
    } catch (const std::exception& error) {
      NoteInput(Folder(id), std::string("is left out: ") + error.what());
    }
  }
}

DeskItem& Desk::Find(const std::string& id) {
  const auto found = items_.find(id);
  if (found == items_.end() || IsIn(found->second, "removed"))
    throw InputError("item '" + PlainText(id) + "'", "is not there");
  return found->second;
}

// Stores a change.
void Desk::Touch(const std::string& id, DeskItem* item) {
  WriteStoredJson(Folder(id) + "/record.json", kRecordFormat, item->record);
  item->changed = ++version_;
  queued_.notify_all();
}

json Desk::State(long since) {
  const std::lock_guard lock(mutex_);
  json items = json::array();
  for (const auto& [id, item] : items_) {
    const bool runs = IsIn(item, "running");
    if (IsIn(item, "removed") || (item.changed <= since && !runs)) continue;
    json shown = item.record;
    shown["id"] = id;
    if (runs) shown["outlines"] = ReadOutlines(Folder(id));
    if (runs || IsIn(item, "failed")) shown["tail"] = ReadTail(Folder(id) + "/log.txt", kTailBytes);
    std::string text;
    for (const DeskCommand& command : ListCommands(id, item.record, options_))
      text.append(text.empty() ? "" : "\n").append(command.Text());
    shown["command"] = text;
    items.push_back(std::move(shown));
  }
  json removed = json::array();
  for (const auto& [version, id] : removed_)
    if (version > since) removed.push_back(id);
  return {{"version", version_}, {"items", std::move(items)}, {"removed", std::move(removed)}};
}

std::string Desk::MakeStaged() const {
  std::string folder = options_.out + "/" + TemporaryName();
  if (mkdir(folder.c_str(), 0755) != 0) throw IoError(folder, "cannot be made");
  return folder;
}

// Gives a staged folder its id. An item is there as a whole or not at all.
std::string Desk::Insert(const std::string& staged, json record) {
  if (items_.size() >= kMostItems)
    throw InputError(options_.out, "is full, expected another folder for further items");
  const auto waits = [](const auto& entry) { return IsIn(entry.second, "queued"); };
  if (std::ranges::count_if(items_, waits) >= long(kMostQueued))
    throw InputError("queue", "is full, expected to wait");
  record["state"] = "queued";
  WriteStoredJson(staged + "/record.json", kRecordFormat, record);
  std::string id;
  do id = MakeId(++last_);
  while (fs::exists(fs::symlink_status(Folder(id))));
  fs::rename(staged, Folder(id));
  items_[id] = {.record = std::move(record), .changed = ++version_};
  queued_.notify_all();
  return id;
}

std::string Desk::AddPicture(const std::string& staged, const std::string& file,
                             const std::string& name) {
  const std::lock_guard lock(mutex_);
  return Insert(
      staged,
      {{"kind", "picture"}, {"file", file}, {"name", PlainText(name)}, {"fields", json::object()}});
}

void Desk::Change(const std::string& id, const json& fields) {
  CheckFields(fields);
  const std::lock_guard lock(mutex_);
  DeskItem& item = Find(id);
  if (!IsPicture(item)) throw InputError("item '" + id + "'", "is no photograph");
  bool measure = false;
  for (const auto& [name, value] : fields.items()) {
    measure |= IsOfMeasurement(name) && item.record["fields"].value(name, "") != value;
    item.record["fields"][name] = value;
  }
  if (measure && IsIn(item, "running")) {
    item.again = true;
    End(&item);
  } else if (measure) {
    item.record["state"] = "queued";
  }
  Touch(id, &item);
}

std::string Desk::AddJob(const json& wanted) {
  if (!wanted.is_object()) throw InputError("job", "expected an object");
  const std::string kind = wanted.value("kind", "");
  const std::lock_guard lock(mutex_);
  json record = {{"kind", kind}};
  std::vector<std::pair<std::string, json>> pictures;
  if (kind == "fit") {
    std::string names;
    for (const std::string id : wanted.at("pictures")) {
      const DeskItem& item = Find(id);
      if (!IsPicture(item)) throw InputError("item '" + id + "'", "is no photograph");
      const std::string fabric = item.record.at("fields").value("fabric", "");
      if (names.find(fabric) == names.npos) names.append(names.empty() ? "" : ", ").append(fabric);
      pictures.emplace_back(id, item.record);
    }
    if (pictures.empty()) throw InputError("pictures", "is empty, expected at least one");
    record["name"] = PlainText(names);
  } else if (kind == "export" || kind == "garment") {
    const std::string of = wanted.value("of", ""), fit = wanted.value("fit", "");
    const json fits = Find(of).record.value("result", json::object()).value("fits", json::array());
    if (std::count(fits.begin(), fits.end(), fit) == 0)
      throw InputError("fit '" + PlainText(fit) + "'", "is not there");
    record.update({{"of", of}, {"fit", fit}, {"name", Find(of).record.at("name")}});
  } else {
    throw InputError("kind '" + PlainText(kind) + "'", "expected fit, export or garment");
  }
  const std::string staged = MakeStaged();
  StagePictures(options_.out, pictures, staged);
  return Insert(staged, std::move(record));
}

void Desk::End(DeskItem* item) {
  if (item->child <= 0 || item->is_ending) return;
  item->is_ending = true;
  kill(item->child, SIGTERM);
}

void Desk::Cancel(const std::string& id) {
  const std::lock_guard lock(mutex_);
  DeskItem& item = Find(id);
  if (!IsIn(item, "queued") && !IsIn(item, "running")) return;
  item.again = false;
  End(&item);
  item.record["state"] = "cancelled";
  Touch(id, &item);
}

void Desk::Retry(const std::string& id) {
  const std::lock_guard lock(mutex_);
  DeskItem& item = Find(id);
  if (!IsIn(item, "cancelled") && !IsIn(item, "failed")) return;
  if (item.child > 0) {  // it ends just now
    item.again = true;
    return;
  }
  item.record["state"] = "queued";
  Touch(id, &item);
}

void Desk::Remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  DeskItem& removed = Find(id);
  for (const auto& [other, item] : items_)
    if (item.record.value("of", "") == id && !IsIn(item, "removed"))
      throw InputError("item '" + id + "'",
                       "is used by item " + other + ", expected to remove that first");
  removed.again = false;
  End(&removed);
  removed.record["state"] = "removed";
  Touch(id, &removed);
  removed_.emplace_back(version_, id);
  if (removed.child == 0) Drop(id);
}

// Deletes a removed item: its folder as a whole.
void Desk::Drop(const std::string& id) {
  const std::string gone = options_.out + "/" + TemporaryName();
  fs::rename(Folder(id), gone);
  items_.erase(id);
  fs::remove_all(gone);
}

std::string Desk::FindFile(const std::string& id, const std::string& name) {
  {
    const std::lock_guard lock(mutex_);
    Find(id);
  }
  const std::vector<std::string> files = ListFiles(Folder(id));
  if (std::ranges::count(files, name) == 0)
    throw InputError("file '" + PlainText(name) + "'", "is not there");
  return Folder(id) + "/" + name;
}

// Measures the photographs, or runs the jobs, that are queued, until the desk ends.
void Desk::RunQueue(bool pictures) {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto next = std::ranges::find_if(items_, [&](const auto& entry) {
      return IsPicture(entry.second) == pictures && IsIn(entry.second, "queued") &&
             entry.second.child == 0;
    });
    if (next == items_.end())
      queued_.wait(lock);
    else
      RunItem(next->first, lock);
  }
}

// Runs the commands of an item in turn. The lock is free while they run.
void Desk::RunItem(const std::string& id, std::unique_lock<std::mutex>& lock) {
  DeskItem& item = items_.at(id);
  item.record["state"] = "running";
  item.record.erase("error");
  const std::string log_path = Folder(id) + "/log.txt";
  int code = kExitBadInput;
  try {
    Touch(id, &item);
    const int log = OpenLog(log_path);
    code = kExitOk;
    for (const DeskCommand& command : ListCommands(id, item.record, options_))
      if (code == kExitOk) code = RunCommand(id, command, log, lock);
    close(log);
  } catch (const std::exception& error) {
    item.record["error"] = MakePrintableLine(error.what());
  }
  if (std::exchange(item.again, false) || (stopping_ && IsIn(item, "running"))) {
    item.record["state"] = "queued";
  } else if (IsIn(item, "running")) {
    item.record["state"] = code == kExitOk ? "done" : "failed";
    item.record["result"] = code == kExitOk ? ReadResult(Folder(id), item.record) : json::object();
    if (code != kExitOk && !item.record.contains("error"))
      item.record["error"] = LastLine(log_path);
  }
  try {
    if (IsIn(item, "removed"))
      Drop(id);
    else
      Touch(id, &item);
  } catch (const std::exception& error) {  // a full disk: the page shows it
    item.record["error"] = MakePrintableLine(error.what());
    item.changed = ++version_;
  }
}

// Returns the exit code of a program, or 128 and the signal that ended it.
int Desk::RunCommand(const std::string& id, const DeskCommand& command, int log,
                     std::unique_lock<std::mutex>& lock) {
  DeskItem& item = items_.at(id);
  if (!IsIn(item, "running") || item.again || stopping_) return kExitCancelled;
  const std::string line = Format("$ %s\n", command.Text().c_str());
  if (write(log, line.data(), line.size()) < 0) throw IoError(Folder(id), "cannot be written");
  const int none = open("/dev/null", O_RDONLY | O_CLOEXEC);
  item.child = StartProgram(command.Words(), none, log, log);
  item.is_ending = false;
  close(none);
  if (!IsPicture(item)) setpriority(PRIO_PROCESS, id_t(item.child), kNice);
  int status = 0;
  auto end = std::chrono::steady_clock::time_point::max();
  while (waitpid(item.child, &status, WNOHANG) == 0) {
    const auto now = std::chrono::steady_clock::now();
    if (item.is_ending) end = std::min(end, now + kPatience);
    if (now > end) kill(item.child, SIGKILL);
    lock.unlock();
    std::this_thread::sleep_for(kPoll);
    lock.lock();
  }
  item.child = 0;
  constexpr int kSignalled = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
}

}  // namespace drape
