// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

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

// An enum, which a user writes by the names of its values (Field::choices).
struct EnumField {
  std::function<std::string()> name;
  std::function<void(const std::string&)> set;
};

struct FieldRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;  // the least itself is excluded

  bool Contains(double value) const {
    return (above_least ? value > least : value >= least) && value <= most;
  }
};

// The description of an option: a field of an options struct, or an option of one program alone.
// Such a struct has, beside it,
//   template <MutableOrConst<MyOptions> Options, class Visitor>
//   void VisitFields(Options& options, Visitor&& visit) {
//     auto& [a, b] = options;  // a field that is missing here does not compile
//     visit(a, Field{.key = "a", .doc = "…"});
//     …
// from which follow its check (CheckFields), its place in the key of a checkpoint, and its options
// on a command line. The struct's own initialisers are the defaults.
struct Field {
  using Value = std::variant<std::string*, int*, double*, bool*, std::vector<int>*,
                             std::vector<double>*, std::vector<std::string>*, EnumField>;

  std::string key = {};
  // Points to what holds the default before a command line is read and the user's choice after it.
  // VisitFields leaves it out.
  Value value = {};
  std::string doc = {};   // one line, for --help
  std::string unit = {};  // empty: none
  FieldRange range = {};  // of a number or of each in a list
  // Most users' values (CheckUsual); 0, where it is allowed, is never unusual.
  double usual_least = -std::numeric_limits<double>::infinity();
  double usual_most = std::numeric_limits<double>::infinity();
  bool is_option = true;                  // on the command line
  bool in_key = true;                     // of a checkpoint: another value is another fit
  std::vector<std::string> choices = {};  // of a text; empty: any text
  // A text is a path: relative to the folder of the config file that holds it, or, on the command
  // line, to the working directory.
  bool is_path = false;
  // Texts that are no paths: "flat", or, with a colon, a prefix.
  std::vector<std::string> words = {};
  // The folder of configs/ whose files a name without a slash or dot stands for; empty: none.
  std::string presets = {};
  bool required = false;  // no default: the user must give it
  // A repetition of a run takes it from the summary; false: where and how one run is made, such as
  // the paths of its results.
  bool repeated = true;
  std::string group = {};  // heading in --help=all; empty: "options"
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
