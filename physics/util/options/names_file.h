// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "physics/util/options/field.h"

namespace drape {

// Returns whether a text names a file, whose contents count, rather than one of the words.
inline bool NamesFile(const std::string& value, const Field& field) {
  return field.is_path &&
         std::none_of(field.words.begin(), field.words.end(),
                      [&](const std::string& word) { return value.starts_with(word); });
}
template <class T>
bool NamesFile(const T&, const Field&) {
  return false;
}

}  // namespace drape
