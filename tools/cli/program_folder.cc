// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/program_folder.h"

#include <unistd.h>

#include <filesystem>

#include "physics/util/errors.h"

namespace drape {

namespace fs = std::filesystem;

std::string ProgramFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("/proc/self/exe", "cannot be read: " + error.message());
  return self.parent_path();
}

std::string ProgramPath(const std::string& folder, const std::string& verb) {
  return folder + "/drape_" + verb;
}

bool HasProgram(const std::string& folder, const std::string& verb) {
  return access(ProgramPath(folder, verb).c_str(), X_OK) == 0;
}

std::string FindConfigs(const std::string& folder, const std::string& what) {
  for (const char* place : {"../share/drapefit/configs", "../configs", "../../../configs"}) {
    const fs::path configs = (fs::path(folder) / place).lexically_normal();
    if (fs::exists(configs / "programs/fit_bayes.json")) return configs;
  }
  throw InputError(what, "not given, and the configs of drapefit are not beside its programs");
}

}  // namespace drape
