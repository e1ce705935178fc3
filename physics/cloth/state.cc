// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/state.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

Eigen::VectorXd ReadTriples(const JsonInput& input, int num_vertices) {
  if (!input.value().is_array() || input.Size() != num_vertices) {
    input.Fail("an array of " + std::to_string(num_vertices) + ", the vertices of the mesh");
  }
  Eigen::VectorXd values(3 * num_vertices);
  for (int i = 0; i < num_vertices; ++i) {
    const JsonInput triple = input.At(i).ExpectArray(3);
    for (int k = 0; k < 3; ++k) values[3 * i + k] = triple.At(k).Number();
  }
  return values;
}

void AppendTriples(std::string& text, const Eigen::VectorXd& values) {
  text += '[';
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const char* before_vertex = i == 0 ? "\n[" : "],\n[";
    text += i % 3 == 0 ? before_vertex : ", ";
    AppendNumber(text, values[i]);
  }
  text += "]]";
}

using std::numbers::pi;

double HemHeight(const StartShape& shape, double theta) {
  double z = 0;
  for (const auto& mode : shape.modes) {
    z += mode.amplitude_m * std::cos(mode.k * theta - mode.phase);
  }
  return z;
}

double HemBeyondSupport(const Mesh& mesh, double support_radius) {
  const double hem = HemRadius(mesh);
  if (!(hem > support_radius)) {
    throw InputError("start shape", "the mesh reaches to " + std::to_string(hem) +
                                        " m, expected more than the support radius of " +
                                        std::to_string(support_radius) + " m");
  }
  return hem;
}

// Interpolates linearly between the samples of a profile around the circle.
double ProfileAt(const Eigen::VectorXd& profile, double theta) {
  const auto n = profile.size();
  double at = theta / (2 * pi) * static_cast<double>(n);
  if (at < 0) at += static_cast<double>(n);
  const auto before = static_cast<Eigen::Index>(at);
  const double share = at - static_cast<double>(before);
  return (1 - share) * profile[before % n] + share * profile[(before + 1) % n];
}

constexpr char kShapeFormat[] = "drapefit-start-shape";
constexpr int kVersion = 1, kMaxWaves = 1000, kMaxModes = 100;
constexpr double kMaxAmplitude = 0.1, kMaxHemRms = 0.1;  // [m]; the cloth overhangs by 0.06
constexpr double kMaxPhase = 1e3;                        // [rad]

StartShape::Mode ParseMode(const JsonInput& input) {
  input.ExpectKeys({"k", "amplitude_m", "phase"});
  const int k = input.At("k").Integer();
  if (k < 0 || k > kMaxWaves) input.At("k").Fail("0.." + std::to_string(kMaxWaves));
  return {k, input.At("amplitude_m").NumberWithin(-kMaxAmplitude, kMaxAmplitude),
          input.At("phase").NumberWithin(-kMaxPhase, kMaxPhase)};
}

StartShape ParseStartShape(const JsonInput& input) {
  input.ExpectKeys({"format", "version", "modes"});
  if (input.At("format").String() != kShapeFormat) {
    input.At("format").Fail(std::string("\"").append(kShapeFormat) + '"');
  }
  if (input.At("version").Integer() != kVersion) input.At("version").Fail("1");
  const JsonInput modes = input.At("modes").ExpectArray();
  StartShape shape;
  if (modes.Size() > kMaxModes) modes.Fail(Format("at most %d modes", kMaxModes));
  for (int i = 0; i < modes.Size(); ++i) shape.modes.push_back(ParseMode(modes.At(i)));
  if (HemRms(shape) > kMaxHemRms)
    modes.Fail(
        Format("a root mean square height of at most %g m at the hem, which these modes "
               "exceed with %g m",
               kMaxHemRms, HemRms(shape)));
  return shape;
}

}  // namespace

State ReadState(const std::string& path, int num_vertices) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  input.ExpectKeys({"x", "v"});
  return {ReadTriples(input.At("x"), num_vertices), ReadTriples(input.At("v"), num_vertices)};
}

void WriteState(const std::string& path, const State& state) {
  CHECK_EQ(state.x.size(), state.v.size());
  CHECK_EQ(state.x.size() % 3, 0);
  std::string text = "{\"x\": ";
  AppendTriples(text, state.x);
  AppendTriples(text += ",\n\"v\": ", state.v);
  WriteFileAtomically(path, text += "}\n");
}

double HemRadius(const Mesh& mesh) {
  double radius = 0;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    radius = std::max(radius, mesh.rest_x.segment<2>(3 * i).norm());
  }
  return radius;
}

Eigen::VectorXd ApplyStartShape(const Mesh& mesh, double support_radius, const StartShape& shape) {
  const double hem = HemBeyondSupport(mesh, support_radius);
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const Eigen::Vector2d p = mesh.rest_x.segment<2>(3 * i);
    const double s = (p.norm() - support_radius) / (hem - support_radius);
    if (s <= 0) continue;
    x[3 * i + 2] += s * s * (3 - 2 * s) * HemHeight(shape, std::atan2(p.y(), p.x()));
  }
  return x;
}

double HemRms(const StartShape& shape) {
  double sum = 0;
  for (const auto& mode : shape.modes) sum += mode.amplitude_m * mode.amplitude_m / 2;
  return std::sqrt(sum);
}

StartShape RandomStartShape(uint64_t seed, double hem_rms, const ModeRange& range) {
  CHECK(range.first >= 1 && range.last >= range.first);
  CHECK_GE(hem_rms, 0);
  std::mt19937_64 random(seed);
  const double sigma = hem_rms / std::sqrt(range.last - range.first + 1);
  StartShape shape;
  for (int k = range.first; k <= range.last; ++k) {
    const double a = sigma * SampleNormal(random), b = sigma * SampleNormal(random);
    shape.modes.push_back({k, std::hypot(a, b), std::atan2(b, a)});  // a cos kθ + b sin kθ
  }
  return shape;
}

Eigen::VectorXd FlapsFromOutline(const Mesh& mesh, double support_radius,
                                 const Eigen::VectorXd& outline, double lift) {
  CHECK_GE(outline.size(), 3);
  CHECK(lift > 0 && lift <= 1) << lift;
  const double length = HemBeyondSupport(mesh, support_radius) - support_radius;
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const Eigen::Vector2d p = mesh.rest_x.segment<2>(3 * i);
    const double flap = p.norm() - support_radius;
    if (flap <= 0) continue;
    const double reach = (ProfileAt(outline, std::atan2(p.y(), p.x())) - support_radius) / length;
    const double angle = lift * std::acos(std::clamp(reach, -1.0, 1.0));
    x.segment<2>(3 * i) = p.normalized() * (support_radius + flap * std::cos(angle));
    x[3 * i + 2] -= flap * std::sin(angle);
  }
  return x;
}

StartShape ReadStartShape(const std::string& path) {
  const nlohmann::json file = ReadJsonFile(path);
  return ParseStartShape(JsonInput(file, path));
}

State ReadStart(const std::string& path, const Mesh& mesh, double support_radius) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (input.Has("modes") || input.Has("format")) {
    return {ApplyStartShape(mesh, support_radius, ParseStartShape(input)),
            Eigen::VectorXd::Zero(mesh.rest_x.size())};
  }
  if (input.Has("x") || input.Has("v")) return ReadState(path, mesh.num_vertices());
  input.Fail("a start shape (keys format, version, modes) or a state (keys x, v)");
}

}  // namespace drape
