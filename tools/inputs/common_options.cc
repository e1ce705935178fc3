// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/common_options.h"

#include <algorithm>
#include <latch>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "physics/util/errors.h"
#include "tools/cli/field_options.h"

namespace drape {
namespace {

int CountCores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace

Option OutOption(std::string& folder) {
  return {.key = "out",
          .value = &folder,
          .doc = "output folder, created if missing",
          .is_path = true,
          .required = true,
          .repeated = false};
}

Option LawOption(std::string& law) {
  return {.key = "law",
          .value = &law,
          .doc = "constitutive law: how stiffness depends on strain and curvature",
          .choices = {"reference", "smooth"}};
}

Option LawOption(LawKind& law) {
  return EnumOption("law", law, "how stiffness follows from strain and curvature");
}

Option ThreadsOption(int& threads) {
  return NumberOption("threads", &threads, 0, static_cast<double>(MostThreads()),
                      "number of threads; 0: one for each core. Results do not depend on it");
}

int MostThreads() {
  constexpr int kPerCore = 4, kLeast = 64, kMost = 1024;
  return std::clamp(kPerCore * CountCores(), kLeast, kMost);
}

void RequireThreads(int threads) {
  std::latch started(1);
  std::vector<std::thread> others;
  std::string reason;
  try {
    for (int i = 1; i < threads; ++i) others.emplace_back([&] { started.wait(); });
  } catch (const std::system_error& error) {
    reason = error.code().message();
  }
  started.count_down();
  for (std::thread& other : others) other.join();
  if (!reason.empty())
    throw InputError("threads", "found " + std::to_string(threads) + ", expected fewer: thread " +
                                    std::to_string(others.size() + 2) +
                                    " cannot be started: " + reason);
}

int CountThreads(int threads) {
  const int count = threads > 0 ? threads : CountCores();
  RequireThreads(count);
  return count;
}

Option FabricOption(Option::Value fabric) {
  FabricInput input;
  Option option = FieldOptionList(input).front();
  option.value = std::move(fabric);
  return option;
}

Option TimeStepOption(double& time_step, const std::string& doc) {
  return {.key = "time_step",
          .value = &time_step,
          .doc = doc,
          .unit = "s",
          .least = 0,
          .most = 10,
          .above_least = true};
}

Option NumberOption(const std::string& key, Option::Value number, double least, double most,
                    const std::string& doc, const std::string& unit) {
  return {.key = key,
          .value = std::move(number),
          .doc = doc,
          .unit = unit,
          .least = least,
          .most = most};
}

Option PathOption(const std::string& key, Option::Value path, const std::string& doc) {
  return {.key = key, .value = std::move(path), .doc = doc, .is_path = true};
}

Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc) {
  return {.key = key, .value = std::move(mesh), .doc = doc, .is_path = true, .words = {"disc:"}};
}

std::vector<Option> ClothOptions(SceneInput& scene) {
  std::vector<Option> options = SceneOptions(scene);
  std::erase_if(
      options, [](const Option& option) { return option.key == "start" || option.key == "scene"; });
  return options;
}

std::vector<Option> SceneOptions(SceneInput& scene) { return FieldOptionList(scene); }

std::vector<Option> CameraOptions(CameraInput& camera) { return FieldOptionList(camera); }

std::vector<Option> PoolOptionRows(LearningOptions& learning) {
  return {
      PathOption(
          "pool", &learning.pool_file,
          "file of the pool of simulated drapes to learn from, the same for all fabrics; made "
          "when missing (default: pool.json in the output folder)"),
      NumberOption("pool_drapes", &learning.pool.drapes, 512, 100000, "drapes of the pool"),
      NumberOption(
          "rounds", &learning.rounds, 0, 20,
          "further rounds of drapes, each simulated near what those before show of the fabric"),
      NumberOption("round_drapes", &learning.round_drapes, 64, 100000, "drapes of a further round"),
  };
}

std::vector<Option> DatasetOptions(DatasetQuery& query) { return FieldOptionList(query); }

}  // namespace drape
