// SPDX-License-Identifier: Apache-2.0
// Tables of bad files of each kind, read by the programs.
#include <filesystem>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

constexpr std::size_t kFewFiles = 45;  // of a short campaign
constexpr double kFilesSeconds = 6.0;

void TryFile(const Campaign& campaign, const FileReader& reader, const BadFile& bad,
             const std::vector<std::string>& command, Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  sandbox.Write(reader.file, bad.content);
  const std::filesystem::path folder = std::filesystem::path(reader.file).parent_path();
  for (const std::string& name : reader.beside)
    sandbox.Write((folder / std::filesystem::path(name).filename()).string(),
                  ReadText(campaign.options().work + "/valid/" + name));
  Request request = MakeRequest(campaign, command);
  request.limits.seconds = kFilesSeconds;
  sandbox.Run(request,
              {.verdict = bad.refused ? Verdict::kRefused : Verdict::kAny,
               .named = bad.named.empty() ? std::vector<std::string>() : std::vector{bad.named}});
}

}  // namespace

void AttackFiles(Campaign* campaign) {
  const auto readers = MakeFileReaders(campaign->options().work + "/valid/");
  std::vector<Attack> attacks;
  for (const FileReader& reader : readers)
    for (const BadFile& bad : reader.bad)
      for (const std::vector<std::string>& command : reader.commands)
        attacks.push_back({reader.name + " of " + command.front() + ": " + bad.name,
                           [campaign, &reader, &bad, &command](Sandbox& sandbox) {
                             TryFile(*campaign, reader, bad, command, sandbox);
                           }});
  campaign->Run("files", std::move(attacks), kFewFiles);
}

}  // namespace drape::attack
