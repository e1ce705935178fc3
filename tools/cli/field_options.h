// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "physics/util/options/enum_names.h"
#include "physics/util/options/field.h"
#include "tools/cli/option_table.h"

namespace drape {

// An enum as an option, by the names of its values.
template <NamedEnum E>
Option EnumOption(const std::string& key, E& value, const std::string& doc) {
  Option option{.key = key,
                .value = EnumField{[&value] { return std::string(ToString(value)); },
                                   [&value, key](const std::string& text) {
                                     value = ParseName<E>(text, "option '" + key + "'");
                                   }},
                .doc = doc};
  for (const auto& [named, name] : EnumNames(E{})) option.choices.push_back(name);
  return option;
}

// The options of a struct whose fields are described (VisitFields), in the order of their visit.
// Points into `options`, which outlives them.
template <class Options>
std::vector<Option> FieldOptionList(Options& options) {
  std::vector<Option> list;
  VisitFields(options, [&](auto& value, const Field& field) {
    using T = std::remove_reference_t<decltype(value)>;
    if (!field.is_option) return;
    if constexpr (NamedEnum<T>) {
      list.push_back(EnumOption(field.key, value, field.doc));
    } else if constexpr (std::is_constructible_v<Option::Value, T*>) {
      list.push_back({.key = field.key,
                      .value = &value,
                      .doc = field.doc,
                      .unit = field.unit,
                      .least = field.least,
                      .most = field.most,
                      .above_least = field.above_least,
                      .is_path = field.is_path});
      if (*field.word != '\0') list.back().words = {field.word};
    }
  });
  return list;
}

}  // namespace drape
