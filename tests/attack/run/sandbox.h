// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/attack/run/judge.h"
#include "tests/attack/run/process.h"

namespace drape::attack {

// A folder of one attack: the programs run in it, with "out" for their results, "tmp" as TMPDIR and
// "home" as HOME, and every run is judged.
class Sandbox {
 public:
  explicit Sandbox(std::string folder);

  const std::string& folder() const { return folder_; }
  // Writes a file with the folders above it.
  void Write(const std::string& name, const std::string& content);
  std::string Read(const std::string& name) const;

  // Runs and judges. The first word of a command is the name of a program without folder where it
  // lies in `programs`, else a path.
  Outcome Run(Request request, const Expectation& expectation = {});
  // Says that a rule of the attack's own was broken.
  void Fail(const std::string& reason) { reasons_.push_back(reason); }

  const std::vector<std::string>& reasons() const { return reasons_; }
  // Keeps what reproduces the runs: run.sh, reasons.txt and the streams of each.
  void Keep() const;

 private:
  std::string folder_, script_;
  std::vector<Outcome> outcomes_;
  std::vector<std::string> reasons_;
};

}  // namespace drape::attack
