// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/mesh_spec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "physics/mesh/strip.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr double kMaxTriangles = 1e6;
constexpr std::string_view kDiscPrefix = "disc:", kStripPrefix = "strip:";

template <typename T>
T ParseNumber(std::string_view text, const std::string& spec, const std::string& expected) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError(spec, "found '" + std::string(text).append("', expected ") + expected);
  }
  return value;
}

DiscOptions ParseDisc(const std::string& spec, const DrapeDiscs& discs) {
  std::string_view rest = std::string_view(spec).substr(kDiscPrefix.size());
  const auto next_part = [&rest] {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    return part;
  };
  DiscOptions options{.radius = discs.specimen, .support_radius = discs.support};
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

Mesh ParseStrip(const std::string& spec) {
  const std::string expected =
      "strip:LENGTHxWIDTHxALONG in metres and edges, as in "
      "strip:0.2x0.025x80";
  std::string_view rest = std::string_view(spec).substr(kStripPrefix.size());
  const auto next_part = [&rest] {
    const std::string_view part = rest.substr(0, rest.find('x'));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    return part;
  };
  const double length = ParseNumber<double>(next_part(), spec, expected);
  const double width = ParseNumber<double>(next_part(), spec, expected);
  const int along = ParseNumber<int>(rest, spec, expected);
  const auto in_range = [](double metres) { return metres >= 1e-4 && metres < 10.0; };
  if (!in_range(length) || !in_range(width))
    throw InputError(spec,
                     "found a length or width out of range, expected 0.0001 m or more and less "
                     "than 10 m");
  const double across = along * width / length / std::sqrt(0.75);
  if (along < 1 || !(2.0 * across * along < kMaxTriangles))
    throw InputError(spec,
                     "found " + std::to_string(along) +
                         " edges along, expected at least 1 and less than a million triangles");
  return MakeStrip(length, width, along, std::max(1, static_cast<int>(std::lround(across))));
}

}  // namespace

Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options, const DrapeDiscs& discs) {
  if (spec.starts_with(kStripPrefix)) return ParseStrip(spec);
  if (spec.starts_with(kDiscPrefix)) return MakeDisc(ParseDisc(spec, discs));
  return ReadObj(spec, options);
}

}  // namespace drape
