// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/gnuplot.h"

#include <cstdlib>
#include <vector>

#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// What gnuplot and its fonts need, and nothing that changes what a script means: its own variables
// name start-up files, terminals and folders of scripts.
std::vector<std::string> PictureEnvironment() {
  std::vector<std::string> variables = {"LC_ALL=C"};
  for (const char* name :
       {"PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH", "XDG_CACHE_HOME", "XDG_CONFIG_HOME",
        "XDG_DATA_DIRS", "FONTCONFIG_FILE", "FONTCONFIG_PATH"})
    if (const char* value = std::getenv(name); value != nullptr)
      variables.push_back(std::string(name) + "=" + value);
  return variables;
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
    const std::size_t length = Utf8Length(text, at);
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
  const ProgramResult result = RunProgram({"gnuplot", "-d"}, script, PictureEnvironment());
  if (result.status != 0) throw InputError("gnuplot", FindMessage(result.errors));
  return result.output;
}

}  // namespace drape
