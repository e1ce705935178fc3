// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/common_options.h"

#include <algorithm>
#include <latch>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "cuda/make_backend.h"
#include "physics/util/errors.h"
#include "tools/cli/provenance.h"

namespace drape {

Option OutOption(std::string& folder) {
  return {.key = "out",
          .value = &folder,
          .doc = "output folder, created if missing",
          .is_path = true,
          .required = true,
          .repeated = false};
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

Option PlainOption(const std::string& key, Option::Value value, const std::string& doc) {
  return {.key = key, .value = std::move(value), .doc = doc};
}

Option ChoiceOption(const std::string& key, Option::Value text,
                    const std::vector<std::string>& choices, const std::string& doc) {
  return {.key = key, .value = std::move(text), .doc = doc, .choices = choices};
}

Option NumberOption(const std::string& key, Option::Value number, double least, double most,
                    const std::string& doc, const std::string& unit) {
  return {.key = key,
          .value = std::move(number),
          .doc = doc,
          .unit = unit,
          .range = {.least = least, .most = most}};
}

Option PositiveOption(const std::string& key, Option::Value number, double most,
                      const std::string& doc, const std::string& unit) {
  Option option = NumberOption(key, std::move(number), 0, most, doc, unit);
  option.range.above_least = true;
  return option;
}

Option Usual(Option option, double least, double most) {
  option.usual_least = least;
  option.usual_most = most;
  return option;
}

Option TimeStepOption(Option::Value time_step, const std::string& doc) {
  return PositiveOption("time_step", std::move(time_step), 10, doc, "s");
}

Option PathOption(const std::string& key, Option::Value path, const std::string& doc) {
  return {.key = key, .value = std::move(path), .doc = doc, .is_path = true};
}

Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc) {
  return {.key = key, .value = std::move(mesh), .doc = doc, .is_path = true, .words = {"disc:"}};
}

std::vector<Option> ClothOptions(SceneInput& scene) {
  std::vector<Option> options = FieldOptionList(scene);
  std::erase_if(
      options, [](const Option& option) { return option.key == "start" || option.key == "scene"; });
  return options;
}

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

Option BackendOption(std::string& backend) {
  return ChoiceOption(
      "backend", &backend, {"auto", "cpu", "cuda"},
      "device of the rollouts; auto: all CUDA devices if there are any, else the CPU");
}

std::unique_ptr<Backend> MakeLoggedBackend(const std::string& name,
                                           std::shared_ptr<const ClothModel> model, int threads,
                                           const RunControl& control) {
  std::string device;
  std::unique_ptr<Backend> backend = MakeBackend(name, std::move(model), threads, &device);
  control.Log("running on " + device);
  return backend;
}

}  // namespace drape
