// SPDX-License-Identifier: Apache-2.0
// All programs in one executable: drapefit VERB, or a link drape_VERB to it, runs one of them, and
// drapefit PICTURE all steps to a report.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "physics/util/errors.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"
#include "tools/cli/tool_main.h"
#include "tools/programs/front/programs.h"
#include "tools/programs/front/short_way.h"

namespace drape {
namespace {

constexpr char kUsage[] =
    "usage: drapefit VERB [options]          runs drape_VERB\n"
    "       drapefit help VERB               its options\n"
    "       drapefit PICTURE --mass=G_PER_M2 from a photograph of a drape to a report: photo, "
    "fit,\n"
    "                                        predict, report (options: drapefit --help=all)\n";

int Fail(const std::string& message) {
  std::fprintf(stderr, "drapefit: error: %s\n", MakePrintableLine(message).c_str());
  return kExitBadInput;
}

// Returns whether the program is here. A build may leave out one with an executable of its own.
bool IsHere(const Program& program, const std::string& folder) {
  return program.main != nullptr || HasProgram(folder, program.verb);
}

int ShowVerbs(const std::string& folder) {
  std::string text =
      "drapefit " + BuildVersion() + ": stiffness of fabrics from drapes\n\n" + kUsage;
  std::string task;
  for (const Program& program : Programs()) {
    if (!IsHere(program, folder)) continue;
    if (task != program.task) text += "\n" + (task = program.task) + ":\n";
    text += Format("  %-20s  %s\n", program.verb, program.summary);
  }
  std::fputs(text.c_str(), stdout);
  return std::fflush(stdout) == 0 ? kExitOk : Fail("stdout: cannot be written");
}

// `words`: the command line of the program after its name. A program with an executable of its own
// replaces this one.
int RunProgram(const Program& program, const std::string& folder, std::vector<std::string> words) {
  const std::string path = ProgramPath(folder, program.verb);
  words.insert(words.begin(), path);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (program.main != nullptr)
    return program.main(static_cast<int>(words.size()), arguments.data());
  execv(path.c_str(), arguments.data());
  throw InputError(path, std::string("cannot be run: ") + std::strerror(errno));
}

int FailUnknown(const std::string& verb, const std::string& folder) {
  std::vector<std::string> names = {"help"};
  for (const Program& program : Programs())
    if (IsHere(program, folder)) names.push_back(program.verb);
  const std::string nearest = SuggestName(verb, names);
  return Fail("command line: unknown verb '" + verb + "'" +
              (nearest.empty() ? "" : ", did you mean '" + nearest + "'?") +
              " (drapefit --help lists all)");
}

int RunPicture(int argc, char** argv, const std::string& folder) {
  ShortWayOptions options;
  if (ParseCommandLine(ShortWayTable(options), argc, argv) == ParseOutcome::kHelpShown)
    return kExitOk;
  return RunShortWay(options, folder);
}

// Returns whether a word names a picture rather than a verb: it has a dot or slash, or is a file.
bool IsPicture(const std::string& word) {
  return word.starts_with("-") || word.find_first_of("./") != std::string::npos ||
         std::filesystem::exists(word);
}

int Run(int argc, char** argv) {
  constexpr char kPrefix[] = "drape_";
  const std::string name = std::filesystem::path(argv[0]).filename();
  if (name.starts_with(kPrefix)) {
    const Program* program = FindProgram(name.substr(std::size(kPrefix) - 1));
    if (program != nullptr && program->main != nullptr) return program->main(argc, argv);
  }
  const std::string folder = ProgramFolder();
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool help = !words.empty() && words[0] == "help";
  if (words.empty() || words[0] == "--help" || words[0] == "-h" ||
      (help && (words.size() == 1 || words[1] == "help")))
    return ShowVerbs(folder);
  if (help) {
    words.erase(words.begin());
    words.insert(words.begin() + 1, "--help");
  }
  const std::string verb = words[0];
  const Program* program = FindProgram(verb);
  if (program != nullptr && IsHere(*program, folder))
    return RunProgram(*program, folder, {words.begin() + 1, words.end()});
  if (!help && IsPicture(verb)) return RunPicture(argc, argv, folder);
  return FailUnknown(verb, folder);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  try {
    return drape::Run(argc, argv);
  } catch (const std::exception& error) {
    return drape::Fail(error.what());
  }
}
