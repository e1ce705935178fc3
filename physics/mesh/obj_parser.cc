// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/obj_parser.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "physics/util/errors.h"

namespace drape {
namespace {

using Tokens = std::vector<std::string_view>;

Tokens SplitAtBlanks(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  Tokens tokens;
  for (size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;
       begin = line.find_first_not_of(kBlanks, begin)) {
    const size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    tokens.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  return tokens;
}

// Splits "a/b/c" into {a, b, c}; fields may be empty.
Tokens SplitAtSlashes(std::string_view token) {
  Tokens fields;
  for (size_t begin = 0; begin <= token.size();) {
    const size_t end = std::min(token.find('/', begin), token.size());
    fields.push_back(token.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

template <typename T>
bool ParseWhole(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::string Quoted(std::string_view text) { return std::string(1, '\'').append(text) + '\''; }

class Parser {
 public:
  Parser(const std::string& path, bool round_to_float)
      : path_(path), round_to_float_(round_to_float) {}

  ObjContent Parse(std::string_view text) {
    while (!text.empty()) {
      const size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      ParseLine(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    CheckUpperBounds();
    return std::move(content_);
  }

 private:
  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(path_ + ":" + std::to_string(line_), problem);
  }

  void ParseLine(std::string_view line) {
    const Tokens tokens = SplitAtBlanks(line.substr(0, line.find('#')));
    if (tokens.empty()) return;
    const std::string_view key = tokens[0];
    if (key == "v") {
      const auto n = ParseNumbers(tokens, 3, 3);
      content_.v.emplace_back(n[0], n[1], n[2]);
    } else if (key == "vt") {
      const auto n = ParseNumbers(tokens, 2, 3);
      content_.vt.emplace_back(n[0], n[1]);
    } else if (key == "vn") {
      ParseNumbers(tokens, 3, 3);
      ++content_.num_vn;
    } else if (key == "f") {
      ParseFace(tokens);
    } else if (key != "o" && key != "g" && key != "s" && key != "usemtl" && key != "mtllib") {
      Fail("unknown keyword " + Quoted(key) + ", expected v vt vn f o g s usemtl mtllib or #");
    }
  }

  std::array<double, 3> ParseNumbers(const Tokens& tokens, size_t min_count,
                                     size_t max_count) const {
    const size_t count = tokens.size() - 1;
    if (count < min_count || count > max_count) {
      Fail(Quoted(tokens[0]) + " has " + std::to_string(count) + " numbers, expected " +
           std::to_string(min_count) +
           (max_count > min_count ? " or " + std::to_string(max_count) : ""));
    }
    std::array<double, 3> numbers = {};
    for (size_t k = 0; k < count; ++k) numbers[k] = ParseNumber(tokens[k + 1]);
    return numbers;
  }

  double ParseNumber(std::string_view token) const {
    double value = 0;
    const bool ok = ParseWhole(token.starts_with('+') ? token.substr(1) : token, value);
    if (round_to_float_) value = static_cast<float>(value);
    if (!ok || !std::isfinite(value)) Fail(Quoted(token) + " is not a finite number");
    return value;
  }

  void ParseFace(const Tokens& tokens) {
    if (tokens.size() != 4) {
      Fail("the face has " + std::to_string(tokens.size() - 1) + " corners, expected 3");
    }
    content_.faces.push_back(
        {{ParseCorner(tokens[1]), ParseCorner(tokens[2]), ParseCorner(tokens[3])}, line_});
  }

  // A corner is written as a, a/b, a//c or a/b/c.
  ObjCorner ParseCorner(std::string_view token) const {
    const Tokens fields = SplitAtSlashes(token);
    const bool has_vt = fields.size() >= 2 && !fields[1].empty();
    if (fields.size() > 3 || (fields.size() == 2 && !has_vt)) {
      Fail("corner " + Quoted(token) + ", expected a, a/b, a//c or a/b/c");
    }
    return {ParseIndex(fields[0], content_.v.size(), token),
            has_vt ? ParseIndex(fields[1], content_.vt.size(), token) : -1,
            fields.size() == 3 ? ParseIndex(fields[2], content_.num_vn, token) : -1};
  }

  int ParseIndex(std::string_view field, int64_t count_so_far, std::string_view corner) const {
    int index = 0;
    if (!ParseWhole(field, index) || index == 0) {
      Fail("corner " + Quoted(corner) + ": " + Quoted(field) +
           " is not an index, expected a positive or negative whole number");
    }
    if (index > 0) return index - 1;
    if (-static_cast<int64_t>(index) > count_so_far) {
      Fail("corner " + Quoted(corner) + ": index " + std::to_string(index) +
           " precedes the first of " + std::to_string(count_so_far) + " entries");
    }
    return static_cast<int>(count_so_far) + index;
  }

  // Runs at the end of the file, since a face may precede its vertices.
  void CheckUpperBounds() {
    for (const ObjFace& face : content_.faces) {
      line_ = face.line;
      for (const ObjCorner& corner : face.corner) {
        CheckUpperBound("v", corner.v, content_.v.size());
        CheckUpperBound("vt", corner.vt, content_.vt.size());
        CheckUpperBound("vn", corner.vn, content_.num_vn);
      }
    }
  }

  void CheckUpperBound(const std::string& key, int index, int64_t count) const {
    if (index >= count) {
      Fail(key + " index " + std::to_string(index + 1) + ", but the file has " +
           std::to_string(count) + " '" + key + "' lines");
    }
  }

  const std::string& path_;
  const bool round_to_float_;
  ObjContent content_;
  int line_ = 0;
};

}  // namespace

ObjContent ParseObj(std::string_view text, const std::string& path, bool round_to_float) {
  return Parser(path, round_to_float).Parse(text);
}

}  // namespace drape
