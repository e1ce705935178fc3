// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "physics/cloth/start_shape.h"
#include "physics/cloth/state_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

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

StartShape ReadStartShape(const std::string& path) {
  const nlohmann::json file = ReadJsonFile(path);
  return ParseStartShape(JsonInput(file, path));
}

void WriteStartShape(const std::string& path, const StartShape& shape) {
  std::string text =
      "{\n  \"format\": \"" + std::string(kShapeFormat) + "\",\n  \"version\": 1,\n  \"modes\": [";
  for (size_t i = 0; i < shape.modes.size(); ++i) {
    const StartShape::Mode& mode = shape.modes[i];
    text += i == 0 ? "\n" : ",\n";
    text += "    {\"k\": " + std::to_string(mode.k);
    AppendNumber(text += ", \"amplitude_m\": ", mode.amplitude_m);
    AppendNumber(text += ", \"phase\": ", mode.phase);
    text += '}';
  }
  WriteFileAtomically(path, text += "\n  ]\n}\n");
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
