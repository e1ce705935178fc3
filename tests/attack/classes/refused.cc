// SPDX-License-Identifier: Apache-2.0
// Contents that each reader must refuse: JSON nested too deep, impossible values of stored files
// with the right checksum, and pipes, devices and links in place of a file.
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/judged_reading.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tests/attack/run/forked.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kDepth = 150'000;
constexpr double kReadingSeconds = 10.0, kProgramSeconds = 6.0;
constexpr std::size_t kFewPrograms = 12;  // of a short campaign

// Something in the place of a good file.
struct Refused {
  std::string what;
  std::function<void(const std::string& path)> put;
};

Refused Text(const std::string& what, const std::string& text) {
  return {what, [=](const std::string& path) { test::WriteQuickly(path, text); }};
}

std::vector<Refused> NoFiles() {
  const auto link = [](const std::string& to) {
    return [=](const std::string& path) { fs::create_symlink(to, path); };
  };
  return {{"a pipe", [](const std::string& path) { mkfifo(path.c_str(), 0600); }},
          {"a link to a pipe",
           [](const std::string& path) {
             mkfifo((path + ".pipe").c_str(), 0600);
             fs::create_symlink(path + ".pipe", path);
           }},
          {"a link to a device", link("/dev/zero")},
          {"a link to a folder", link("/")}};
}

// Nests the whole, and each member of an object.
std::vector<Refused> NestedJson(const Reader& reader) {
  const std::string deep = std::string(kDepth, '[') + std::string(kDepth, ']'), mark = "@deep@";
  std::vector<Refused> all = {Text("nested lists", deep)};
  const json document = json::parse(reader.content, nullptr, false, true);
  if (!document.is_object()) return all;
  for (const auto& [key, unused] : document.items()) {
    json marked = document;
    marked[key] = mark;
    std::string text = reader.seal ? reader.seal(marked) : marked.dump();
    all.push_back(
        Text("nested " + key, text.replace(text.find('"' + mark), mark.size() + 2, deep)));
  }
  return all;
}

std::vector<Refused> ImpossibleValues(const Reader& reader) {
  std::vector<Refused> all;
  for (const auto& [pointer, value] : reader.impossible) {
    json changed = json::parse(reader.content, nullptr, true, true);
    changed[json::json_pointer(pointer)] = json::parse(value);
    all.push_back(
        Text(pointer + " = " + value, reader.seal ? reader.seal(changed) : changed.dump()));
  }
  return all;
}

void RefuseInReader(const Reader& reader, Campaign* campaign) {
  std::vector<Refused> all = NoFiles();
  for (Refused& one : ImpossibleValues(reader)) all.push_back(std::move(one));
  if (reader.content.starts_with("{"))
    for (Refused& one : NestedJson(reader)) all.push_back(std::move(one));
  std::string folder = campaign->options().work + "/refused/" + reader.name;
  const std::string path = folder + "/" + reader.file;
  const auto failures = TryForked(static_cast<int>(all.size()), kReadingSeconds, [&](int i) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    all[i].put(path);
    bool refused = false;
    std::vector<std::string> reasons = ReadDamaged(reader, path, &refused);
    if (!refused && reasons.empty()) reasons.push_back("took a bad input");
    return reasons;
  });
  campaign->CountTried("refused", static_cast<int>(all.size()));
  for (const ForkedFailure& failure : failures)
    campaign->ReportFailure("refused", reader.name + ": " + all[failure.index].what,
                            failure.reasons, "no command: attack --classes=refused");
  fs::remove_all(folder);
}

void TryProgram(const Campaign& campaign, const FileReader& reader, const Refused& refused,
                const std::vector<std::string>& command, Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  sandbox.Write(reader.file, "");
  const std::string path = sandbox.folder() + "/" + reader.file;
  fs::remove(path);
  refused.put(path);
  Request request = MakeRequest(campaign, command);
  request.limits.seconds = kProgramSeconds;
  sandbox.Run(request, {.verdict = Verdict::kRefused});
}

}  // namespace

void AttackRefused(Campaign* campaign) {
  for (const Reader& reader : MakeAllReaders(campaign->options())) RefuseInReader(reader, campaign);
  const auto readers = MakeFileReaders(campaign->options().work + "/valid/");
  std::vector<Attack> attacks;
  for (const FileReader& reader : readers)
    for (const Refused& refused : NoFiles())
      for (const std::vector<std::string>& command : reader.commands)
        attacks.push_back({reader.name + " of " + command.front() + ": " + refused.what,
                           [=, &reader](Sandbox& sandbox) {
                             TryProgram(*campaign, reader, refused, command, sandbox);
                           }});
  campaign->Run("refused", std::move(attacks), kFewPrograms);
}

}  // namespace drape::attack
