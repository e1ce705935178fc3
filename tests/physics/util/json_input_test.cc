// SPDX-License-Identifier: Apache-2.0
#include "physics/util/json_input.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

std::string Nested(int levels) {
  return std::string(levels - 1, '[') + "{}" + std::string(levels - 1, ']');
}

TEST(JsonInput, RefusesValuesThatAreNestedTooDeep) {
  EXPECT_NO_THROW(ParseJson(Nested(64), "a.json"));
  EXPECT_INPUT_ERROR(ParseJson(Nested(65), "a.json"), "a.json: found values nested deeper than 64");
  EXPECT_INPUT_ERROR(ParseJson(std::string(1'000'000, '['), "a.json"), "deeper than 64");
}

}  // namespace
}  // namespace drape
