// SPDX-License-Identifier: Apache-2.0
// Patterns, bodies, obstacles and spaces of materials.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {

using nlohmann::json;

std::vector<BadFile> MakeBadGarments(const std::string& valid) {
  return MakeChanged(valid + "skirt.json",
                     {{"/format", "\"x\""},
                      {"/format", ""},
                      {"/version", "2"},
                      {"/name", "3"},
                      {"/name", "\"\\u001b[31m\\n\"", false},
                      {"/name", "\"" + std::string(5000, 'x') + "\"", false},
                      {"/arm_angle", "1e308"},
                      {"/arm_angle", "-1"},
                      {"/panels", "{}"},
                      {"/panels", "[]"},
                      {"/panels/skirt/vertices", "[]"},
                      {"/panels/skirt/vertices/0", "[1e308, 0]"},
                      {"/panels/skirt/vertices/0", "[1e-308, 0]"},
                      {"/panels/skirt/vertices/0", "[20, 0]"},
                      {"/panels/skirt/vertices/4", "[0.61, 0]"},
                      {"/panels/skirt/vertices/4", "[null, 0]"},
                      {"/panels/skirt/outline", "[]"},
                      {"/panels/skirt/outline/0/circle/radius", "0"},
                      {"/panels/skirt/outline/0/circle/radius", "1e308"},
                      {"/panels/skirt/outline/0/circle/counter_clockwise", "1"},
                      {"/panels/skirt/outline/0/circle/large", "true", false},
                      {"/panels/skirt/outline/0/endpoints", "[0, 99]"},
                      {"/panels/skirt/outline/0/endpoints", "[-1, 1]"},
                      {"/panels/skirt/outline/0/endpoints", "[0, 0]"},
                      {"/panels/skirt/outline/0/endpoints", "[0, 2147483648]"},
                      {"/panels/skirt/holes/0", "[]"},
                      {"/panels/skirt/holes", "[[], []]"},
                      {"/panels/skirt/translation", "[0, 0, 1e308]"},
                      {"/panels/skirt/translation", "[0, 0, 20]", false},
                      {"/panels/skirt/translation", "[0, 0, 0.5]", false},
                      {"/panels/skirt/translation", "[0.3, 0, 1.1]", false},
                      {"/panels/skirt/rotation", "[1e308, 0, 0]", false},
                      {"/panels/skirt/rotation", "[90, 0, 0]", false},
                      {"/panels/skirt/rotation", "[1, 0]"},
                      {"/panels/skirt/cylinder_radius", "1e-300"},
                      {"/panels/skirt/cylinder_radius", "0.01"},
                      {"/rings", "[]", false},
                      {"/rings/0/panel", "\"x\""},
                      {"/rings/0/panel", "\"\\u001b[31m\\n\""},
                      {"/rings/0/edges", "[99]"},
                      {"/rings/0/edges", "[]", false},
                      {"/rings/0/edges", "[0, 1, 2, 3]", false},
                      {"/rings/0/held_by", "\"x\""},
                      {"/stitches", "[{\"edges\": [[\"skirt\", 0], [\"skirt\", 0]]}]"},
                      {"/stitches", "[{\"edges\": [[\"skirt\", 0], [\"skirt\", 2]]}]", false},
                      {"/stitches", "[{\"edges\": [[\"skirt\", 0], [\"skirt\", 5]]}]"},
                      {"/more", "1"}});
}

std::vector<BadFile> MakeBadGarmentCodes(const std::string& valid) {
  return MakeChanged(valid + "garmentcode.json",
                     {{"/pattern", "[]"},
                      {"/pattern/panels", "{}"},
                      {"/pattern/panels/front/edges/0/curvature/type", "\"x\""},
                      {"/pattern/panels/front/edges/0/curvature/params", "[]"},
                      {"/pattern/panels/front/edges/0/curvature/params", "[[1e308, 0]]"},
                      {"/pattern/panels/front/edges/0/curvature/params", "[[0.5, 1e3]]"},
                      {"/pattern/panels/back/edges/0/curvature/params", "[0, 0, 0]"},
                      {"/pattern/panels/back/edges/0/curvature/params", "[1e307, 0, 0]"},
                      {"/pattern/panels/back/edges/0/curvature/params", "[60, 1, 1]", false},
                      {"/pattern/panels/front/vertices", "[[0, 0], [1, 0], [1, 1], [0, 1]]", false},
                      {"/pattern/panels/front/vertices/0", "[-2000, 0]", false},
                      {"/pattern/panels/front/translation", "[1e308, 0, 0]"},
                      {"/pattern/panels/front/translation", "[0, 85, -35]", false},
                      {"/pattern/panels/front/rotation", "[0, 1e300, 0]", false},
                      {"/pattern/stitches", "[]", false},
                      {"/pattern/stitches/0", "[]"},
                      {"/pattern/stitches/0/0/edge", "-1"},
                      {"/pattern/stitches/0/0/panel", "\"x\""},
                      {"/properties", "", false},
                      {"/properties/units_in_meter", "0"},
                      {"/properties/units_in_meter", "1e-308"},
                      {"/properties/units_in_meter", "1e308"},
                      {"/properties/units_in_meter", "100000", false},
                      {"/properties/units_in_meter", "1"}});
}

// The only frame of a body.
std::vector<BadFile> MakeBadBodies(const std::string& valid) {
  const std::string good = ReadText(valid + "body.obj");
  const std::string faces = good.substr(good.find('f'));
  const auto moved = [&](double scale) {
    std::string text;
    for (const char* point : {"0 0 0", "0 0 1.8", "0.2 0 1", "0 0.2 1", "-0.2 0 1", "0 -0.2 1"}) {
      double x[3];
      std::sscanf(point, "%lf %lf %lf", x, x + 1, x + 2);
      text += "v " + std::to_string(scale * x[0]) + " " + std::to_string(scale * x[1]) + " " +
              std::to_string(scale * x[2]) + "\n";
    }
    return text + faces;
  };
  std::string open = good, twice = good, outside = good;
  open.erase(open.rfind('f'));
  twice += good.substr(good.rfind('f'));
  outside += "f 1 2 999\n";
  return {{"empty", ""},
          {"no faces", good.substr(0, good.find('f'))},
          {"not closed", open, false},
          {"a face twice", twice, false},
          {"a vertex that there is not", outside},
          {"not a number", "v nan 0 0\n" + faces},
          {"infinite", "v 1e999 0 0\n" + faces},
          {"all in one place", moved(0.0)},
          {"tiny", moved(1e-5), false},
          {"as large as a house", moved(10.0), false},
          {"huge", moved(1e30), false},
          {"binary", std::string("\x00\xff\xfe\x01", 4)}};
}

std::vector<BadFile> MakeBadContacts(const std::string& valid) {
  const std::string open_surface =
      nlohmann::json(std::filesystem::absolute(valid + "disc.obj").string()).dump();
  return MakeChanged(valid + "contact.json",
                     {{"/contact", "[]"},
                      {"/contact", "{}"},
                      {"/contact/more", "1"},
                      {"/contact/thickness", "-1"},
                      {"/contact/thickness", "1e308"},
                      {"/contact/thickness", "0", false},
                      {"/contact/thickness", "1e-308", false},
                      {"/contact/range", "0"},
                      {"/contact/range", "1e308"},
                      {"/contact/range", "1e-308", false},
                      {"/contact/stiffness", "0"},
                      {"/contact/stiffness", "-1"},
                      {"/contact/stiffness", "1e308"},
                      {"/contact/stiffness", "1e-300", false},
                      {"/contact/obstacles", "{}"},
                      {"/contact/obstacles", "[]", false},
                      {"/contact/obstacles/0", "[]"},
                      {"/contact/obstacles/0", "{}"},
                      {"/contact/obstacles/0", "{\"sphere\": {}, \"plane\": {}}"},
                      {"/contact/obstacles/0/sphere/radius", "0"},
                      {"/contact/obstacles/0/sphere/radius", "1e308"},
                      {"/contact/obstacles/0/sphere/radius", "1e-300", false},
                      {"/contact/obstacles/0/sphere/centre", "[1e308, 0, 0]"},
                      {"/contact/obstacles/0/sphere/centre", "[0, 0, 0]", false},
                      {"/contact/obstacles/0/sphere/centre", "[0, 0]"},
                      {"/contact/obstacles/1/plane/normal", "[0, 0, 0]"},
                      {"/contact/obstacles/1/plane/normal", "[0, 0, 1e-320]", false},
                      {"/contact/obstacles/1/plane/normal", "[1e200, 0, 1e200]", false},
                      {"/contact/obstacles/1/plane/offset", "0", false},
                      {"/contact/obstacles/1/plane/offset", "1e308", false},
                      {"/contact/obstacles/1/plane/offset", "-1e308", false},
                      {"/contact/obstacles/2/capsule/to", "[-0.2, 0.3, -0.2]", false},
                      {"/contact/obstacles/2/capsule/to", "[1e308, 0, 0]"},
                      {"/contact/obstacles/2/capsule/radius", "-1"},
                      {"/contact/obstacles/3/plate/rim_radius", "0"},
                      {"/contact/obstacles/3/plate/rim_radius", "1"},
                      {"/contact/obstacles/3/plate/radius", "1e-300"},
                      {"/contact/obstacles/3/plate/thickness", "null"},
                      {"/contact/obstacles/4/mesh", "[]"},
                      {"/contact/obstacles/4/mesh/file", ""},
                      {"/contact/obstacles/4/mesh/file", "1"},
                      {"/contact/obstacles/4/mesh/file", "\"\""},
                      {"/contact/obstacles/4/mesh/file", "\"none.obj\""},
                      {"/contact/obstacles/4/mesh/file", "\"contact.json\""},
                      {"/contact/obstacles/4/mesh/file", "\"/dev/null\""},
                      {"/contact/obstacles/4/mesh/file", open_surface},
                      {"/contact/obstacles/4/mesh/scale", "", false},
                      {"/contact/obstacles/4/mesh/scale", "0"},
                      {"/contact/obstacles/4/mesh/scale", "-1"},
                      {"/contact/obstacles/4/mesh/scale", "1e308"},
                      {"/contact/obstacles/4/mesh/scale", "1e-300"},
                      {"/contact/obstacles/4/mesh/scale", "1e-5", false},
                      {"/contact/obstacles/4/mesh/translation", "", false},
                      {"/contact/obstacles/4/mesh/translation", "[0, 0]"},
                      {"/contact/obstacles/4/mesh/translation", "[0, 0, 1e308]"},
                      {"/contact/obstacles/4/mesh/translation", "[0, 0, 0]", false},
                      {"/contact/obstacles/4/mesh/more", "1"}});
}

std::vector<BadFile> MakeBadSpaces(const std::string& valid) {
  return MakeChanged(valid + "space.json", {{"/format", "\"x\""},
                                            {"/version", "2"},
                                            {"/by", "\"x\""},
                                            {"/by", "\"weight\"", false},
                                            {"/kind", "\"bdp\""},
                                            {"/names", "[]"},
                                            {"/names", "[\"a\", \"b\", \"c\"]"},
                                            {"/base/density", "0"},
                                            {"/base/density", "1e308", false},
                                            {"/base/density", "1e-308", false},
                                            {"/base/stretch", "[]"},
                                            {"/base/stretch/0/0", "-1"},
                                            {"/base/stretch/0/0", "0", false},
                                            {"/base/stretch/0/0", "1e308", false},
                                            {"/base/stretch/0/0", "1e-308", false},
                                            {"/base/bend/0/0", "0"},
                                            {"/base/bend/0/0", "1e308", false},
                                            {"/base/bend/0/0", "1e-308", false},
                                            {"/prior", ""},
                                            {"/prior/mean", "[]"},
                                            {"/prior/mean/0", "1e308"},
                                            {"/prior/mean/0", "700"},
                                            {"/prior/mean/0", "null"},
                                            {"/prior/covariance", "[]"},
                                            {"/prior/covariance/0/0", "-1"},
                                            {"/prior/covariance/0/0", "0"},
                                            {"/prior/covariance/0/0", "1e308"},
                                            {"/prior/covariance/0/0", "1e-308"},
                                            {"/prior/covariance/0/0", "1e-30"},
                                            {"/prior/covariance/0/0", "1e-17", false},
                                            {"/prior/covariance/0/0", "1e17", false},
                                            {"/prior/covariance/0/1", "5"},
                                            {"/fabrics", "", false},
                                            {"/population", "", false}});
}

}  // namespace drape::attack
