// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {
namespace {

// A table of one number.
std::string Table(int rows, int columns, const std::string& number) {
  std::string text;
  for (int row = 0; row < rows; ++row) {
    text += row == 0 ? "[[" : ", [";
    for (int column = 0; column < columns; ++column) text += (column == 0 ? "" : ", ") + number;
    text += "]";
  }
  return text + "]";
}

}  // namespace

std::vector<BadFile> MakeBadMaterials(const std::string& valid) {
  std::vector<BadFile> bad =
      MakeChanged(valid + "wool.json", {{"/density", ""},
                                        {"/density", "0"},
                                        {"/density", "-1"},
                                        {"/density", "\"1\""},
                                        {"/density", "null"},
                                        {"/density", "1e308", false},
                                        {"/density", "1e-308", false},
                                        {"/density", "5e-324", false},
                                        {"/stretch", ""},
                                        {"/stretch", "[]"},
                                        {"/stretch", "[[]]"},
                                        {"/stretch", "{}"},
                                        {"/stretch/0", "[1, 2, 3]"},
                                        {"/stretch/0", "[1, 2, 3, 4, 5]"},
                                        {"/stretch/1/2", "-1"},
                                        {"/stretch/1/2", "null"},
                                        {"/stretch/1/2", "\"NaN\""},
                                        {"/stretch/1/2", "1e308", false},
                                        {"/stretch/0/1", "1e6", false},
                                        {"/stretch", Table(6, 4, "0"), false},
                                        {"/stretch", Table(6, 4, "1e308"), false},
                                        {"/stretch", Table(6, 4, "1e-308"), false},
                                        {"/stretch", Table(6, 4, "1e150"), false},
                                        {"/stretch", Table(5, 4, "1")},
                                        {"/stretch", Table(4, 6, "1")},
                                        {"/bend", ""},
                                        {"/bend", Table(5, 3, "1")},
                                        {"/bend", Table(3, 5, "0"), false},
                                        {"/bend", Table(3, 5, "1e308"), false},
                                        {"/bend", Table(3, 5, "-1e-9")},
                                        {"/bend", Table(3, 5, "1e-320"), false},
                                        {"/bend/2/4", "true"},
                                        {"/convention", ""},
                                        {"/convention", "\"imperial\""},
                                        {"/units", "\"mm\""},
                                        {"/version", "2"},
                                        {"/version", "1.5"},
                                        {"/version", "1e300"},
                                        {"/format", "\"\""},
                                        {"/format", "7"},
                                        {"/format", ""},
                                        {"/name", "5"},
                                        {"/name", "\"\\u001b[31m\\n`touch PLANTED`\"", false},
                                        {"/source", "[]"}});
  const std::vector<BadFile> published =
      MakeChanged(valid + "published.json", {{"/density", "-1"},
                                             {"/c11", ""},
                                             {"/c11", "[1]"},
                                             {"/c33/5", "\"x\""},
                                             {"/bending", "[]"},
                                             {"/bending/0/0", "null"},
                                             {"/c99", "1"}});
  bad.insert(bad.end(), published.begin(), published.end());
  const std::string fabric = ReadText(valid + "wool.json");
  bad.push_back({"two fabrics", "{\"a\": " + fabric + ", \"b\": " + fabric + "}"});
  bad.push_back(
      {"fabrics with escape codes", "{\"\\u001b[31m\\n\": " + fabric + ", \"b\": " + fabric + "}"});
  bad.push_back({"no fabric", "{\"a\": {}, \"b\": 1}"});
  bad.push_back({"notes only", "{\"_note\": \"x\"}"});
  return bad;
}

std::vector<BadFile> MakeBadFields(const std::string& valid) {
  return MakeChanged(valid + "field.json", {{"/face_centres", ""},
                                            {"/face_centres", "[]"},
                                            {"/face_centres/0", "[1]"},
                                            {"/face_centres/0", "[1, 2, 3]"},
                                            {"/face_centres/0/0", "null"},
                                            {"/face_centres/0/0", "1e308", false},
                                            {"/face_centres/0", ""},
                                            {"/hinge_centres/0", ""},
                                            {"/hinge_centres", "[]"},
                                            {"/stretch/0", ""},
                                            {"/stretch", "[]"},
                                            {"/stretch/0/0", "-1"},
                                            {"/stretch/0/0", ""},
                                            {"/stretch/0/0", "1e308", false},
                                            {"/bend/0/0", "\"x\""},
                                            {"/bend/0", "[]"},
                                            {"/density", "0"},
                                            {"/version", "3"},
                                            {"/convention", "\"x\""}});
}

}  // namespace drape::attack
