// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {
namespace {

std::string Utf16(const std::string& text) {
  std::string wide = "\xff\xfe";
  for (const char c : text) {
    wide += c;
    wide += '\0';
  }
  return wide;
}

std::string Nested(const std::string& open, const std::string& close, int depth) {
  std::string text;
  for (int i = 0; i < depth; ++i) text += open;
  for (int i = 0; i < depth; ++i) text += close;
  return text;
}

// The members of an object with one more in front.
std::string WithMember(const std::string& text, const std::string& member) {
  const auto at = text.find('{');
  return text.substr(0, at + 1) + member + ", " + text.substr(at + 1);
}

}  // namespace

std::string ReadText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<BadFile> MakeChanged(const std::string& path, const std::vector<Change>& changes) {
  using nlohmann::json;
  const json valid = json::parse(ReadText(path), nullptr, true, true);
  std::vector<BadFile> files;
  for (const Change& change : changes) {
    json changed = valid;
    const json::json_pointer pointer(change.pointer);
    if (!change.value.empty()) {
      changed[pointer] = json::parse(change.value);
    } else if (valid.at(pointer.parent_pointer()).is_array()) {
      changed[pointer.parent_pointer()].erase(std::stoul(pointer.back()));
    } else {
      changed[pointer.parent_pointer()].erase(pointer.back());
    }
    files.push_back(
        {change.pointer + " = " + change.value, changed.dump(), change.refused, change.named});
  }
  return files;
}

std::vector<BadFile> MakeBadJson(const std::string& valid_text) {
  const std::string compact = nlohmann::json::parse(valid_text, nullptr, true, true).dump();
  return {{"empty", ""},
          {"blanks", " \n\t "},
          {"null", "null"},
          {"number", "1"},
          {"text", "\"x\""},
          {"list", "[]"},
          {"lists", "[[[]]]"},
          {"unknown key", WithMember(compact, "\"no such key\": 1")},
          {"escape codes in a key", WithMember(compact, "\"\\u001b[31m\\nred\": 1")},
          {"raw escape code in a key", WithMember(compact, "\"\x1b[31m\": 1")},
          {"a long key", WithMember(compact, "\"" + std::string(5000, 'k') + "\": 1")},
          {"no UTF-8 in a key", WithMember(compact, "\"\xff\xfe\": 1")},
          {"text direction in a key", WithMember(compact, "\"\\u202e\": 1")},
          {"a key twice", WithMember(compact, "\"a\": 1, \"a\": 2")},
          {"half", compact.substr(0, compact.size() / 2)},
          {"last byte missing", compact.substr(0, compact.size() - 1)},
          {"twice", compact + compact},
          {"text after it", compact + " x"},
          {"NUL before it", std::string(1, '\0') + compact},
          {"NUL and text after it", compact + std::string(1, '\0') + "x"},
          {"UTF-16", Utf16(compact)},
          {"BOM", "\xef\xbb\xbf" + compact, false},
          {"BOM twice", "\xef\xbb\xbf\xef\xbb\xbf" + compact},
          {"NaN", WithMember(compact, "\"a\": NaN")},
          {"1e999", WithMember(compact, "\"a\": 1e999")},
          {"a number of 100000 digits", WithMember(compact, "\"a\": " + std::string(100000, '9'))},
          {"decimal comma", WithMember(compact, "\"a\": 1,5")},
          {"lists 300000 deep", Nested("[", "]", 300000)},
          {"objects 300000 deep", Nested("{\"a\":", "}", 300000)},
          {"open lists 300000 deep", std::string(300000, '[')},
          {"an endless comment", "/* " + compact},
          {"binary", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)},
          {"a megabyte of blanks", std::string(1 << 20, ' ')}};
}

}  // namespace drape::attack
