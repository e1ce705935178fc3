// SPDX-License-Identifier: Apache-2.0
#include "physics/util/text_format.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace drape {
namespace {

template <class T>
void AppendPrinted(std::string& text, const std::string& conversion, T value) {
  const int size = std::snprintf(nullptr, 0, conversion.c_str(), value);
  if (size < 0) return;
  const std::size_t begin = text.size();
  text.resize(begin + size + 1);
  std::snprintf(text.data() + begin, size + 1, conversion.c_str(), value);
  text.pop_back();  // the end of the C string
}

// A list that functions can share.
struct Arguments {
  va_list list;
};

// A number that is not finite keeps the alignment and the width of the conversion.
void AppendDouble(std::string& text, const std::string& conversion, double value) {
  if (std::isfinite(value)) return AppendPrinted(text, conversion, value);
  const std::size_t width = conversion.find_first_not_of("%-+ #0");
  const std::size_t end = conversion.find_first_not_of("0123456789", width);
  const bool left = conversion.find('-') != std::string::npos;
  AppendPrinted(text, (left ? "%-" : "%") + conversion.substr(width, end - width) + "s", "none");
}

// Appends the argument of a conversion of a printf format, such as "%-*.3ld".
void AppendConversion(std::string& text, std::string conversion, Arguments& arguments) {
  for (std::size_t star; (star = conversion.find('*')) != std::string::npos;)
    conversion.replace(star, 1, std::to_string(va_arg(arguments.list, int)));
  switch (conversion.back()) {
    case '%':
      text += '%';
      break;
    case 's':
      AppendPrinted(text, conversion, va_arg(arguments.list, const char*));
      break;
    case 'p':
      AppendPrinted(text, conversion, va_arg(arguments.list, void*));
      break;
    case 'c':
    case 'd':
    case 'i':
    case 'u':
    case 'x':
    case 'X':
    case 'o':
      // long long, long, size_t and ptrdiff_t are passed alike.
      if (conversion.find_first_of("lzjt") != std::string::npos) {
        AppendPrinted(text, conversion, va_arg(arguments.list, std::intmax_t));
      } else {
        AppendPrinted(text, conversion, va_arg(arguments.list, int));
      }
      break;
    default:
      AppendDouble(text, conversion, va_arg(arguments.list, double));
  }
}

// Leaves out the middle of a text of UTF-8 characters that is longer than `most` bytes.
std::string Shorten(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  const auto is_inside = [&](std::size_t at) { return (text[at] & 0xc0) == 0x80; };
  std::size_t head = 2 * most / 3, tail = text.size() - most / 4;
  while (head > 0 && is_inside(head)) --head;
  while (tail < text.size() && is_inside(tail)) ++tail;
  return std::string(text.substr(0, head)).append("…").append(text.substr(tail));
}

// Whether a terminal may act on the character instead of showing it: C0 and C1 controls, and the
// marks of bidirectional text.
bool IsControl(std::string_view character) {
  const auto c = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return c < 0x20 || c == 0x7f;
  if (character.size() == 2) return character[0] == '\xc2' && (character[1] & 0xe0) == 0x80;
  return (character >= "\u202a" && character <= "\u202e") ||
         (character >= "\u2066" && character <= "\u2069");
}

std::string EscapeControls(std::string_view text) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = std::max<std::size_t>(1, Utf8Length(text, at));
    const std::string_view character = text.substr(at, length);
    const bool layout = character == "\n" || character == "\t";
    if (!layout && (Utf8Length(text, at) == 0 || IsControl(character))) {
      for (const char byte : character)
        shown += Format("\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
    } else {
      shown += character;
    }
    at += length;
  }
  return shown;
}

std::string ShellWord(const std::string& word) {
  constexpr char kPlain[] =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted;
  for (std::size_t i = 0, length = 0; i < word.size(); i += length) {
    length = std::max<std::size_t>(1, Utf8Length(word, i));
    const std::string character = word.substr(i, length);
    const bool is_shown = Utf8Length(word, i) > 0 && MakePrintableLine(character) == character;
    if (character == "'") {
      quoted += "'\\''";
    } else if (is_shown && character != "\t") {
      quoted += character;
    } else {
      for (const char byte : character)
        quoted += Format("'$'\\x%02x''", static_cast<unsigned char>(byte));
    }
  }
  return "'" + quoted + "'";
}

}  // namespace

std::string Format(const char* format, ...) {
  Arguments arguments;
  va_start(arguments.list, format);
  std::string text;
  for (const char* at = format; *at != 0;) {
    if (*at != '%') {
      text += *at++;
    } else {
      const char* type = at + 1 + std::strspn(at + 1, "-+ #0123456789.*hlzjt");
      AppendConversion(text, std::string(at, type + 1), arguments);
      at = type + 1;
    }
  }
  va_end(arguments.list);
  return text;
}

std::string FormatBeyond(double value, double limit, int decimals) {
  constexpr int kMost = 12;
  const std::string text = Format("%.*f", decimals, value);
  return decimals >= kMost || Format("%.*f", decimals, limit) != text
             ? text
             : FormatBeyond(value, limit, decimals + 1);
}

std::string ShellLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + ShellWord(word);
  return line;
}

std::size_t Utf8Length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(at), second = byte(at + 1);
  if (first < 0x80) return 1;
  if (first < 0xc2 || first > 0xf4) return 0;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool no_character = (first == 0xed && second >= 0xa0) || (first == 0xf4 && second >= 0x90);
  return overlong || no_character ? 0 : length;
}

bool IsUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string MakePrintable(std::string_view text) {
  constexpr std::size_t kLongestWord = 200;
  const std::string shown = EscapeControls(text);
  std::string printable;
  for (std::size_t at = 0; at < shown.size();) {
    const std::size_t end = std::min(shown.find_first_of(" \n\t", at), shown.size());
    printable += Shorten(std::string_view(shown).substr(at, end - at), kLongestWord);
    if (end < shown.size()) printable += shown[end];
    at = end + 1;
  }
  return printable;
}

std::string MakePrintableLine(std::string_view text) {
  constexpr std::size_t kLongestLine = 390;
  std::string line(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return Shorten(MakePrintable(line), kLongestLine);
}

}  // namespace drape
