// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh_spec.h"

#include <charconv>
#include <string_view>

#include "physics/disc.h"
#include "physics/errors.h"

namespace drape {
namespace {

constexpr std::string_view kDiscPrefix = "disc:";

template <typename T>
T ParseNumber(std::string_view text, const std::string& spec, const std::string& expected) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError(spec, "found '" + std::string(text).append("', expected ") + expected);
  }
  return value;
}

DiscOptions ParseDisc(const std::string& spec) {
  std::string_view rest = std::string_view(spec).substr(kDiscPrefix.size());
  const auto next_part = [&rest] {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    return part;
  };
  DiscOptions options;
  options.target_vertices =
      ParseNumber<int>(next_part(), spec, "a whole number of vertices as in disc:1200");
  while (!rest.empty()) {
    const std::string_view part = next_part();
    const size_t equals = part.find('=');
    const std::string_view key = part.substr(0, equals);
    if (equals == std::string_view::npos || (key != "radius" && key != "support")) {
      throw InputError(spec, "found '" + std::string(part).append("', expected radius=… or ") +
                                 "support=… in metres");
    }
    const double value =
        ParseNumber<double>(part.substr(equals + 1), spec, "a number of metres as in radius=0.15");
    (key == "radius" ? options.radius : options.support_radius) = value;
  }
  return options;
}

}  // namespace

Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options) {
  if (spec.starts_with(kDiscPrefix)) return MakeDisc(ParseDisc(spec));
  return ReadObj(spec, options);
}

}  // namespace drape
