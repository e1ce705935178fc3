// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

namespace drape::test {

// Damage to stored files, by rule and at random.

// How many mutants a test tries: `usual`, or what the environment variable DRAPE_MUTANTS says.
inline int NumMutants(int usual) {
  const char* wanted = std::getenv("DRAPE_MUTANTS");
  return wanted == nullptr ? usual : std::atoi(wanted);
}

// One to three random edits of bytes: one changed, put in, taken out, or a part of the text
// doubled.
inline std::string Mutant(std::string text, std::mt19937_64& random) {
  static const std::string kLikely = "0123456789-+.eE,:[]{}\"\\ntfu \n";
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (std::size_t edits = 1 + below(3); edits > 0 && !text.empty(); --edits) {
    const std::size_t at = below(text.size());
    const char c = below(4) == 0 ? static_cast<char>(random()) : kLikely[below(kLikely.size())];
    switch (below(5)) {
      case 0:
        text.erase(at, 1 + below(20));
        break;
      case 1:
        text.insert(at, 1, c);
        break;
      case 2:
        text.insert(below(text.size()), text.substr(at, 1 + below(200)));
        break;
      default:
        text[at] = c;
    }
  }
  return text;
}

// Calls visit(what, tampered) for each member of a document, in turn of another type, negative,
// missing, with one too many or too few. Of arrays of numbers only the ends are changed. Each
// `step`-th is visited, from the one of number `first`; without a visitor they are only counted.
class Tampering {
 public:
  using Visit = std::function<void(const std::string& what, const nlohmann::json& tampered)>;

  explicit Tampering(nlohmann::json document, Visit visit = {}, std::size_t first = 0,
                     std::size_t step = 1)
      : document_(std::move(document)), visit_(std::move(visit)), first_(first), step_(step) {
    Walk(nlohmann::json::json_pointer());
  }
  std::size_t size() const { return size_; }  // without regard to `step`

 private:
  using Pointer = nlohmann::json::json_pointer;

  void Try(const Pointer& at, const nlohmann::json& value) {
    if (size_++ % step_ != first_ || !visit_) return;
    nlohmann::json tampered = document_;
    tampered[at] = value;
    visit_(at.to_string() + " = " + value.dump().substr(0, 60), tampered);
  }

  void Walk(const Pointer& at) {
    const nlohmann::json value = document_[at];
    if (!at.empty()) {
      for (const nlohmann::json& other : {nlohmann::json(), nlohmann::json("x"),
                                          nlohmann::json::object(), nlohmann::json::array()})
        if (other.type() != value.type() || value.size() > 0) Try(at, other);
      if (!value.is_string())
        Try(at, value.is_boolean() ? nlohmann::json(1) : nlohmann::json(true));
      if (value.is_number()) Try(at, -1);
    }
    if (value.is_object()) WalkObject(at, value);
    if (value.is_array()) WalkArray(at, value);
  }

  void WalkObject(const Pointer& at, const nlohmann::json& value) {
    nlohmann::json more = value;
    more["one_more"] = 1;
    Try(at, more);
    for (const auto& [key, member] : value.items()) {
      nlohmann::json fewer = value;
      fewer.erase(key);
      Try(at, fewer);
      Walk(at / key);
    }
  }

  void WalkArray(const Pointer& at, const nlohmann::json& value) {
    if (value.empty()) return;
    nlohmann::json more = value, fewer = value;
    more.push_back(value.back());
    Try(at, more);
    fewer.erase(fewer.size() - 1);
    Try(at, fewer);
    const bool ends_only = value.front().is_number() && value.size() > 5;
    for (std::size_t i = 0; i < value.size(); ++i)
      if (!ends_only || i == 0 || i + 1 == value.size()) Walk(at / i);
  }

  nlohmann::json document_;
  Visit visit_;
  std::size_t first_, step_, size_ = 0;
};

// Without the flush to the disk of WriteFileAtomically, for thousands of files.
inline void WriteQuickly(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

}  // namespace drape::test
