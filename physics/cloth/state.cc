// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/state.h"

#include <glog/logging.h>

#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

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

}  // namespace drape
