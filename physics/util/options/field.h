// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <type_traits>
#include <vector>

namespace drape {

// A field of an options struct, described in one place. Such a struct has, beside it,
//   template <MutableOrConst<MyOptions> Options, class Visitor>
//   void VisitFields(Options& options, Visitor&& visit) {
//     auto& [a, b] = options;  // a field that is missing here does not compile
//     visit(a, Field{.key = "a", .doc = "…"});
//     …
// from which follow its check (CheckFields), its place in the key of a checkpoint, and its options
// on a command line. The struct's own initialisers are the defaults.
struct Field {
  const char* key = "";
  const char* doc = "";                                     // one line, for --help
  const char* unit = "";                                    // empty: none
  double least = -std::numeric_limits<double>::infinity();  // of a number or of each in a list
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;  // the least itself is excluded
  bool is_option = true;     // on the command line
  bool in_key = true;        // of a checkpoint: another value is another fit
  bool is_path = false;      // of a text
  const char* word = "";     // with is_path: a prefix of texts that are no paths, "disc:"
};

template <class Options, class Struct>
concept MutableOrConst = std::is_same_v<std::remove_const_t<Options>, Struct>;

// CHECKs that the value is in the field's range.
void CheckRange(double value, const Field& field);

// Checks numbers and lists of numbers.
struct FieldCheck {
  template <class T>
  void operator()(const T& value, const Field& field) const {
    if constexpr (std::is_arithmetic_v<T>) CheckRange(static_cast<double>(value), field);
  }
  template <class T>
  void operator()(const std::vector<T>& list, const Field& field) const {
    for (const T& value : list) (*this)(value, field);
  }
};

template <class Options>
void CheckFields(const Options& options) {
  VisitFields(options, FieldCheck());
}

}  // namespace drape
