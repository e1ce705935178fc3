// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/gnuplot.h"

#include "physics/util/child_process.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

// The length in bytes of the UTF-8 character at `at`; 0 where there is none.
std::size_t CharacterLength(const std::string& text, std::size_t at) {
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

// The line that names the problem comes after an echo of the command.
std::string FindMessage(const std::string& errors) {
  std::size_t begin = errors.rfind("line ");
  if (begin == std::string::npos) begin = errors.find_first_not_of(" \n\t^");
  if (begin == std::string::npos) return "failed without a message";
  return errors.substr(begin, errors.find('\n', begin) - begin);
}

}  // namespace

std::string QuoteForGnuplot(const std::string& text) {
  constexpr unsigned char kBlank = ' ', kDelete = 0x7f;
  std::string quoted = "'";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = CharacterLength(text, at);
    const unsigned char c = static_cast<unsigned char>(text[at]);
    if (length == 0) {
      quoted += '?';
    } else if (c < kBlank || c == kDelete) {
      quoted += ' ';
    } else if (c == '\'') {
      quoted += "’";  // gnuplot 5.4 takes a doubled quote at the start for an empty text
    } else {
      quoted.append(text, at, length);
    }
    at += length == 0 ? 1 : length;
  }
  return quoted + "'";
}

std::string RunGnuplot(const std::string& script) {
  const ProgramResult result = RunProgram({"gnuplot", "-d"}, script);
  if (result.status != 0) throw InputError("gnuplot", FindMessage(result.errors));
  return result.output;
}

}  // namespace drape
