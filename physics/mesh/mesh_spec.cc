// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/mesh_spec.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "physics/util/errors.h"

namespace drape {
namespace {

// Adds the triangles between an even row (n + 1 vertices from `even` on) and an odd row (n + 2
// vertices from `odd` on).
void AddRow(std::vector<std::array<int, 3>>& triangles, int even, int odd, int n,
            bool odd_is_above) {
  for (int i = 0; i <= n; ++i) {
    if (odd_is_above) {
      triangles.push_back({even + i, odd + i + 1, odd + i});
      if (i < n) triangles.push_back({even + i, even + i + 1, odd + i + 1});
    } else {
      triangles.push_back({odd + i, odd + i + 1, even + i});
      if (i < n) triangles.push_back({odd + i + 1, even + i + 1, even + i});
    }
  }
}

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

// Takes the part before the first separator off a text.
std::string_view NextPart(std::string_view& rest, char separator) {
  const std::string_view part = rest.substr(0, rest.find(separator));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return part;
}

DiscOptions ParseDisc(const std::string& spec, const DrapeDiscs& discs) {
  std::string_view rest = std::string_view(spec).substr(kDiscPrefix.size());
  DiscOptions options{.radius = discs.specimen, .support_radius = discs.support};
  options.target_vertices =
      ParseNumber<int>(NextPart(rest, ','), spec, "a whole number of vertices as in disc:1200");
  while (!rest.empty()) {
    const std::string_view part = NextPart(rest, ',');
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
  const double length = ParseNumber<double>(NextPart(rest, 'x'), spec, expected);
  const double width = ParseNumber<double>(NextPart(rest, 'x'), spec, expected);
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

Mesh MakeStrip(double length, double width, int n_along, int n_across) {
  CHECK(length > 0 && width > 0 && n_along > 0 && n_across > 0);
  std::vector<Eigen::Vector2d> points;
  std::vector<std::array<int, 3>> triangles;
  int previous = 0;
  for (int row = 0; row <= n_across; ++row) {
    const int first = static_cast<int>(points.size());
    const bool odd = row % 2 == 1;
    for (int i = 0; i <= n_along + odd; ++i) {
      const double place = odd ? std::clamp(i - 0.5, 0.0, 1.0 * n_along) : i;
      points.emplace_back(length * place / n_along, width * (1.0 * row / n_across - 0.5));
    }
    if (row > 0) AddRow(triangles, odd ? previous : first, odd ? first : previous, n_along, odd);
    previous = first;
  }
  Eigen::Matrix2Xd uv(2, points.size());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * uv.cols());
  for (int i = 0; i < uv.cols(); ++i) uv.col(i) = x.segment<2>(3 * i) = points[i];
  return BuildMesh(x, uv, triangles, "strip");
}

Mesh Laid(const Mesh& mesh, double place, double direction) {
  const Eigen::Matrix2d turn_place = Eigen::Rotation2Dd(place).toRotationMatrix();
  const Eigen::Matrix2d turn_cloth = Eigen::Rotation2Dd(direction).toRotationMatrix();
  Eigen::VectorXd x = mesh.rest_x;
  Eigen::Matrix2Xd place_xy =
      turn_place *
      Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, mesh.num_vertices()).topRows<2>();
  place_xy.row(0).array() -= place_xy.row(0).minCoeff();
  place_xy.row(1).array() -= 0.5 * (place_xy.row(1).minCoeff() + place_xy.row(1).maxCoeff());
  for (int i = 0; i < mesh.num_vertices(); ++i) x.segment<2>(3 * i) = place_xy.col(i);
  const Eigen::Matrix2Xd uv = turn_cloth * place_xy;
  return BuildMesh(x, uv, ListTriangles(mesh), "laid mesh");
}

Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options, const DrapeDiscs& discs) {
  if (spec.starts_with(kStripPrefix)) return ParseStrip(spec);
  if (spec.starts_with(kDiscPrefix)) return MakeDisc(ParseDisc(spec, discs));
  return ReadObj(spec, options);
}

}  // namespace drape
