// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tools/cli/output_folder.h"
#include "tools/programs/front/serve/desk_commands.h"

namespace drape {

// A photograph or a job. All of it is in the folder OUT/ID.
struct DeskItem {          // NOLINT(bugprone-exception-escape)
  nlohmann::json record;   // record.json
  long changed = 0;        // number of the change that was the last one
  pid_t child = 0;         // the program that runs
  bool is_ending = false;  // it got SIGTERM
  bool again = false;      // it runs once more, with other options
};

// The photographs and jobs of a folder. Photographs are measured one at a time, and beside them
// so many jobs run as the options say. Each is a program of drapefit, a process of its own. The
// folder is the only state: a desk that was killed continues where it was. For any thread; what is
// not found or not allowed throws InputError.
class Desk {
 public:
  explicit Desk(DeskOptions options);
  Desk(const Desk&) = delete;
  Desk& operator=(const Desk&) = delete;
  ~Desk() { Stop(); }
  // Ends the programs that run, and waits for them. The next desk of the folder continues them.
  void Stop();

  const DeskOptions& options() const { return options_; }

  // The items that have changed since the change of that number, with their commands and, of those
  // that run, the ends of their logs and the outlines of fits; and the ids of those that were
  // removed: {"version": number, "items": […], "removed": […]}.
  nlohmann::json State(long since);

  // Takes the folder `staged`, which holds the file of a photograph, and returns the new id.
  std::string AddPicture(const std::string& staged, const std::string& file,
                         const std::string& name);
  // Sets fields of a photograph (kFieldColumns) and measures it again where they matter for it.
  void Change(const std::string& id, const nlohmann::json& fields);
  // Queues a job {"kind": "fit", "pictures": [ids]}, or {"kind": "export" or "garment", "of": id,
  // "fit": name of a fit of that job}, and returns its id.
  std::string AddJob(const nlohmann::json& wanted);
  void Cancel(const std::string& id);
  void Retry(const std::string& id);
  // Cancels an item, and deletes its folder once its program has ended. A fit stays while exports
  // and previews of it are there.
  void Remove(const std::string& id);

  // The path of a file of an item, of a name that ListFiles gives.
  std::string FindFile(const std::string& id, const std::string& name);

  // A new folder for an upload, in which the file is written.
  std::string MakeStaged() const;

 private:
  DeskItem& Find(const std::string& id);
  std::string Folder(const std::string& id) const { return options_.out + "/" + id; }
  void Touch(const std::string& id, DeskItem* item);
  std::string Insert(const std::string& staged, nlohmann::json record);
  void Load();
  void RunQueue(bool pictures);
  void RunItem(const std::string& id, std::unique_lock<std::mutex>& lock);
  int RunCommand(const std::string& id, const DeskCommand& command, int log,
                 std::unique_lock<std::mutex>& lock);
  void End(DeskItem* item);
  void Drop(const std::string& id);

  const DeskOptions options_;
  const OutputFolder folder_;  // its lock
  std::mutex mutex_;           // of all that follows
  std::condition_variable queued_;
  std::map<std::string, DeskItem> items_;
  std::vector<std::pair<long, std::string>> removed_;  // the numbers of the changes, and the ids
  std::size_t last_ = 0;                               // number of the last item
  long version_ = 1;
  bool stopping_ = false;
  std::vector<std::thread> runners_;
};

}  // namespace drape
