// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/fuzz/json_mutator.h"

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace drape::attack {
namespace {

using nlohmann::json;

void List(json* value, std::vector<json*>* all) {
  all->push_back(value);
  if (value->is_structured())
    for (json& child : *value) List(&child, all);
}

const std::vector<json>& ExtremeValues() {
  static const std::vector<json> kValues = {nullptr,
                                            true,
                                            "",
                                            "x",
                                            json::array(),
                                            json::object(),
                                            0,
                                            1,
                                            -1,
                                            -0.0,
                                            0.5,
                                            1e-320,
                                            1e-30,
                                            1e30,
                                            -1e30,
                                            std::numeric_limits<double>::max(),
                                            std::numeric_limits<int32_t>::max(),
                                            std::numeric_limits<int32_t>::min(),
                                            1LL << 31,
                                            std::numeric_limits<int64_t>::max(),
                                            std::numeric_limits<int64_t>::min(),
                                            std::numeric_limits<uint64_t>::max(),
                                            1000000};
  return kValues;
}

}  // namespace

void MutateJson(json* document, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  std::vector<json*> all;
  List(document, &all);
  json& value = *all[below(all.size())];
  switch (below(5)) {
    case 0:
      value = json(*all[below(all.size())]);
      break;
    case 1:
      if (value.is_structured() && !value.empty()) {
        value.erase(std::next(value.begin(), static_cast<std::ptrdiff_t>(below(value.size()))));
        break;
      }
      [[fallthrough]];
    case 2:
      if (value.is_array() && !value.empty()) {
        value.push_back(json(value[below(value.size())]));
        break;
      }
      [[fallthrough]];
    case 3:
      if (value.is_number()) {
        const double factor[] = {-1.0, 0.1, 2.0, 10.0, 1e6, 1e-6};
        value = value.get<double>() * factor[below(std::size(factor))];
        break;
      }
      [[fallthrough]];
    default:
      value = ExtremeValues()[below(ExtremeValues().size())];
  }
}

}  // namespace drape::attack
