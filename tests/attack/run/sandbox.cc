// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/sandbox.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace drape::attack {

namespace fs = std::filesystem;

Sandbox::Sandbox(std::string folder) : folder_(std::move(folder)) {
  fs::remove_all(folder_);
  for (const char* name : {"/tmp", "/home"}) fs::create_directories(folder_ + name);
}

void Sandbox::Write(const std::string& name, const std::string& content) {
  const fs::path path = fs::path(folder_) / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

std::string Sandbox::Read(const std::string& name) const {
  std::ifstream in(folder_ + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Outcome Sandbox::Run(Request request, const Expectation& expectation) {
  request.environment.emplace("TMPDIR", folder_ + "/tmp");
  request.environment.emplace("HOME", folder_ + "/home");
  // The list of fonts that matplotlib makes at its first start serves all attacks of a class.
  request.environment.emplace("MPLCONFIGDIR", fs::path(folder_).parent_path() / "matplotlib");
  script_ += ShellLine(request) + "\n";
  const FolderState before = ReadFolder(folder_);
  outcomes_.push_back(RunProgramIn(folder_, request));
  for (const std::string& reason :
       JudgeRun(request, outcomes_.back(), expectation, before, ReadFolder(folder_)))
    reasons_.push_back(reason);
  return outcomes_.back();
}

void Sandbox::Keep() const {
  std::ofstream(folder_ + "/run.sh") << "#!/usr/bin/env bash\ncd \"$(dirname \"$0\")\"\n"
                                     << script_;
  std::ofstream reasons(folder_ + "/reasons.txt");
  for (const std::string& reason : reasons_) reasons << Visible(reason) << "\n";
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    const std::string run = folder_ + "/run_" + std::to_string(i + 1);
    std::ofstream(run + ".stdout", std::ios::binary) << outcomes_[i].out;
    std::ofstream(run + ".stderr", std::ios::binary) << outcomes_[i].err;
  }
}

}  // namespace drape::attack
