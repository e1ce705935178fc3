// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/campaign.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <random>
#include <thread>

namespace drape::attack {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The first `few` after a shuffle that is the same everywhere.
void Choose(std::vector<Attack>* attacks, std::size_t few, uint64_t seed) {
  if (attacks->size() <= few) return;
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < few; ++i)
    std::swap((*attacks)[i], (*attacks)[i + random() % (attacks->size() - i)]);
  attacks->resize(few);
}

}  // namespace

void Campaign::Run(const std::string& class_name, std::vector<Attack> attacks, std::size_t few) {
  if (!options_.thorough) Choose(&attacks, few, options_.seed);
  const Clock::time_point start = Clock::now();
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i; (i = next++) < attacks.size();)
      RunOne(class_name, attacks[i], static_cast<int>(i));
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < options_.jobs; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  counts_[class_name].seconds += SecondsSince(start);
}

void Campaign::RunOne(const std::string& class_name, const Attack& attack, int number) {
  Sandbox sandbox(options_.work + "/" + class_name + "/" + std::to_string(number));
  try {
    attack.body(sandbox);
  } catch (const std::exception& error) {
    sandbox.Fail(std::string("the attack itself failed: ") + error.what());
  }
  CountTried(class_name, 1);
  if (sandbox.reasons().empty()) {
    std::error_code ignored;
    fs::remove_all(sandbox.folder(), ignored);
    return;
  }
  sandbox.Keep();
  ReportFailure(class_name, attack.name, sandbox.reasons(), sandbox.folder() + "/run.sh");
}

void Campaign::CountTried(const std::string& class_name, int tried) {
  const std::lock_guard lock(mutex_);
  counts_[class_name].tried += tried;
}

void Campaign::ReportFailure(const std::string& class_name, const std::string& name,
                             const std::vector<std::string>& reasons,
                             const std::string& reproduce) {
  const OpenHole* open = FindOpenHole(class_name + ": " + name, reasons);
  const std::lock_guard lock(mutex_);
  ++(open != nullptr ? counts_[class_name].open : counts_[class_name].failed);
  if (open != nullptr) ++open_[open->hole];
  std::printf("%s %s: %s\n", open != nullptr ? "open  " : "FAILED", class_name.c_str(),
              Visible(name).c_str());
  for (const std::string& reason : reasons) std::printf("       %s\n", Visible(reason).c_str());
  std::printf("       %s\n", Visible(reproduce).c_str());
  std::fflush(stdout);
}

bool Campaign::PrintTable() const {
  bool passed = true;
  std::printf("\n%-10s %8s %8s %8s %8s %8s\n", "class", "tried", "ok", "failed", "open", "seconds");
  for (const auto& [name, count] : counts_) {
    std::printf("%-10s %8d %8d %8d %8d %8.0f\n", name.c_str(), count.tried,
                count.tried - count.failed - count.open, count.failed, count.open, count.seconds);
    passed = passed && count.failed == 0 && count.tried > 0;
  }
  for (const auto& [hole, count] : open_) std::printf("open: %s (%d)\n", hole.c_str(), count);
  return passed;
}

}  // namespace drape::attack
