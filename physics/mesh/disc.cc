// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/disc.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <deque>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "physics/mesh/triangulate.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using std::numbers::pi;
using Edges = std::vector<std::pair<int, int>>;

constexpr int kMinVertices = 100, kMaxVertices = 1000000;
constexpr int kRelaxationSteps = 100;
constexpr double kMaxRadius = 100.0;  // [m]

// The distribution of the vertices over the disc. With triangles of edge h and area √3/4 h²,
// Euler's formula gives T = 2·V − hem − 2 triangles for the disc and T = 2·inner + ring − 2 inside
// the support.
struct Layout {
  double edge;  // h [m]
  int ring, hem, inner, outer;
};

Layout MakeLayout(const DiscOptions& o) {
  // π R² / (√3/4 h²) = 2 V − 2πR/h − 2, solved for q = 1/h.
  const double a = 4 * pi * o.radius * o.radius / std::numbers::sqrt3, b = 2 * pi * o.radius;
  const double q = (-b + std::sqrt(b * b + 8 * a * (o.target_vertices - 1))) / (2 * a);
  Layout layout{1 / q, static_cast<int>(std::lround(2 * pi * o.support_radius * q)),
                static_cast<int>(std::lround(b * q)), 0, 0};
  const double ratio = o.support_radius / o.radius;
  layout.inner = static_cast<int>(std::lround((a * q * q * ratio * ratio - layout.ring + 2) / 2));
  layout.outer = o.target_vertices - layout.ring - layout.hem - layout.inner;
  return layout;
}

void CheckOptions(const DiscOptions& o) {
  const auto fail = [](const std::string& problem) { throw InputError("disc", problem); };
  if (o.target_vertices < kMinVertices || o.target_vertices > kMaxVertices) {
    fail(std::to_string(o.target_vertices) + " vertices, expected " + std::to_string(kMinVertices) +
         ".." + std::to_string(kMaxVertices));
  }
  if (!(o.support_radius > 0 && o.radius > o.support_radius && o.radius <= kMaxRadius))
    fail(Format("radius %g m and support radius %g m, expected 0 < support radius < radius ≤ %g m",
                o.radius, o.support_radius, kMaxRadius));

  const double h = MakeLayout(o).edge;
  if (o.support_radius < 1.5 * h || o.radius - o.support_radius < 1.5 * h) {
    fail(
        Format("too few vertices: edges of %g m leave no room for rows of triangles inside and "
               "outside the support radius",
               h));
  }
}

void AddRing(Eigen::Matrix2Xd& points, int first, int count, double radius) {
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * pi * i / count;
    points.col(first + i) << radius * std::cos(angle), radius * std::sin(angle);
  }
}

// Spreads `count` points evenly but irregularly over r0 < r < r1, with one point in each cell of a
// polar grid.
void AddScattered(Eigen::Matrix2Xd& points, int first, int count, double r0, double r1,
                  double spacing, std::mt19937_64& random) {
  const int rows = std::max(1, static_cast<int>(std::lround((r1 - r0) / spacing)));
  const auto radius = [&](double row) { return r0 + (r1 - r0) * row / rows; };
  const auto share = [&](int row) {  // points below this row
    const double r = radius(row);
    return std::lround(count * (r * r - r0 * r0) / (r1 * r1 - r0 * r0));
  };
  for (int row = 0; row < rows; ++row) {
    const long begin = share(row), end = share(row + 1);
    const double phase = SampleUniform(random);
    for (long i = begin; i < end; ++i) {
      const double angle =
          2 * pi * (i - begin + phase + 0.5 * SampleUniform(random)) / (end - begin);
      const double r = radius(row + 0.25 + 0.5 * SampleUniform(random));
      points.col(first + i) << r * std::cos(angle), r * std::sin(angle);
    }
  }
}

Edges RingEdges(int first, int count) {
  Edges edges;
  for (int i = 0; i < count; ++i) edges.emplace_back(first + i, first + (i + 1) % count);
  return edges;
}

Mesh FlatMesh(const Eigen::Matrix2Xd& points, const Edges& edges) {
  const std::vector<int> order = SpatialOrder(points);
  std::vector<int> rank(order.size());
  Eigen::Matrix2Xd uv(2, points.cols());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * points.cols());
  for (size_t k = 0; k < order.size(); ++k) {
    rank[order[k]] = static_cast<int>(k);
    uv.col(k) = x.segment<2>(3 * k) = points.col(order[k]);
  }
  Edges ranked;
  for (const auto& [a, b] : edges) ranked.emplace_back(rank[a], rank[b]);
  return BuildMesh(x, uv, Triangulate(uv, ranked), "disc");
}

Mesh BuildDisc(const DiscOptions& options) {
  const Layout n = MakeLayout(options);
  const double gap = n.edge / 2, row = n.edge * std::numbers::sqrt3 / 2;
  const int first_inner = n.ring + n.hem, first_outer = first_inner + n.inner;
  Eigen::Matrix2Xd points(2, options.target_vertices);
  std::mt19937_64 random(1);
  AddRing(points, 0, n.ring, options.support_radius);
  AddRing(points, n.ring, n.hem, options.radius);
  AddScattered(points, first_inner, n.inner, 0, options.support_radius - gap, row, random);
  AddScattered(points, first_outer, n.outer, options.support_radius + gap, options.radius - gap,
               row, random);
  const Edges edges = RingEdges(0, n.ring);
  for (int step = 0; step < kRelaxationSteps; ++step) {
    MoveToCentroids(Triangulate(points, edges), first_inner, points);
  }
  return FlatMesh(points, edges);
}

}  // namespace

std::string ToString(const DrapeDiscs& discs) {
  constexpr double kCentimetres = 100.0;  // in a metre
  return Format("%g cm on %g cm", kCentimetres * 2 * discs.specimen,
                kCentimetres * 2 * discs.support);
}

std::string DiscsLine(const DrapeDiscs& discs) {
  return Format("specimen_diameter_m=%.15g support_diameter_m=%.15g", 2 * discs.specimen,
                2 * discs.support);
}

std::optional<DrapeDiscs> ParseDiscsLine(const std::string& line) {
  double specimen = 0.0, support = 0.0;
  const int read = std::sscanf(line.c_str(), "specimen_diameter_m=%lf support_diameter_m=%lf",
                               &specimen, &support);
  if (read != 2 || !(support > 0.0 && support < specimen && specimen < 100.0)) return std::nullopt;
  return DrapeDiscs{specimen / 2, support / 2};
}

// Keeps the last discs, since a fit makes the same ones several times, and fits side by side too.
Mesh MakeDisc(const DiscOptions& options) {
  constexpr std::size_t kMostKept = 8;
  constexpr int kMostVertices = 10000;  // of one that is kept
  CheckOptions(options);
  if (options.target_vertices > kMostVertices) return BuildDisc(options);
  static std::mutex mutex;
  static std::deque<std::pair<DiscOptions, Mesh>> kept;
  const std::scoped_lock lock(mutex);
  for (const auto& [made, mesh] : kept)
    if (made.radius == options.radius && made.support_radius == options.support_radius &&
        made.target_vertices == options.target_vertices)
      return mesh;
  if (kept.size() == kMostKept) kept.pop_front();
  return kept.emplace_back(options, BuildDisc(options)).second;
}

}  // namespace drape
