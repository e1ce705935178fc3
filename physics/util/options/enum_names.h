// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <utility>

#include "physics/util/errors.h"

namespace drape {

// Names of an enum's values, as users write them. An enum E takes part by a function
//   constexpr auto EnumNames(E) { return MakeNames<E>({{E::kA, "a"}, {E::kB, "b"}}); }
// beside its definition.
template <class E, std::size_t N>
constexpr std::array<std::pair<E, const char*>, N> MakeNames(
    const std::pair<E, const char*> (&names)[N]) {
  return std::to_array(names);
}

template <class E>
concept NamedEnum = requires(E value) {
  EnumNames(value);
};

template <NamedEnum E>
const char* ToString(E value) {
  for (const auto& [named, name] : EnumNames(E{}))
    if (named == value) return name;
  return "";
}

// Throws InputError, which starts with `where`, for a name that is none of them.
template <NamedEnum E>
E ParseName(const std::string& text, const std::string& where) {
  std::string all;
  for (const auto& [named, name] : EnumNames(E{})) {
    if (text == name) return named;
    all += all.empty() ? name : std::string(", ") + name;
  }
  throw InputError(where, "found '" + text + "', expected one of " + all);
}

}  // namespace drape
