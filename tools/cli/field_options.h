// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "physics/util/options/field.h"
#include "tools/cli/option_table.h"

namespace drape {

// The option of an enum, by the names of its values.
template <NamedEnum E>
Option EnumOption(E& value, Option option) {
  option.value = EnumField{[&value] { return std::string(ToString(value)); },
                           [&value, where = "option '" + option.key + "'"](
                               const std::string& text) { value = ParseName<E>(text, where); }};
  for (const auto& [named, name] : EnumNames(E{})) option.choices.push_back(name);
  return option;
}
template <NamedEnum E>
Option EnumOption(const std::string& key, E& value, const std::string& doc) {
  return EnumOption(value, {.key = key, .doc = doc});
}

// The options of a struct whose fields are described (VisitFields), in the order of their visit.
// Points into `options`, which outlives them.
template <class Options>
std::vector<Option> FieldOptionList(Options& options) {
  std::vector<Option> list;
  VisitFields(options, [&](auto& value, Option field) {
    using T = std::remove_reference_t<decltype(value)>;
    if (!field.is_option) return;
    if constexpr (NamedEnum<T>) {
      list.push_back(EnumOption(value, std::move(field)));
    } else if constexpr (std::is_constructible_v<Option::Value, T*>) {
      field.value = &value;
      list.push_back(std::move(field));
    }
  });
  return list;
}

}  // namespace drape
