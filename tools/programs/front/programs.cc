// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/programs.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "physics/util/child_process.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr char kPrefix[] = "drape_";
constexpr std::size_t kPrefixLength = std::size(kPrefix) - 1;

bool IsProgram(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

}  // namespace

std::string ProgramFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("/proc/self/exe", "cannot be read: " + error.message());
  return self.parent_path();
}

std::string FindProgram(const std::string& folder, const std::string& verb) {
  if (verb.empty() || verb.find('/') != std::string::npos) return "";
  std::string name = kPrefix + verb;
  std::replace(name.begin(), name.end(), '-', '_');
  const fs::path path = fs::path(folder) / name;
  return IsProgram(path) ? path.string() : "";
}

std::vector<std::string> FindVerbs(const std::string& folder) {
  std::vector<std::string> verbs;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(kPrefix) && IsProgram(entry)) verbs.push_back(name.substr(kPrefixLength));
  }
  std::sort(verbs.begin(), verbs.end());
  return verbs;
}

std::vector<Program> ReadPrograms(const std::string& folder) {
  std::vector<Program> programs;
  for (const std::string& verb : FindVerbs(folder)) {
    const ProgramResult answer = RunProgram({FindProgram(folder, verb), "--help=json"}, "");
    nlohmann::json table = nlohmann::json::parse(answer.output, nullptr, false);
    if (answer.status == 0 && table.is_object() && table.contains("sections"))
      programs.push_back({verb, std::move(table)});
  }
  return programs;
}

}  // namespace drape
