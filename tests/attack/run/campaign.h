// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "tests/attack/run/open_holes.h"
#include "tests/attack/run/sandbox.h"

namespace drape::attack {

struct CampaignOptions {
  std::string programs;  // folder of the built programs
  std::string sources;   // root of the repository
  std::string work;      // folder of the sandboxes; those of failures are kept
  uint64_t seed = 1;
  bool thorough = false;  // all of each table, and more mutants
  int jobs = 2;
};

// One attack: what is tried, in a line, and how, in a sandbox of its own.
struct Attack {
  std::string name;
  std::function<void(Sandbox&)> body;
};

// Runs attacks side by side, and counts and prints what becomes of them.
class Campaign {
 public:
  explicit Campaign(CampaignOptions options) : options_(std::move(options)) {}

  const CampaignOptions& options() const { return options_; }
  std::string Program(const std::string& name) const { return options_.programs + "/" + name; }
  // Of all or, in a short campaign, of about `few` of them, chosen by the seed.
  void Run(const std::string& class_name, std::vector<Attack> attacks, std::size_t few);
  // Counts attacks that were tried without a sandbox; each failure is reported beside them.
  void CountTried(const std::string& class_name, int tried);
  void ReportFailure(const std::string& class_name, const std::string& name,
                     const std::vector<std::string>& reasons, const std::string& reproduce);

  // Prints a table by class; true when nothing failed.
  bool PrintTable() const;

 private:
  struct Count {
    int tried = 0, failed = 0, open = 0;
    double seconds = 0.0;
  };

  void RunOne(const std::string& class_name, const Attack& attack, int number);

  const CampaignOptions options_;
  std::mutex mutex_;
  std::map<std::string, Count> counts_;
  std::map<std::string, int> open_;  // by the reason
};

}  // namespace drape::attack
