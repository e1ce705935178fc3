// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/dataset_names.h"

#include <cctype>
#include <regex>

namespace drape {
namespace {

std::optional<int> NumberIn(const std::smatch& match, int group) {
  if (!match[group].matched) return std::nullopt;
  return std::stoi(match[group].str());
}

}  // namespace

std::string PlainName(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name)
    plain += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(c));
  return plain;
}

std::optional<CaptureName> ParseCaptureName(const std::string& stem) {
  static const std::regex pattern(
      "(?:fabric_?(\\d{1,4})_)?sample_?(\\d{1,4})"
      "(?:_(?:(?:obs|observation|capture)_?)?(\\d{1,4}))?(?:_circle_\\d+)?");
  const std::string plain = PlainName(stem);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return CaptureName{NumberIn(match, 1), *NumberIn(match, 2), NumberIn(match, 3).value_or(1)};
}

std::optional<TrainingImage> ParseTrainingName(const std::string& stem) {
  static const std::regex pattern(
      "(?:.*_)?sample_?(\\d{1,4})_(upward|downward)_drape_?(\\d{1,4})"
      "(?:_(?:obs|observation)_?(\\d{1,4}))?");
  const std::string plain = PlainName(stem);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  TrainingImage image;
  image.sample = *NumberIn(match, 1);
  image.face = match[2] == "upward" ? ClothFace::kUp : ClothFace::kDown;
  image.drape = *NumberIn(match, 3);
  image.observation = NumberIn(match, 4).value_or(0);
  return image;
}

std::optional<int> ParseFabricFolder(const std::string& name) {
  static const std::regex pattern("fabric_?(\\d{1,4})");
  const std::string plain = PlainName(name);
  std::smatch match;
  if (!std::regex_match(plain, match, pattern)) return std::nullopt;
  return NumberIn(match, 1);
}

}  // namespace drape
