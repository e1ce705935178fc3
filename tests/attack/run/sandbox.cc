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
  script_ += ShellLine(request) + "\n";
  const FolderState before = ReadFolder(folder_);
  last_ = RunProgramIn(folder_, request);
  for (const std::string& reason :
       JudgeRun(request, last_, expectation, before, ReadFolder(folder_)))
    reasons_.push_back(reason);
  return last_;
}

void Sandbox::Keep() const {
  std::ofstream(folder_ + "/run.sh") << "#!/usr/bin/env bash\ncd \"$(dirname \"$0\")\"\n"
                                     << script_;
  std::ofstream reasons(folder_ + "/reasons.txt");
  for (const std::string& reason : reasons_) reasons << Visible(reason) << "\n";
  std::ofstream(folder_ + "/stdout.txt", std::ios::binary) << last_.out;
  std::ofstream(folder_ + "/stderr.txt", std::ios::binary) << last_.err;
}

}  // namespace drape::attack
