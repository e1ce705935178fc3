// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/output_folder.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "physics/util/errors.h"

namespace drape {

namespace fs = std::filesystem;

OutputFolder::OutputFolder(std::string path)
    : path_(std::move(path)), staging_(path_ + "/.drapefit_" + std::to_string(getpid())) {
  std::error_code error;
  made_ = fs::create_directories(path_, error);
  if (!error && !fs::is_directory(path_)) error = std::make_error_code(std::errc::not_a_directory);
  if (!error) fs::create_directory(staging_, error);
  if (error) {
    throw InputError(path_, "cannot write to the output folder: " + error.message());
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (made_) fs::remove(path_, ignored);  // only when it is empty
}

void OutputFolder::Move(const std::string& name) const {
  std::error_code error;
  fs::rename(Staged(name), path_ + "/" + name, error);
  if (error) throw InputError(path_ + "/" + name, "cannot replace the file: " + error.message());
}

void OutputFolder::Publish() const {
  std::vector<std::string> names;
  for (const fs::directory_entry& file : fs::directory_iterator(staging_))
    names.push_back(file.path().filename().string());
  std::sort(names.begin(), names.end());
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name != "summary.json"; });
  for (const std::string& name : names) Move(name);
}

}  // namespace drape
