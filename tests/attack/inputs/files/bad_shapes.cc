// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {

std::vector<BadFile> MakeBadStarts(const std::string& valid) {
  std::vector<BadFile> bad =
      MakeChanged(valid + "waves.json", {{"/format", ""},
                                         {"/format", "\"x\""},
                                         {"/version", "2"},
                                         {"/modes", ""},
                                         {"/modes", "{}"},
                                         {"/modes", "[]", false},
                                         {"/modes/0", "[]"},
                                         {"/modes/0/k", ""},
                                         {"/modes/0/k", "-1"},
                                         {"/modes/0/k", "1.5"},
                                         {"/modes/0/k", "2147483648"},
                                         {"/modes/0/k", "1001"},
                                         {"/modes/0/amplitude_m", "\"x\""},
                                         {"/modes/0/amplitude_m", "1", false},
                                         {"/modes/0/amplitude_m", "1e6"},
                                         {"/modes/0/amplitude_m", "1e150"},
                                         {"/modes/0/amplitude_m", "1e200"},
                                         {"/modes/0/amplitude_m", "1e308"},
                                         {"/modes/0/amplitude_m", "-1e308"},
                                         {"/modes/0/phase", "1e308", false},
                                         {"/modes/0/phase", "null"},
                                         {"/modes/0/radius", "1"}});
  using nlohmann::json;
  json many = json::parse(ReadText(valid + "waves.json"));
  const json mode = many["modes"][0];
  for (int i = 0; i < 100000; ++i) many["modes"].push_back(mode);
  bad.push_back({"100000 modes", many.dump()});
  for (json& one : many["modes"]) one["amplitude_m"] = 1e308;
  bad.push_back({"100000 huge modes", many.dump()});
  return bad;
}

std::vector<BadFile> MakeBadStates(const std::string& valid) {
  using nlohmann::json;
  std::vector<BadFile> bad = MakeChanged(valid + "state.json", {{"/x", ""},
                                                                {"/v", ""},
                                                                {"/x", "[]"},
                                                                {"/x/0", ""},
                                                                {"/x/0", "[0, 0]"},
                                                                {"/x/0", "[0, 0, 0, 0]"},
                                                                {"/x/0/0", "null"},
                                                                {"/x/0/0", "1e308", false},
                                                                {"/x/0/0", "1e154", false},
                                                                {"/x/0/0", "1e30", false},
                                                                {"/x/5/2", "1e3", false},
                                                                {"/v/0/0", "1e308", false},
                                                                {"/v/0/0", "1e154", false},
                                                                {"/v/0/0", "1e30", false},
                                                                {"/v/0/0", "\"x\""},
                                                                {"/a", "[]"}});
  const json state = json::parse(ReadText(valid + "state.json"));
  const auto add = [&](const std::string& name, const std::string& key, double value) {
    json changed = state;
    for (json& point : changed[key])
      for (json& number : point) number = value;
    bad.push_back({name, changed.dump(), false});
  };
  add("all vertices at the origin", "x", 0.0);
  add("all vertices far away", "x", 1e300);
  add("all velocities huge", "v", 1e300);
  json turned = state;
  for (json& point : turned["x"]) point = {point[0], -point[1].get<double>(), point[2]};
  bad.push_back({"turned inside out", turned.dump(), false});
  return bad;
}

std::vector<BadFile> MakeBadScenes(const std::string& valid) {
  std::vector<BadFile> bad =
      MakeChanged(valid + "scene.json", {{"/gravity", "9.81"},
                                         {"/gravity", "[0, 0]"},
                                         {"/gravity", "[0, 0, null]"},
                                         {"/gravity", "[0, 0, -1e308]", false},
                                         {"/gravity", "[0, 0, -1e150]", false},
                                         {"/gravity", "[0, 0, -1e10]", false},
                                         {"/gravity", "[0, 0, 9.81]", false},
                                         {"/stretch", "1"},
                                         {"/stretch", "false", false},
                                         {"/bend", "false", false},
                                         {"/handles", "", false},
                                         {"/handles", "[]"},
                                         {"/handles/stiffness", ""},
                                         {"/handles/stiffness", "0"},
                                         {"/handles/stiffness", "-1"},
                                         {"/handles/stiffness", "1e308", false},
                                         {"/handles/stiffness", "1e-308", false},
                                         {"/handles/region", ""},
                                         {"/handles/region", "{}"},
                                         {"/handles/region/ring", "{}"},
                                         {"/handles/region/disc", "[]"},
                                         {"/handles/region/disc/radius", "0"},
                                         {"/handles/region/disc/radius", "-1"},
                                         {"/handles/region/disc/radius", "1e-300", false},
                                         {"/handles/region/disc/radius", "1e308", false},
                                         {"/handles/region/disc/radius", "\"x\""},
                                         {"/handles/region/square", "{}"},
                                         {"/contact", "{}"}});
  const std::vector<BadFile> loads = MakeChanged(
      valid + "pull.json", {{"/load/force", "[1e308, 0, 0]", false},
                            {"/load/force", "[0, 0]"},
                            {"/load/force", ""},
                            {"/load/region/half_plane/normal", "[0, 0, 0]"},
                            {"/load/region/half_plane/normal", "[1e-320, 0, 0]", false},
                            {"/load/region/half_plane/normal", "[1e200, 1e200, 0]", false},
                            {"/load/region/half_plane/offset", "1e308", false},
                            {"/load/region/half_plane/offset", "-9"},
                            {"/load/region", "{\"ring\": {\"inner\": 1, \"outer\": 0}}"},
                            {"/load/region", "{\"ring\": {\"inner\": -1}}"},
                            {"/handles/region/half_plane/offset", "-1e308"}});
  bad.insert(bad.end(), loads.begin(), loads.end());
  return bad;
}

}  // namespace drape::attack
