// SPDX-License-Identifier: Apache-2.0
// Damaged and misleading pictures, read by the programs that take images.
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/pictures.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

constexpr std::size_t kFewImages = 25;  // of a short campaign
constexpr double kImagesSeconds = 15.0;

void TryPicture(const Campaign& campaign, const BadPicture& bad, std::vector<std::string> command,
                Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  sandbox.Write("in/" + bad.file, bad.content);
  Request request = MakeRequest(campaign, std::move(command));
  request.limits.seconds = kImagesSeconds;
  sandbox.Run(request,
              {.verdict = bad.refused ? Verdict::kRefused : Verdict::kAny, .named = {bad.file}});
}

std::vector<std::vector<std::string>> CommandsFor(const std::string& file) {
  const std::string image = "in/" + file;
  return {{"drape_metrics", image, "--out=out/metrics.json"},
          {"drape_metrics", image, "--overlay=out/overlay.png", "--csv=out/drapes.csv"},
          QuickCommand("drape_fit", {"--images=" + image})};
}

}  // namespace

void AttackImages(Campaign* campaign) {
  std::vector<BadPicture> pictures = MakeDamagedPictures();
  for (BadPicture& picture : MakeMisleadingPictures()) pictures.push_back(std::move(picture));
  std::vector<Attack> attacks;
  for (const BadPicture& picture : pictures)
    for (const std::vector<std::string>& command : CommandsFor(picture.file))
      attacks.push_back({command.front() + ": " + picture.name, [=](Sandbox& sandbox) {
                           TryPicture(*campaign, picture, command, sandbox);
                         }});
  campaign->Run("images", std::move(attacks), kFewImages);
}

}  // namespace drape::attack
